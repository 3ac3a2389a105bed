# SPDX-License-Identifier: BSD-3-Clause
"""Clients of streams in a process of their own, which can be killed: `python3 -m rows.takers fields|samples ENDPOINT ...` from tests/torture."""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import numpy as np  # noqa: E402
import zmq  # noqa: E402
from streaming import Taker, sb  # noqa: E402

LIVE_S = 600  # the longest, if nobody ends it
WAY_BACK_S = 60  # in which nothing comes that one has not had
CREDIT = 8 << 20


def take_fields(endpoint: str, count: int, hertz: float) -> None:
    wishes = [sb.FieldWish(name="position"), sb.FieldWish(name="pressure")]
    poller, streams, had = zmq.Poller(), {}, set()
    for _ in range(count):
        taker = Taker(endpoint)
        reply = taker.subscribe(fields=sb.FieldStream(fields=wishes), when=sb.When(max_hz=hertz, first=True), credit=CREDIT)
        streams[taker.socket] = taker, reply.stream
        poller.register(taker.socket, zmq.POLLIN)
    told, until = False, time.monotonic() + LIVE_S
    while time.monotonic() < until:
        for socket, _ in poller.poll(1000):
            taker, stream = streams[socket]
            taker.grant(stream, sum(len(frame) for frame in socket.recv_multipart(copy=False)))
            had.add(stream)
        if len(had) == count and not told:
            told = True
            print("ready", flush=True)


def take_samples(endpoint: str, place: str, rows: int) -> None:
    """Write what came, and the cursor behind it, as records that Cursor of streams.py reads."""
    begin = sb.Cursor.FromString(bytes.fromhex(place)) if place != "-" else None
    taker = Taker(endpoint)
    until = time.monotonic() + LIVE_S
    wish = sb.Subscribe(probes=sb.ProbeStream(), delivery=sb.LOSSLESS, credit=CREDIT, **{"from": begin})
    while (reply := taker.ask(subscribe=wish)).code:  # a daemon that was killed has no run yet
        time.sleep(0.05)
    stream = reply.stream
    while rows > 0 and time.monotonic() < until:
        before = taker.received
        item = taker.item(WAY_BACK_S)
        times = item.array("time") if item.head.arrays else np.empty(0)
        keep = item.head.abandoned.row if item.head.HasField("abandoned") else -1
        cursor = item.last.next.SerializeToString()
        sys.stdout.buffer.write(np.array([keep, len(cursor), len(times)], "<i8").tobytes() + cursor + times.astype("<f8").tobytes())
        sys.stdout.buffer.flush()
        taker.grant(stream, taker.received - before)
        rows -= len(times)


if __name__ == "__main__":
    kind, where, *rest = sys.argv[1:]
    if kind == "fields":
        take_fields(where, int(rest[0]), float(rest[1]))
    else:
        take_samples(where, rest[0], int(rest[1]))

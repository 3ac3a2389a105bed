# SPDX-License-Identifier: BSD-3-Clause
"""Those who all want to write, those who write nonsense, and those who only knock."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass, field
from typing import Iterator

import zmq
from daemon import free_ports

from .latency import Line
from .live import Daemon, beside, computing, told
from .metrics import Metric, Size, all_of, none_of

from meniscus import meniscus_pb2 as pb  # isort: skip

TTL_MS, CHANGES, FORGETS = 300, 5, 0.2
RATE = 10_000  # half-open handshakes a second


@dataclass
class Writer:
    """One who takes the lease when it can, changes the run some times, and gives the lease back or forgets to."""

    line: Line
    name: str
    chance: random.Random
    epoch: int = 0
    left: int = 0
    sent: set[bytes] = field(default_factory=set)

    def act(self) -> None:
        self.sent = set()
        if not self.epoch:
            self.sent.add(self.line.send(lease=pb.Lease(ttl_ms=TTL_MS, holder=self.name)))
        elif self.left > 0:
            self.left -= 1
            value = str(100 + self.chance.random())
            self.sent.add(self.line.send(lease_epoch=self.epoch, set=pb.Set(assignments=[pb.Assignment(path="end_time", value=value)])))
        elif self.chance.random() < FORGETS:
            self.epoch = 0  # and lets it run out
            self.act()
        else:
            self.sent.add(self.line.send(lease_epoch=self.epoch, lease=pb.Lease(release=True)))
            self.epoch = 0


def writers(size: Size) -> Iterator[Metric]:
    """Each change is one more version of the case, so the versions tell who wrote between whom: under an epoch they follow each other
    without a gap, and no lower epoch comes after a higher one."""
    written: list[tuple[int, int]] = []  # version, epoch
    refused = leases = 0
    with Daemon() as daemon, daemon.client() as client, zmq.Context() as context:
        client.load("dambreak2d", {"resolution": 20, "end_time": 1e4, "threads": 1}, start=True)
        poller = zmq.Poller()
        everybody = {}
        for k in range(size.writers):
            writer = Writer(Line(context, daemon.endpoint), f"writer {k}", random.Random(k))
            everybody[writer.line.socket] = writer
            poller.register(writer.line.socket, zmq.POLLIN)
            writer.act()
        until = time.monotonic() + 2 * size.seconds
        while time.monotonic() < until:
            for socket, _ in poller.poll(1000):
                writer = everybody[socket]
                reply = writer.line.receive()
                if reply.id not in writer.sent:
                    continue
                if reply.code != pb.OK:
                    refused += 1
                    writer.epoch = 0
                elif reply.HasField("lease") and reply.lease.epoch and not writer.epoch:
                    leases += 1
                    writer.epoch, writer.left = reply.lease.epoch, CHANGES
                elif writer.epoch:
                    written.append((reply.case_version, writer.epoch))
                writer.act()
        for writer in everybody.values():
            writer.line.socket.close()
        alive = client.status().state
    written.sort()
    epochs = [epoch for _, epoch in written]
    yield none_of("changes under a lease that was over by then", sum(b < a for a, b in zip(epochs, epochs[1:])))
    yield none_of("changes by somebody else in the midst of a lease",
                  sum(b[1] == a[1] and b[0] != a[0] + 1 for a, b in zip(written, written[1:])))
    yield none_of("versions that two have written", len(written) - len({version for version, _ in written}))
    yield Metric("leases given", leases, low=2, note=f"{size.writers} writers, {len(written)} changes, {refused} refused, {alive} at the end")


def handshakes(size: Size) -> Iterator[Metric]:
    """The attacker and the run have the same processors as the client that waits."""
    port = free_ports()
    with Daemon("--listen", f"tcp://127.0.0.1:{port}") as daemon:
        yield from _handshakes(daemon, port, size)


def _handshakes(daemon: Daemon, port: int, size: Size) -> Iterator[Metric]:
    with daemon.client() as client:
        computing(client, size.resolution)
        with beside("half_open", port, RATE, 2 * size.seconds) as attacker:
            waits = told("round_trips", daemon.endpoint, size.seconds, 0.5)
            said, _ = attacker.communicate()
        begun = int(said.split(":")[1].strip("}\n ")) / (2 * size.seconds)
        yield Metric("half-open handshakes begun", begun, "1/s", low=0.9 * RATE)
        yield Metric("status among them, all processors computing, 99 %", waits["p99_ms"], "ms", high=2)
        yield Metric("the same, 99.9 %", waits["p999_ms"], "ms", high=10)
        yield all_of("a healthy client after it", int(client.status().state == "RUNNING"), 1)

# SPDX-License-Identifier: BSD-3-Clause
"""How long one waits: for a status, while all processors compute and while none does; for a pause, behind a queue; for a time to come."""

from __future__ import annotations

import os
import random
import threading
import time
from typing import Iterator

import zmq

from .live import Daemon, computing, meniscus, told
from .metrics import Metric, Size, all_of

from meniscus import meniscus_pb2 as pb  # isort: skip


def status(size: Size) -> Iterator[Metric]:
    with Daemon() as daemon, daemon.client() as client:
        idle = told("round_trips", daemon.endpoint, size.seconds, 0)
        bare = told("round_trips", "echo", size.seconds, 0)
        yield Metric("status of an idle daemon, 99 %", idle["p99_ms"], "ms", high=0.15, note=f"{idle['n']} times")
        yield Metric("of that, an echo of ZeroMQ and nothing else, 99 %", bare["p99_ms"], "ms")
        computing(client, size.resolution)
        busy = told("round_trips", daemon.endpoint, 4 * size.seconds, 8)  # asked less often than the pace of questions allows
        yield Metric("status while all processors compute, 99 %", busy["p99_ms"], "ms", high=2, note=f"{busy['n']} times")
        yield Metric("the same, 99.9 %", busy["p999_ms"], "ms", high=10)
        yield Metric("the longest", busy["max_ms"], "ms")


class Line:
    """A connection to a control socket on which requests may be under way side by side."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", endpoint: str) -> None:
        self.socket = context.socket(zmq.DEALER)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.setsockopt(zmq.SNDHWM, 0)
        self.socket.setsockopt(zmq.RCVHWM, 0)
        self.socket.connect(endpoint)

    def send(self, **command: object) -> bytes:
        request = pb.Request(major=1, id=os.urandom(16), **command)  # type: ignore[arg-type]
        self.socket.send(request.SerializeToString())
        return request.id

    def receive(self, seconds: float = 60) -> pb.Reply:
        if not self.socket.poll(1000 * seconds):
            raise TimeoutError("a request was not answered")
        return pb.Reply.FromString(self.socket.recv_multipart()[0])

    def waiting(self) -> int:
        """How many replies have come and were not taken; they are taken."""
        n = 0
        while self.socket.poll(0):
            self.socket.recv_multipart()
            n += 1
        return n


def _queue(line: Line, n: int) -> None:
    """Commands for the next step boundaries: each hundredth changes something and goes to the disk."""
    for k in range(n):
        if k % 100:
            line.send(query=pb.Query(probes=pb.ProbeQuery(names=["P05"])))
        else:
            line.send(set=pb.Set(assignments=[pb.Assignment(path="gravity", value=f"[0, {-1 - 1e-6 * k}]")]))


def pause(size: Size) -> Iterator[Metric]:
    """The pause and a status leave together, and the daemon takes them in this order: the status tells a step that was done when the
    pause had come, so that the first boundary after it is at most one step later."""
    at_once, queued, waits = 0, [], []
    with Daemon() as daemon, daemon.client() as client, zmq.Context() as context:
        computing(client, size.resolution)
        crowd, urgent = Line(context, daemon.endpoint), Line(context, daemon.endpoint)
        for _ in range(size.pauses):
            time.sleep(random.uniform(0, 0.03))
            _queue(crowd, size.queued)
            began = time.monotonic()
            paused_id = urgent.send(pause=pb.Pause())
            urgent.send(status=pb.GetStatus())
            replies = [urgent.receive(), urgent.receive()]
            waits.append(time.monotonic() - began)
            answered = crowd.waiting()
            paused, seen = replies if replies[0].id == paused_id else reversed(replies)
            at_once += paused.code == pb.OK and paused.state == pb.PAUSED and paused.effect_step <= seen.status.step + 1
            queued.append(size.queued - answered)
            for _ in range(size.queued - answered):
                crowd.receive()
            client.resume()
        crowd.socket.close()
        urgent.socket.close()
    yield all_of("pauses at the first step boundary after they came", at_once, size.pauses)
    yield Metric("commands still queued when a pause was answered, mean", sum(queued) / len(queued), note=f"of {size.queued} sent before")
    yield Metric("from a pause to its answer, the longest", 1e3 * max(waits), "ms")


def run_until(size: Size) -> Iterator[Metric]:
    """To random times, while another client asks, changes and writes."""
    exact = ended = 0
    over = threading.Event()
    with Daemon() as daemon, daemon.client() as client, daemon.client() as other:
        client.load("dambreak2d", {"resolution": 20, "end_time": 1e4, "threads": 1})
        disturber = threading.Thread(target=_disturb, args=(other, over))
        disturber.start()
        try:
            at = 0.0
            for _ in range(size.runs_until):
                at += random.uniform(1e-6, 0.02)
                reply = client.run_until(at)
                ended += reply.state == "PAUSED"
                exact += reply.time == at
        finally:
            over.set()
            disturber.join()
    yield all_of("runs to a time that end there, to the last bit", exact, size.runs_until)
    yield all_of("runs to a time that other commands leave alone", ended, size.runs_until)


def _disturb(client: meniscus.Client, over: threading.Event) -> None:
    acts = (client.status, client.query, client.capabilities, lambda: client.set({"gravity": [0, -random.uniform(0.9, 1.1)]}),
            lambda: client.breakpoint("far", time=1e5), client.checkpoint, lambda: client.snapshot(["pressure"]))
    while not over.is_set():
        random.choice(acts)()
        time.sleep(random.uniform(0, 0.01))

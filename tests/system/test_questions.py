#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Questions, large and many: they take little of the solver's time, and each is answered."""

import os
import sys
import threading
import time
import unittest
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, control_socket  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import meniscus_pb2 as pb  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=20", "--set", "end_time=1000", "--set", "threads=1"]
POINTS = [(5.3 * (k % 250) / 250, 3 * (k // 250) / 200) for k in range(50_000)]
ROUNDS, VIEWERS, PROMISED = 3, 2, 0.1
PACE, WAITING = 200, 1024  # questions of this machine in a second, of one connection that wait: of the protocol's page


class Questions(DaemonTest):
    @property
    def address(self) -> str:
        return f"ipc://{control_socket(self.home)}"

    def look(self, until: threading.Event, answered: "list[int]", problems: "list[BaseException]") -> None:
        try:
            with meniscus.Client(self.address, timeout=120) as viewer:
                while not until.is_set():
                    answered.append(len(viewer.points("pressure", POINTS)))
        except BaseException as problem:  # told where the test is
            problems.append(problem)

    def spent(self) -> "tuple[float, float]":
        """Seconds of a run in motion that did not go into steps, and all of them, by the daemon's own clock."""
        status = self.ask("status")
        return next(timer["seconds"] for timer in status["timers"] if timer["name"] == "between steps"), status["wall_s"]

    def test_two_viewers_leave_the_solver_its_time(self) -> None:
        self.meniscus("load", *CASE, "--start")
        end = threading.Event()
        answered: "list[int]" = []
        problems: "list[BaseException]" = []
        viewers = [threading.Thread(target=self.look, args=(end, answered, problems)) for _ in range(VIEWERS)]
        for viewer in viewers:
            viewer.start()
        try:
            self.wait_until(lambda: bool(answered or problems))
            last, begun = len(answered) + ROUNDS, self.spent()
            self.wait_until(lambda: len(answered) >= last or bool(problems), 120)
            ended = self.spent()
        finally:
            end.set()
            for viewer in viewers:
                viewer.join()
        self.assertEqual(problems, [])
        self.assertEqual(set(answered), {len(POINTS)})
        self.assertLess((ended[0] - begun[0]) / (ended[1] - begun[1]), 2 * PROMISED)  # there is one more than rounds, and outputs

    def ask_raw(self, n_points: int, n_dimensions: int = 2) -> Any:
        """Without a library that refuses it by itself."""
        with self.wire() as wire:
            ask(wire, query=pb.Query(points=pb.PointQuery(field="pressure", points=[0.5] * (n_points * n_dimensions))))
            return answer(wire)

    def test_too_many_points_get_an_answer(self) -> None:
        self.meniscus("load", *CASE)
        self.assertEqual(self.ask_raw(57_000).code, pb.OK)
        refused = self.ask_raw(57_001)
        self.assertEqual(refused.code, pb.RESOURCE_EXHAUSTED)
        self.assertIn("at most 57000 points at a time in 2 dimensions, found 57001", refused.message)
        longer = self.ask_raw(100_000)
        self.assertEqual(longer.code, pb.RESOURCE_EXHAUSTED)
        self.assertIn("a request may have 1048576 bytes", longer.message)

    @contextmanager
    def wire(self) -> "Iterator[zmq.Socket[bytes]]":
        with zmq.Context() as context, context.socket(zmq.DEALER) as wire:
            wire.linger = 0
            wire.connect(self.address)
            yield wire

    def count(self, question: "dict[str, Any]", in_flight: int, seconds: float = 2) -> int:
        """Answers in that time to one who asks again for each."""
        n, end = 0, time.monotonic() + seconds
        with self.wire() as wire:
            for _ in range(in_flight):
                ask(wire, **question)
            while time.monotonic() < end:
                if wire.poll(100):
                    self.assertEqual(answer(wire).code, pb.OK)
                    n += 1
                    ask(wire, **question)
        return n

    def test_questions_have_a_pace_however_many_are_in_flight(self) -> None:
        self.meniscus("load", *CASE, "--start")
        for in_flight in (1, 60, 400):
            self.assertLess(self.count({"query": pb.Query(probes=pb.ProbeQuery())}, in_flight), 2.5 * PACE + 50, in_flight)

    def test_long_questions_have_it_too(self) -> None:
        self.meniscus("load", *CASE, "--start")
        long = pb.Get(paths=["output.snapshot_interval"] * 64 + ["output.checkpoint_interval"] * 64)
        self.assertLess(self.count({"get": long}, 1), 2.5 * PACE + 50)
        longer = pb.Query(points=pb.PointQuery(field="pressure", points=[0.5] * 600))
        self.assertLess(self.count({"query": longer}, 1), 2.5 * PACE + 50)

    def test_more_than_may_wait_are_refused(self) -> None:
        self.meniscus("load", *CASE, "--start")
        with self.wire() as wire:
            for _ in range(2 * WAITING + PACE):
                ask(wire, status=pb.GetStatus())
            time.sleep(3)  # all have been read
            self.meniscus("pause")
            replies = [answer(wire) for _ in range(2 * WAITING + PACE)]
        refused = [reply for reply in replies if reply.code == pb.RESOURCE_EXHAUSTED]
        self.assertGreaterEqual(len(replies) - len(refused), WAITING)
        self.assertGreater(len(refused), WAITING // 2)
        self.assertIn(f"{WAITING} questions of this connection", refused[0].message)
        self.assertEqual({reply.code for reply in replies}, {pb.OK, pb.RESOURCE_EXHAUSTED})

    def test_what_ended_connections_asked_holds_up_no_other(self) -> None:
        self.meniscus("load", *CASE, "--start")
        with zmq.Context() as context:
            wires = [context.socket(zmq.DEALER) for _ in range(30)]
            for wire in wires:
                wire.connect(self.address)
                for _ in range(100):
                    ask(wire, query=pb.Query(probes=pb.ProbeQuery()))
            self.assertTrue(all(wire.poll(10_000) for wire in wires))  # all have been received
            for wire in wires:
                wire.close(0)
        with self.wire() as wire:
            begun = time.monotonic()
            for _ in range(10):
                ask(wire, status=pb.GetStatus())
                answer(wire)
        self.assertLess(time.monotonic() - begun, 2)  # with their turns it would be 10 * 30 / PACE and more


def ask(wire: "zmq.Socket[bytes]", **command: Any) -> None:
    wire.send(pb.Request(major=pb.PROTOCOL_MAJOR, id=os.urandom(16), **command).SerializeToString())


def answer(wire: "zmq.Socket[bytes]") -> Any:
    if not wire.poll(60_000):
        raise AssertionError("no answer")
    return pb.Reply.FromString(wire.recv_multipart()[0])


if __name__ == "__main__":
    unittest.main()

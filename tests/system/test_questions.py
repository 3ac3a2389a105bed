#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Large questions: they take little of the solver's time, and those that are too large are answered."""

import os
import sys
import threading
import unittest
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
        with zmq.Context() as context, context.socket(zmq.DEALER) as wire:
            wire.connect(self.address)
            query = pb.Query(points=pb.PointQuery(field="pressure", points=[0.5] * (n_points * n_dimensions)))
            request = pb.Request(major=pb.PROTOCOL_MAJOR, id=os.urandom(16), query=query)
            wire.send(request.SerializeToString())
            self.assertTrue(wire.poll(60_000), "no answer")
            reply = pb.Reply.FromString(wire.recv_multipart()[0])
            self.assertEqual(reply.id, request.id)
            return reply

    def test_too_many_points_get_an_answer(self) -> None:
        self.meniscus("load", *CASE)
        self.assertEqual(self.ask_raw(57_000).code, pb.OK)
        refused = self.ask_raw(57_001)
        self.assertEqual(refused.code, pb.RESOURCE_EXHAUSTED)
        self.assertIn("at most 57000 points at a time in 2 dimensions, found 57001", refused.message)
        longer = self.ask_raw(100_000)
        self.assertEqual(longer.code, pb.RESOURCE_EXHAUSTED)
        self.assertIn("a request may have 1048576 bytes", longer.message)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""Streams when memory is short: those who take what comes go on, and all that others lose by it is counted."""

import sys
import time
import unittest
import urllib.request
from pathlib import Path
from typing import Any

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import free_ports  # noqa: E402
from streaming import PLENTY, Item, StreamTest, Taker, fields, sb  # noqa: E402

LARGE = ["dambreak2d", "--set", "resolution=100", "--set", "threads=1", "--set", "end_time=1000", "--name", "large"]
MIDDLE = ["dambreak2d", "--set", "resolution=20", "--set", "threads=1", "--set", "end_time=1000", "--name", "middle"]
SMALL = ["dambreak2d", "--set", "resolution=8", "--set", "threads=1", "--set", "end_time=1000", "--name", "small",
         "--set", "output.probe_interval=1e-6", "--set", "output.checkpoint_interval=1000"]
HALF = 4 << 20  # of the memory for items


class ShortOfMemory(StreamTest):
    @classmethod
    def start_daemon(cls) -> None:
        cls.port = free_ports()
        cls.options = ["--stream-memory", "16", "--http", str(cls.port)]
        super().start_daemon()

    def new_deaf(self) -> Taker:
        """One whose connection stands still when it does not read."""
        deaf = self.new_taker()
        deaf.socket.close()
        deaf.socket = zmq.Context.instance().socket(zmq.DEALER)
        for option, value in ((zmq.LINGER, 0), (zmq.RCVHWM, 1), (zmq.SNDHWM, 0)):
            deaf.socket.setsockopt(option, value)
        deaf.socket.connect(self.endpoint)
        return deaf

    def count(self, name: str) -> float:
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/metrics", timeout=10) as page:
            lines = page.read().decode().splitlines()
        return float(next(line.split()[-1] for line in lines if line.startswith(f"meniscus_streams_{name}_total")))

    def every_step(self, *names: str, **how: Any) -> "dict[str, Any]":
        return dict(fields=fields(*names), when=sb.When(every_steps=1), **how)

    def step_until_one_comes(self, taker: Taker) -> Item:
        """There is room for one of several that are due."""
        for _ in range(8):
            self.meniscus("step", "1")
            try:
                return taker.item(1.5)
            except TimeoutError:
                pass
        raise TimeoutError("no item in eight steps")

    def test_items_above_half_of_the_memory_come_one_after_the_other(self) -> None:
        self.meniscus("load", *LARGE)
        self.taker.subscribe(**self.every_step("position", "velocity", "pressure", credit=PLENTY))
        for k in range(1, 6):
            self.meniscus("step", "1")
            item = self.taker.item(5)
            self.assertEqual((item.head.step, item.head.sequence, item.head.skipped), (k, k, 0))
            self.assertGreater(item.head.size, HALF)

    def test_who_takes_nothing_keeps_no_large_item_from_others(self) -> None:
        """Neither with one that is under way, nor with one that waits; and they learn what they have lost by it."""
        self.meniscus("load", *LARGE)
        hung, broke = self.new_taker(), self.new_taker()
        stuck = hung.subscribe(**self.every_step("position", "velocity", "density", credit=20000, chunk_bytes=4096)).stream
        self.meniscus("step", "1")
        hung.receive()  # it is under way
        waiting = broke.subscribe(**self.every_step("position", "velocity", "mass")).stream
        self.taker.subscribe(**self.every_step("position", "velocity", "pressure", credit=PLENTY))
        time.sleep(1.2)
        sequence = step = 0
        for k in range(2, 6):
            self.meniscus("step", "1")
            if not (k == 2 and self.taker.quiet(1)):  # two are due at once, and there is room for one of them
                item = self.taker.item(5)
                self.assertEqual(item.head.sequence, sequence + 1 + item.head.skipped)
                sequence, step = item.head.sequence, item.head.step
            time.sleep(1.2)
        self.assertEqual((step, sequence), (5, 4))
        self.assertGreater(self.count("too_slow"), 0)
        self.assertGreater(self.count("let_go") + self.count("not_made"), 0)
        self.taker.close()
        hung.grant(stuck, PLENTY)
        while not (message := hung.receive()[0]).item.HasField("cancelled"):
            pass
        self.assertEqual(message.item.cancelled.reason, "too slow")
        hung.under_way.clear()
        broke.grant(waiting, PLENTY)
        for taker, before in ((hung, 1), (broke, 0)):
            item = self.step_until_one_comes(taker)
            self.assertEqual(item.head.sequence, before + 1 + item.head.skipped)
            self.assertEqual(item.head.sequence, item.head.step - 1 + before)  # one who came after the first step

    def test_who_keeps_rows_for_a_resume_keeps_nobody_from_catching_up(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("step", "11000", timeout=240)
        self.taker.subscribe(probes=sb.ProbeStream(), delivery=sb.LOSSLESS, credit=PLENTY)
        while self.taker.item(5).last.next.row < 11001:  # all are on the disk
            pass
        for _ in range(10):
            taker = self.new_taker()
            taker.subscribe(probes=sb.ProbeStream(), delivery=sb.LOSSLESS, credit=(1 << 20) + 1024, chunk_bytes=1 << 20)
            self.assertGreater(taker.item(5).head.size, 900 << 10)

    # --- items that nobody can have yet -----------------------------------------------------------------------------

    def test_what_cannot_be_sent_is_packed_once_and_those_skipped_are_counted_all_the_same(self) -> None:
        self.meniscus("load", *MIDDLE)
        poor = self.taker.subscribe(**self.every_step("position", codec=1, credit=20)).stream
        before = self.count("packed")
        for _ in range(30):
            self.meniscus("step", "1")
        self.assertLessEqual(self.count("packed") - before, 2)
        self.taker.grant(poor, PLENTY)
        item = self.taker.item(5)
        self.assertEqual((item.head.step, item.head.sequence, item.head.skipped), (30, 30, 29))
        self.meniscus("step", "1")
        item = self.taker.item(5)
        self.assertEqual((item.head.step, item.head.sequence, item.head.skipped), (31, 31, 0))

    def test_who_asks_and_does_not_read_is_not_answered_any_longer_and_others_are(self) -> None:
        self.meniscus("load", *MIDDLE)
        deaf = self.new_deaf()
        before = self.count("unheard")
        for _ in range(30000):
            deaf.send(unsubscribe=sb.Unsubscribe(stream=1))
        until = time.monotonic() + 20
        while self.count("unheard") < before + 10000 and time.monotonic() < until:
            time.sleep(0.1)
        self.assertGreater(self.count("unheard"), before + 10000)
        self.assertEqual(self.taker.ask(unsubscribe=sb.Unsubscribe(stream=1)).code, 5)
        while deaf.socket.poll(500):  # it reads again
            deaf.socket.recv_multipart()
        ident = deaf.send(unsubscribe=sb.Unsubscribe(stream=1))
        self.assertEqual(deaf.receive(5)[0].reply.id, ident)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Streams: what a client asks for is what it gets, as fast as it takes it, and nobody else notices."""

import sys
import unittest
from pathlib import Path
from typing import Any

import numpy as np
import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest  # noqa: E402
from streaming import Taker, sb  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import Client  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=20", "--set", "threads=1", "--set", "end_time=1000"]
PLENTY = 1 << 30


def fields(*names: str, **exactness: Any) -> "sb.FieldStream":
    return sb.FieldStream(fields=[sb.FieldWish(name=name, **exactness) for name in names])


class Streams(DaemonTest):
    def setUp(self) -> None:
        self.meniscus("load", *CASE)
        self.endpoint = f"ipc://{self.home}/run/meniscus/default/data.ipc"
        self.taker = self.new_taker()

    def new_taker(self) -> Taker:
        taker = Taker(self.endpoint)
        self.addCleanup(taker.close)
        return taker

    def query(self, *names: str, walls: bool = False) -> "dict[str, np.ndarray[Any, Any]]":
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            return client.particles(list(names), walls=walls)

    # --- LATEST ----------------------------------------------------------------------------------------------------

    def test_a_field_comes_as_a_query_has_it(self) -> None:
        self.meniscus("step", "3")
        self.taker.subscribe(fields=fields("id", "position", "pressure"), when=sb.When(first=True), credit=PLENTY)
        item = self.taker.item()
        asked = self.query("id", "position", "pressure")
        self.assertEqual((item.head.sequence, item.head.skipped, item.head.step), (1, 0, 3))
        for name in ("id", "position", "pressure"):
            np.testing.assert_array_equal(item.array(name), asked[name])

    def test_items_come_at_the_steps_that_were_asked_for_and_at_no_others(self) -> None:
        self.taker.subscribe(fields=fields("pressure"), when=sb.When(every_steps=3), credit=PLENTY)
        for k in range(1, 4):
            self.meniscus("step", "3")
            item = self.taker.item()
            self.assertEqual((item.head.step, item.head.sequence, item.head.skipped), (3 * k, k, 0))
        self.meniscus("step", "2")
        self.assertTrue(self.taker.quiet(0.3))

    def test_who_takes_nothing_gets_the_newest_and_the_number_of_those_skipped(self) -> None:
        stream = self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1)).stream
        self.meniscus("step", "50")
        self.assertTrue(self.taker.quiet(0.3))
        self.taker.grant(stream, PLENTY)
        item = self.taker.item()
        self.assertEqual((item.head.step, item.head.sequence, item.head.skipped), (50, 50, 49))
        np.testing.assert_array_equal(item.array("position"), self.query("position")["position"])
        self.assertTrue(self.taker.quiet(0.3))

    def test_no_more_bytes_come_than_were_granted(self) -> None:
        grants = [5000, 100000, 20, 40000]
        stream = self.taker.subscribe(fields=fields("position", "velocity"), when=sb.When(first=True), chunk_bytes=4096).stream
        size = 0
        for n in grants:
            self.taker.grant(stream, n)
            while not self.taker.quiet(0.3):
                message, data = self.taker.receive()
                size = self.taker.take(message.item, data).head.size
            self.assertLessEqual(self.taker.received, sum(grants[: grants.index(n) + 1]))
        self.assertGreater(size, 0)

    def test_values_of_probes_are_those_of_a_query(self) -> None:
        columns = self.taker.subscribe(probes=sb.ProbeStream(), credit=PLENTY).columns
        item = self.taker.item()
        values = {v["name"]: v["value"] for v in self.ask("query", "probes")["values"]} if False else None
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            asked = client.probes()
        self.assertEqual([column.name for column in columns], list(asked))
        np.testing.assert_array_equal(item.array("values"), [float(asked[column.name]) for column in columns])
        del values


if __name__ == "__main__":
    unittest.main()

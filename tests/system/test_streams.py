#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Streams: what a client asks for is what it gets, as fast as it takes it, and nobody else notices."""

import contextlib
import os
import subprocess
import sys
import time
import unittest
from pathlib import Path
from typing import Any

import numpy as np
import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, at_length, free_ports  # noqa: E402
from streaming import PLENTY, StreamTest, Taker, fields, sb  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import Client  # noqa: E402

IDLE = 16  # who take nothing
CASE = ["dambreak2d", "--set", "resolution=20", "--set", "threads=1", "--set", "end_time=1000"]


class Streams(StreamTest):
    def setUp(self) -> None:
        self.meniscus("load", *CASE)
        super().setUp()

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

    def test_values_of_probes_are_those_of_a_query_and_come_at_once(self) -> None:
        columns = self.taker.subscribe(probes=sb.ProbeStream(), credit=PLENTY).columns
        item = self.taker.item()
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            asked = client.query()
        self.assertEqual([column.name for column in columns], list(asked))
        np.testing.assert_array_equal(item.array("values"), [asked[column.name].value for column in columns])

    def test_probes_that_nobody_asked_for_at_once_come_when_they_are_due(self) -> None:
        self.taker.subscribe(probes=sb.ProbeStream(), when=sb.When(every_steps=7), credit=PLENTY)
        self.assertTrue(self.taker.quiet(0.5))
        self.meniscus("step", "15")
        self.assertEqual(self.taker.item().head.step % 7, 0)

    def test_probes_come_in_the_order_in_which_they_are_named(self) -> None:
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            names = list(client.query())[8:5:-1]
            self.taker.subscribe(probes=sb.ProbeStream(names=names), credit=PLENTY)
            values = self.taker.item().array("values")
            self.assertEqual(list(values), [client.query()[name].value for name in names])

    def test_events_come_and_only_the_newest_for_who_is_late(self) -> None:
        stream = self.taker.subscribe(events=sb.EventStream()).stream
        self.meniscus("step", "1")
        self.meniscus("step", "1")
        self.taker.grant(stream, PLENTY)
        item = self.taker.item()
        self.assertEqual(item.head.event.state, 4)  # PAUSED
        self.assertGreaterEqual(item.head.skipped, 3)

    def test_what_is_paced_by_the_clock_comes_no_faster(self) -> None:
        """However late it is taken."""
        asked, came = time.monotonic(), 0
        self.taker.subscribe(fields=fields("pressure"), when=sb.When(max_hz=10), credit=PLENTY)
        self.meniscus("start")
        began = time.monotonic()
        while time.monotonic() < began + 2 or came < 2:
            self.taker.item()
            came += 1
        self.assertLessEqual(came, 10 * (time.monotonic() - asked) + 2)

    def test_items_come_at_the_first_step_after_each_multiple_of_an_interval(self) -> None:
        self.taker.subscribe(fields=fields("pressure"), when=sb.When(interval=0.01), credit=PLENTY)
        self.meniscus("run-until", "0.055")
        k = 0
        while k < 5:
            item = self.taker.item()
            self.assertEqual(item.head.sequence, k + 1 + item.head.skipped)
            k = item.head.sequence
            self.assertGreaterEqual(item.head.time, 0.01 * k)
            self.assertLess(item.head.time, 0.01 * k + 0.005)

    def test_each_selection_has_those_particles_and_no_others(self) -> None:
        self.meniscus("step", "5")
        everybody = self.query("id", "position", "phase", walls=True)
        fluid = self.query("id", "position", "phase")
        x, y = fluid["position"].T
        centre = fluid["position"].mean(axis=0)
        ball = ((fluid["position"] - centre) ** 2).sum(axis=1) <= 0.1**2
        walls = everybody["phase"][-1]
        cases = [
            (dict(), fluid, slice(None)),
            (dict(walls=True), everybody, slice(None)),
            (dict(min=[0.1, -9], max=[0.4, 0.3]), fluid, (x >= 0.1) & (x <= 0.4) & (y <= 0.3)),
            (dict(centre=list(centre), radius=0.1), fluid, ball),
            (dict(centre=list(centre), radius=0.1, min=[float(centre[0]), -9]), fluid, ball & (x >= centre[0])),
            (dict(phases=[int(walls)], walls=True), everybody, everybody["phase"] == walls),
            (dict(min=[99.0, 99.0]), fluid, x > 98),
        ]
        for where, of, chosen in cases:
            with self.subTest(where=where):
                taker = self.new_taker()
                taker.subscribe(fields=fields("id", "position"), where=sb.Where(**where), when=sb.When(first=True), credit=PLENTY)
                item = taker.item()
                np.testing.assert_array_equal(item.array("id"), of["id"][chosen])
                np.testing.assert_array_equal(item.array("position"), of["position"][chosen])

    def test_one_in_so_many_is_always_the_same_ones(self) -> None:
        self.taker.subscribe(fields=fields("id"), where=sb.Where(every=4), when=sb.When(every_steps=1), credit=PLENTY)
        self.meniscus("step", "1")
        first = set(self.taker.item().array("id"))
        self.meniscus("step", "20")
        step = 1
        while step < 21:  # the last one comes whatever was skipped
            item = self.taker.item()
            step = item.head.step
            self.assertEqual(set(item.array("id")), first)
        n = len(self.query("id")["id"])
        self.assertTrue(0.15 * n < len(first) < 0.35 * n, (len(first), n))

    def test_bounded_values_differ_by_less_than_the_bound(self) -> None:
        from meniscus import packing_pb2

        self.meniscus("step", "5")
        self.taker.subscribe(
            fields=fields("position", exactness=sb.Exactness(bound=1e-4)), when=sb.When(first=True), credit=PLENTY,
            codec=packing_pb2.CODEC_NONE,
        )
        item = self.taker.item()
        array = item.head.arrays[0]
        q, rows = array.quantisation, array.shape[0]
        data = np.frombuffer(bytes(item.bytes), np.uint8)
        if array.shuffle:
            data = data.reshape(array.shuffle, -1).T.copy().ravel()
        numbers = data.view(f"<u{q.width}").reshape(rows, -1)
        values = np.array(q.offset) + q.step * numbers
        error = np.abs(values - self.query("position")["position"]).max()
        self.assertLess(error, 1e-4)
        self.assertGreater(error, 1e-6)
        self.assertLess(len(item.bytes), 0.5 * array.raw_bytes)

    # --- who does not take what comes --------------------------------------------------------------------------------

    def test_a_cancelled_item_ends_at_once_and_the_next_one_is_the_newest(self) -> None:
        stream = self.taker.subscribe(fields=fields("position", "velocity"), when=sb.When(every_steps=1), chunk_bytes=4096, credit=9000).stream
        self.meniscus("step", "1")
        self.taker.receive()
        self.meniscus("step", "5")
        began = time.monotonic()
        self.taker.send(cancel=sb.CancelItem(stream=stream))
        while not (message := self.taker.receive()[0]).item.HasField("cancelled"):
            pass
        self.assertLess(time.monotonic() - began, 1 if at_length() else 20)
        self.assertEqual((message.item.sequence, message.item.cancelled.reason), (1, "cancelled"))
        self.taker.under_way.clear()
        self.taker.grant(stream, PLENTY)
        item = self.taker.item()
        self.assertEqual((item.head.sequence, item.head.step, item.head.skipped), (6, 6, 4))

    def test_an_item_goes_on_over_another_connection_where_it_ended(self) -> None:
        stream = self.taker.subscribe(fields=fields("position", "velocity"), when=sb.When(first=True), chunk_bytes=4096, credit=20000).stream
        message, data = self.taker.receive()
        item = self.taker.take(message.item, data)
        asked = self.query("position")["position"]
        self.taker.close()
        self.meniscus("step", "5")
        other = self.new_taker()
        reply = other.ask(resume=sb.ResumeStream(stream=stream, sequence=1, offset=len(data), credit=PLENTY))
        self.assertEqual((reply.code, reply.sequence, reply.offset), (0, 1, len(data)))
        while not item.whole:
            message, data = other.receive()
            item.take(message.item, data)
        np.testing.assert_array_equal(item.array("position"), asked)

    def test_an_item_that_is_no_longer_there_is_not_resumed(self) -> None:
        stream = self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1), credit=PLENTY).stream
        self.meniscus("step", "2")
        while self.taker.item().head.sequence < 2:
            pass
        other = self.new_taker()
        reply = other.ask(resume=sb.ResumeStream(stream=stream, sequence=1, offset=100, credit=PLENTY))
        self.assertEqual((reply.code, reply.sequence, reply.offset), (0, 3, 0))
        self.meniscus("step", "1")
        self.assertEqual(other.item().head.sequence, 3)
        self.assertEqual(other.ask(resume=sb.ResumeStream(stream=stream + 1)).code, 5)  # NOT_FOUND

    def test_who_stops_does_not_change_what_others_get(self) -> None:
        stopped = [self.new_taker() for _ in range(20)]
        for k, taker in enumerate(stopped):
            taker.subscribe(fields=fields("position", "velocity"), when=sb.When(every_steps=1 + k % 3), credit=5000, chunk_bytes=4096)
        self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1), credit=PLENTY)
        for k in range(1, 31):
            self.meniscus("step", "1")
            item = self.taker.item(5)
            self.assertEqual((item.head.step, item.head.skipped), (k, 0))

    def test_who_asks_for_an_item_at_once_and_does_not_take_it_keeps_it_from_nobody(self) -> None:
        for _ in range(6):
            self.new_taker().subscribe(fields=fields("position"), when=sb.When(first=True))
            time.sleep(0.1)  # so that each would have a state of its own
            self.meniscus("step", "1")
        self.taker.subscribe(fields=fields("position"), when=sb.When(first=True), credit=PLENTY)
        self.assertEqual(self.taker.item(5).head.step, 6)

    def test_after_an_unsubscribe_nothing_comes(self) -> None:
        stream = self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1), credit=PLENTY).stream
        self.assertEqual(self.taker.ask(unsubscribe=sb.Unsubscribe(stream=stream)).code, 0)
        self.meniscus("step", "3")
        self.assertTrue(self.taker.quiet(0.3))
        self.assertEqual(self.taker.ask(unsubscribe=sb.Unsubscribe(stream=stream)).code, 5)

    def test_a_stream_is_nobody_elses(self) -> None:
        stream = self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1)).stream
        other = self.new_taker()
        other.grant(stream, PLENTY)
        self.assertEqual(other.receive()[0].reply.code, 5)
        self.meniscus("step", "1")
        self.assertTrue(self.taker.quiet(0.3))

    def test_one_connection_has_so_many_streams_and_others_find_room(self) -> None:
        most = 256
        self.addCleanup(self.taker.close)
        for _ in range(most):
            last = self.taker.subscribe(events=sb.EventStream()).stream
        for _ in range(3):
            refused = self.taker.ask(subscribe=sb.Subscribe(events=sb.EventStream()))
            self.assertEqual((refused.code, refused.reason), (8, "limit reached"))
            self.assertIn("this connection has 256 streams", refused.message)
        other = self.new_taker()
        moved = other.subscribe(events=sb.EventStream()).stream
        self.assertEqual(self.taker.ask(resume=sb.ResumeStream(stream=moved)).code, 8)
        self.assertEqual(self.taker.ask(resume=sb.ResumeStream(stream=last)).code, 0)
        self.assertEqual(self.taker.ask(unsubscribe=sb.Unsubscribe(stream=last)).code, 0)
        self.assertEqual(self.taker.ask(resume=sb.ResumeStream(stream=moved)).code, 0)

    def test_a_field_that_an_option_took_away_is_a_gap_and_comes_back_with_it(self) -> None:
        option = "scheme.interfacial.gradient_correction"
        self.meniscus("load", "rayleigh-taylor2d", "--set", "resolution=20", "--set", "threads=1")
        self.taker.subscribe(fields=fields("position", "correction"), when=sb.When(every_steps=1), credit=PLENTY)
        self.meniscus("step", "1")
        self.assertEqual(self.taker.item().head.step, 1)
        self.meniscus("set", f"{option}=false")
        refused = self.meniscus("query", "at", "correction", "0.5,0.5", code=1)
        self.assertIn("correction", refused.stderr)
        self.meniscus("step", "3")
        self.assertTrue(self.taker.quiet(0.3))
        self.meniscus("set", f"{option}=true")
        self.meniscus("step", "1")
        item = self.taker.item()
        self.assertEqual((item.head.step, item.head.skipped), (5, 3))
        np.testing.assert_array_equal(item.array("correction"), self.query("correction")["correction"])

    def test_when_the_run_is_left_its_streams_are_over(self) -> None:
        self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1), credit=PLENTY)
        self.meniscus("stop")
        message, _ = self.taker.receive()
        self.assertEqual(message.item.ended.code, 10)  # ABORTED
        self.meniscus("load", *CASE)

    # --- what is refused ---------------------------------------------------------------------------------------------

    def test_each_bad_entry_is_refused_with_its_path_and_a_sentence(self) -> None:
        position = fields("position")
        bound = sb.Exactness(bound=-1)
        cases = [
            ("what", dict()),
            ("fields", dict(fields=sb.FieldStream())),
            ("fields[1].name", dict(fields=fields("position", "presure"))),
            ("fields[1].name", dict(fields=fields("position", "position"))),
            ("fields[0].exactness.bound", dict(fields=fields("position", exactness=bound))),
            ("fields[0].exactness", dict(fields=fields("id", exactness=sb.Exactness(f32=True)))),
            ("probes.names[0]", dict(probes=sb.ProbeStream(names=["nowhere"]))),
            ("probes.exactness.bound", dict(probes=sb.ProbeStream(exactness=bound))),
            ("delivery", dict(fields=position, delivery=sb.LOSSLESS)),
            ("delivery", dict(events=sb.EventStream(), delivery=sb.LOSSLESS)),
            ("delivery", dict(snapshots=sb.SnapshotStream(), delivery=sb.LATEST)),
            ("when", dict(snapshots=sb.SnapshotStream(), when=sb.When(first=True))),
            ("when.every_steps", dict(fields=position, when=sb.When(every_steps=0))),
            ("when.interval", dict(fields=position, when=sb.When(interval=-1))),
            ("when.interval", dict(fields=position, when=sb.When(interval=float("nan")))),
            ("when.max_hz", dict(fields=position, when=sb.When(max_hz=0))),
            ("where", dict(probes=sb.ProbeStream(), where=sb.Where(every=2))),
            ("where.min", dict(fields=position, where=sb.Where(min=[0]))),
            ("where.max", dict(fields=position, where=sb.Where(max=[0, float("nan")]))),
            ("where.min", dict(fields=position, where=sb.Where(min=[1, 0], max=[0, 1]))),
            ("where.centre", dict(fields=position, where=sb.Where(radius=1))),
            ("where.radius", dict(fields=position, where=sb.Where(centre=[0, 0]))),
            ("where.radius", dict(fields=position, where=sb.Where(centre=[0, 0], radius=0))),
            ("where.phases", dict(fields=position, where=sb.Where(phases=[99]))),
            ("where.every", dict(fields=position, where=sb.Where(every=0))),
            ("codec", dict(snapshots=sb.SnapshotStream(), codec=1)),
            ("chunk_bytes", dict(fields=position, chunk_bytes=100)),
            ("chunk_bytes", dict(fields=position, chunk_bytes=1 << 30)),
            ("from", dict(fields=position, **{"from": sb.Cursor(row=1)})),
            ("from.file", dict(snapshots=sb.SnapshotStream(), **{"from": sb.Cursor(file="../../etc/passwd")})),
        ]
        for path, what in cases:
            with self.subTest(path=path, what=what):
                reply = self.taker.ask(subscribe=sb.Subscribe(credit=PLENTY, **what))
                self.assertIn(reply.code, (3, 5), reply)
                self.assertEqual(reply.path, path)
                self.assertGreater(len(reply.message), 15)
        self.meniscus("step", "1")
        self.assertTrue(self.taker.quiet(0.2))

    def test_rubbish_gets_a_sentence_and_nobody_is_hurt(self) -> None:
        for frames in ([b""], [b"\xff" * 40], [b"a", b"b"], [sb.StreamRequest(major=2, id=b"x" * 16).SerializeToString()],
                       [sb.StreamRequest(major=1, id=b"x").SerializeToString()]):
            self.taker.socket.send_multipart(frames)
            self.assertNotEqual(self.taker.receive()[0].reply.code, 0)
        self.taker.subscribe(fields=fields("position"), when=sb.When(first=True), credit=PLENTY)
        self.taker.item()


class Afar(DaemonTest):
    """The door in front of the data socket."""

    @classmethod
    def start_daemon(cls) -> None:
        cls.environment["MENISCUS_KEYS"] = str(cls.home / "keys")
        cls.port = free_ports()
        cls.meniscus_keys("new", "eve", "--role", "viewer")
        cls.options = ["--listen", f"tcp://127.0.0.1:{cls.port}"]
        super().start_daemon()

    @classmethod
    def meniscus_keys(cls, *words: str) -> None:
        subprocess.run([BUILD / "meniscus", "keys", *words], env=cls.environment, check=True, stdout=subprocess.DEVNULL)

    def taker(self, keys: "dict[str, str] | None", ahead: int = 0) -> Taker:
        taker = Taker(f"tcp://127.0.0.1:{self.port + 2}", keys, ahead)
        self.addCleanup(taker.close)
        return taker

    def test_a_viewer_takes_streams_until_the_key_is_gone_and_nobody_else_gets_a_byte(self) -> None:
        self.meniscus("load", *CASE)
        lines = (self.home / "keys" / "eve.key").read_text().splitlines()
        eve = dict(line.split() for line in lines if line and not line.startswith("#"))
        public, secret = (key.decode() for key in zmq.curve_keypair())
        for stranger in (None, {"public-key": public, "secret-key": secret, "server-key": eve["server-key"]}):
            taker = self.taker(stranger)
            taker.send(subscribe=sb.Subscribe(probes=sb.ProbeStream(), credit=PLENTY))
            self.assertTrue(taker.quiet(1))
        taker = self.taker(eve)
        taker.subscribe(probes=sb.ProbeStream(), when=sb.When(every_steps=1, first=True), credit=PLENTY)
        self.assertEqual(taker.item().head.step, 0)
        self.meniscus_keys("remove", "eve")

        def hears_nothing() -> bool:
            self.meniscus("step", "1")
            if quiet := taker.quiet(1):
                return quiet
            taker.item()
            return False

        self.wait_until(hears_nothing)

    def memory_mib(self) -> "dict[str, int]":
        """Of the daemon, and of the gate, which is its child."""
        found = {}
        for place in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                parent = int((place / "stat").read_text().rpartition(")")[2].split()[1])
                name = {str(self.daemon.pid): "daemon"}.get(place.name, "gate" if parent == self.daemon.pid else "")
                if name:
                    found[name] = int((place / "statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE") >> 20
        return found

    def test_those_from_afar_who_take_nothing_cost_little_and_keep_nobody_waiting(self) -> None:
        self.meniscus_keys("new", "sam", "--role", "viewer")
        sam = dict(line.split() for line in (self.home / "keys" / "sam.key").read_text().splitlines() if line and not line.startswith("#"))
        self.meniscus("load", "dambreak2d", "--set", "resolution=60", "--set", "end_time=1e4")
        total = 0
        for _ in range(8):
            total += Path(self.ask("snapshot")["path"]).stat().st_size
            self.meniscus("step", "1")
        before = self.memory_mib()
        idle = [self.taker(sam, ahead=1) for _ in range(IDLE)]
        for taker in idle:
            taker.subscribe(snapshots=sb.SnapshotStream(), credit=PLENTY, chunk_bytes=1 << 20)
        lively = self.taker(sam)
        lively.subscribe(snapshots=sb.SnapshotStream(), credit=PLENTY)
        taken = sum(lively.item().head.size for _ in range(8))
        self.assertEqual(taken, total)
        after = self.memory_mib()
        self.assertLess(after["gate"] - before["gate"], 12 * IDLE)
        self.assertLess(after["daemon"] - before["daemon"], 64)


class Counted(StreamTest):
    """With a daemon of its own, where there are no streams but these."""

    def counts(self) -> "dict[str, int]":
        counts: "dict[str, int]" = self.ask("status")["streams"]
        return counts

    def test_who_is_not_there_has_nothing_skipped(self) -> None:
        self.meniscus("load", *CASE)
        gone = self.new_taker()
        stream = gone.subscribe(fields=fields("position"), when=sb.When(every_steps=1)).stream
        before = self.counts()["skipped"]
        self.meniscus("step", "5")
        self.assertEqual(self.counts()["skipped"], before + 4)
        gone.close()

        def is_seen_to_be_gone() -> bool:
            skipped = self.counts()["skipped"]
            self.meniscus("step", "1")
            return bool(self.counts()["skipped"] == skipped)

        self.wait_until(is_seen_to_be_gone)
        here = self.counts()["skipped"]
        self.meniscus("step", "20")
        self.assertEqual(self.counts()["skipped"], here)
        self.assertEqual(self.taker.ask(resume=sb.ResumeStream(stream=stream, credit=PLENTY)).code, 0)
        steps = self.ask("status")["step"]
        self.assertEqual(self.taker.item().head.skipped, steps - 1)
        self.assertEqual(self.counts()["skipped"], before + steps - 1)  # it has come back

    def test_the_status_tells_how_many_there_are_and_what_they_cost(self) -> None:
        self.assertEqual(self.counts(), {"latest": 0, "lossless": 0, "memory_bytes": 0, "skipped": 0})
        self.assertNotIn("\nstreams ", self.meniscus("status").stdout)
        self.meniscus("load", *CASE)
        events = self.taker.subscribe(events=sb.EventStream()).stream
        self.assertEqual(self.counts()["latest"], 1)
        self.taker.ask(unsubscribe=sb.Unsubscribe(stream=events))
        lazy = self.taker.subscribe(fields=fields("position"), when=sb.When(every_steps=1)).stream
        self.taker.subscribe(probes=sb.ProbeStream(), delivery=sb.LOSSLESS)
        self.assertEqual(self.ask("top", "--once")["daemons"][0]["streams"], 2)
        before = self.counts()["skipped"]
        self.meniscus("step", "10")
        self.assertEqual(self.counts()["skipped"], before + 9)  # though nothing is sent that could tell
        self.taker.grant(lazy, PLENTY)
        item = self.taker.item()
        self.assertEqual(item.head.skipped, 9)
        size = len(item.array("position").tobytes())
        told = self.counts()
        self.assertEqual((told["latest"], told["lossless"], told["skipped"]), (1, 1, before + 9))
        self.assertGreater(told["memory_bytes"], size)
        text = self.meniscus("status").stdout
        self.assertRegex(text, rf"\nstreams     1 of the newest, 1 of everything; \d+\.\d MiB held, {before + 9} items skipped since")
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            now = client.status().streams
        assert now
        self.assertEqual((now.latest, now.lossless, now.skipped), (1, 1, before + 9))
        self.assertGreater(now.memory_bytes, size)
        self.taker.ask(unsubscribe=sb.Unsubscribe(stream=lazy))
        self.assertEqual((self.counts()["latest"], self.counts()["lossless"]), (0, 1))


if __name__ == "__main__":
    unittest.main()

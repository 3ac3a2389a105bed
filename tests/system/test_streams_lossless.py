#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""LOSSLESS streams: every row of the series once, whoever is killed in between, and what was undone is told.

MENISCUS_KILLS says how often clients and the daemon are killed; 4 unless it is set, 12 in `make nightly`.
"""

import os
import random
import sys
import threading
import time
import unittest
from pathlib import Path
from typing import Any

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import DaemonTest, at_length  # noqa: E402
from streaming import PLENTY, Item, Taker, sb  # noqa: E402

KILLS = int(os.environ.get("MENISCUS_KILLS", "12" if at_length() else "4"))
CASE = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=1000", "--set", "threads=1",
        "--set", "output.probe_interval=1e-6", "--set", "output.checkpoint_interval=0.05"]
STEP_0 = 1  # the state at the beginning is a row, too


class Series(DaemonTest):
    def setUp(self) -> None:
        self.endpoint = f"ipc://{self.home}/run/meniscus/default/data.ipc"
        self.rows: list[Any] = []  # step, time and values of each, as they came
        self.cursor: sb.Cursor | None = None

    def subscribe(self, credit: int = PLENTY, **more: Any) -> Taker:
        """With the cursor, until there is a case to stream from."""
        taker = Taker(self.endpoint)
        self.addCleanup(taker.close)
        until = time.monotonic() + 30
        while True:
            try:
                reply = taker.ask(subscribe=sb.Subscribe(probes=sb.ProbeStream(), delivery=sb.LOSSLESS, credit=credit,
                                                         **{"from": self.cursor}, **more))
            except TimeoutError:
                reply = sb.StreamReply(code=14)
            if reply.code == 0:
                self.stream = reply.stream
                return taker
            self.assertLess(time.monotonic(), until, reply)
            time.sleep(0.05)

    def keep(self, item: Item) -> None:
        """Rows of an item that is whole, and where to go on."""
        if item.head.HasField("abandoned"):
            del self.rows[item.head.abandoned.row:]
        else:
            rows = zip(item.array("step"), item.array("time"), item.array("values"))
            self.rows += [(step, t, values.copy()) for step, t, values in rows]
        self.cursor = item.last.next

    def follow(self, taker: Taker, rows: int, timeout: float = 30) -> None:
        until = time.monotonic() + timeout
        while len(self.rows) < rows:
            self.keep(taker.item(until - time.monotonic()))

    def in_file(self, directory: str) -> "tuple[Any, Any, Any, Any]":
        with h5py.File(Path(directory) / "probes.hdf") as file:
            names = list(file["probes"])
            return names, file["step"][:], file["time"][:], {name: file["probes"][name][:] for name in names}

    def compare(self, columns: "list[str]") -> int:
        """What came is the series, to the bit."""
        _, step, t, probes = self.in_file(self.ask("status")["run_directory"])
        self.assertEqual(len(self.rows), len(step))
        np.testing.assert_array_equal([row[0] for row in self.rows], step)
        np.testing.assert_array_equal([row[1] for row in self.rows], t)
        values = np.array([row[2] for row in self.rows])
        for k, name in enumerate(columns):
            np.testing.assert_array_equal(values[:, k], probes[name])
        return len(step)

    def columns(self) -> "list[str]":
        taker = Taker(self.endpoint)
        reply = taker.subscribe(probes=sb.ProbeStream())
        taker.close()
        return [column.name for column in reply.columns]

    def test_all_rows_come_in_order_in_pieces_that_are_paid_for(self) -> None:
        self.meniscus("load", *CASE)
        self.meniscus("step", "300")
        taker = self.subscribe(credit=0, chunk_bytes=4096)
        granted = 0
        while len(self.rows) < 300 + STEP_0:
            taker.grant(self.stream, 3000)
            granted += 3000
            while not taker.quiet(0.02):
                self.keep(taker.item())
            self.assertLessEqual(taker.received, granted)
        self.compare(self.columns())

    def test_what_a_restore_undoes_is_told_and_the_new_line_follows(self) -> None:
        self.meniscus("load", *CASE, "--set", "output.checkpoint_interval=1000")
        self.meniscus("step", "40")
        self.meniscus("checkpoint")
        self.meniscus("step", "40")
        taker = self.subscribe()
        self.follow(taker, 80 + STEP_0)
        line = self.cursor.line
        self.meniscus("restore")
        self.meniscus("set", "gravity=[0, -2]")
        item = taker.item()
        self.assertTrue(item.head.HasField("abandoned"))
        self.assertEqual((item.head.abandoned.line, item.head.abandoned.row), (line, 40 + STEP_0))
        self.keep(item)
        self.meniscus("step", "10")
        self.follow(taker, 50 + STEP_0)
        self.compare(self.columns())

    def test_a_resume_without_a_sequence_goes_on_behind_what_came_whole(self) -> None:
        self.meniscus("load", *CASE)
        self.meniscus("step", "40")
        taker = self.subscribe(credit=0)
        taker.grant(self.stream, 8000)
        first = taker.item()
        self.keep(first)
        taker.close()
        self.meniscus("step", "5")
        other = Taker(self.endpoint)
        self.addCleanup(other.close)
        reply = other.ask(resume=sb.ResumeStream(stream=self.stream, credit=PLENTY))
        self.assertEqual((reply.code, reply.sequence, reply.offset), (0, first.head.sequence + 1, 0), reply.message)
        while len(self.rows) < 45 + STEP_0:
            self.keep(other.item())
        self.assertEqual([row[0] for row in self.rows], list(range(45 + STEP_0)))

    def test_who_was_away_during_a_restore_is_told_too(self) -> None:
        self.meniscus("load", *CASE, "--set", "output.checkpoint_interval=1000")
        self.meniscus("step", "40")
        self.meniscus("checkpoint")
        self.meniscus("step", "40")
        taker = self.subscribe()
        self.follow(taker, 80 + STEP_0)
        taker.close()
        self.meniscus("restore")
        self.meniscus("step", "10")
        self.kill_daemon()
        taker = self.subscribe()
        self.assertTrue((item := taker.item()).head.HasField("abandoned"))
        self.keep(item)
        self.follow(taker, 50 + STEP_0)
        self.compare(self.columns())

    def test_a_reset_undoes_all(self) -> None:
        self.meniscus("load", *CASE)
        self.meniscus("step", "40")
        taker = self.subscribe()
        self.follow(taker, 40 + STEP_0)
        self.meniscus("reset")
        self.assertEqual((item := taker.item()).head.abandoned.row, 0)
        self.keep(item)
        self.meniscus("step", "7")
        self.follow(taker, 7 + STEP_0)
        self.compare(self.columns())

    def test_kills_leave_no_gap_and_no_duplicate(self) -> None:
        chance = random.Random(11)
        self.meniscus("load", *CASE, "--name", "killed")
        columns = self.columns()
        self.meniscus("start")
        done = threading.Event()

        def kill() -> None:
            for _ in range(KILLS):
                time.sleep(chance.uniform(0.2, 1.0))
                self.daemon.kill()
                self.daemon.wait()
                type(self).start_daemon()
            done.set()

        killer = threading.Thread(target=kill)
        killer.start()
        while not done.is_set():
            taker = self.subscribe()
            for _ in range(chance.randint(1, 20)):  # then this client is killed, whatever is on its way
                try:
                    self.keep(taker.item(1))
                except TimeoutError:
                    break
            taker.close()
        killer.join()
        self.meniscus("wait", "--for", "state=RUNNING", "--timeout", "60")
        self.meniscus("pause")
        self.meniscus("step", "1")
        n = self.ask("status")["step"]
        self.follow(self.subscribe(), n + STEP_0)
        rows = self.compare(columns)
        print(f"{rows} rows over {KILLS} kills of the daemon", file=sys.stderr)


class Snapshots(DaemonTest):
    CASE = [*CASE, "--set", "output.checkpoint_interval=1000", "--set", "output.snapshot_interval=0.01", "--name", "files"]

    def setUp(self) -> None:
        self.endpoint = f"ipc://{self.home}/run/meniscus/default/data.ipc"
        self.meniscus("load", *self.CASE)

    def subscribe(self, cursor: "sb.Cursor | None" = None, credit: int = PLENTY, **more: Any) -> Taker:
        taker = Taker(self.endpoint)
        self.addCleanup(taker.close)
        self.stream = taker.subscribe(snapshots=sb.SnapshotStream(), credit=credit, **more, **{"from": cursor}).stream
        return taker

    def files(self) -> "dict[str, bytes]":
        """Those until now, one each 0.01 s, when they are written: the run does not wait for the last one."""
        status = self.ask("status")
        directory, n = Path(status["run_directory"]), round(status["time"] / 0.01) + 1
        until = time.monotonic() + 20
        while len(paths := sorted(directory.glob("snapshot-*.hdf"))) < n and time.monotonic() < until:
            time.sleep(0.02)
        return {path.name: path.read_bytes() for path in paths}

    def take(self, taker: Taker, n: int) -> "dict[str, bytes]":
        items = [taker.item() for _ in range(n)]
        self.cursor = items[-1].last.next
        return {item.head.file.name: bytes(item.bytes) for item in items}

    def test_files_come_byte_for_byte_and_those_written_later_too(self) -> None:
        self.meniscus("run-until", "0.03")
        taker = self.subscribe()
        files = self.files()
        self.assertGreaterEqual(len(files), 3)
        self.assertEqual(self.take(taker, len(files)), files)
        self.meniscus("run-until", "0.05")
        later = {name: data for name, data in self.files().items() if name not in files}
        self.assertEqual(self.take(taker, len(later)), later)

    def test_a_cursor_goes_on_within_a_file_also_after_a_crash(self) -> None:
        self.meniscus("run-until", "0.02")
        self.meniscus("checkpoint")
        name, data = list(self.files().items())[1]
        taker = self.subscribe()
        self.take(taker, 1)
        line = self.take(taker, 1) and self.cursor.line
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        taker = self.subscribe(sb.Cursor(line=line, file=name, offset=1000))
        rest = b""
        while len(rest) < len(data) - 1000:
            message, part = taker.receive()
            self.assertEqual(message.item.offset, 1000 + len(rest))
            rest += part
        self.assertEqual(rest, data[1000:])

    def test_a_file_of_which_no_byte_came_begins_anew(self) -> None:
        self.meniscus("load", *CASE)
        path = self.ask("snapshot")["path"]
        taker = Taker(self.endpoint)
        stream = taker.subscribe(snapshots=sb.SnapshotStream(), credit=20000, chunk_bytes=4096).stream
        message, _ = taker.receive()
        self.assertTrue(message.item.HasField("file"))
        taker.close()
        other = Taker(self.endpoint)
        self.addCleanup(other.close)
        reply = other.ask(resume=sb.ResumeStream(stream=stream, credit=PLENTY))
        self.assertEqual((reply.code, reply.sequence, reply.offset), (0, 1, 0), reply.message)
        item = other.item()
        self.assertEqual(item.head.file.name, Path(path).name)
        self.assertEqual(bytes(item.bytes), Path(path).read_bytes())
        self.assertTrue(item.last.HasField("xxh64"))

    def test_files_that_a_restore_undid_are_told_and_those_in_their_place_come(self) -> None:
        self.meniscus("run-until", "0.02")
        self.meniscus("checkpoint")
        kept = self.files()
        self.meniscus("run-until", "0.05")
        taker = self.subscribe()
        self.take(taker, len(self.files()))
        self.meniscus("restore")
        item = taker.item()
        self.assertTrue(item.head.HasField("abandoned"))
        self.assertEqual(item.last.next.file, list(kept)[-1])
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("run-until", "0.04")
        later = {name: data for name, data in self.files().items() if name not in kept}
        self.assertEqual(self.take(taker, len(later)), later)

    def test_a_cancelled_file_is_left_out(self) -> None:
        self.meniscus("run-until", "0.02")
        taker = self.subscribe(credit=20000, chunk_bytes=4096)
        while taker.socket.poll(300):
            message, data = taker.receive()
            item = taker.take(message.item, data)
        self.assertFalse(item.whole, "the file is too small for this test")
        taker.send(cancel=sb.CancelItem(stream=self.stream))
        item = taker.item()
        self.assertEqual(item.head.cancelled.reason, "cancelled")
        taker.grant(self.stream, PLENTY)
        name, data = list(self.files().items())[1]
        self.assertEqual(self.take(taker, 1), {name: data})


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: BSD-3-Clause
"""Streams in Python: with a daemon, packed in every way; and with one that misbehaves, on its data socket."""

import asyncio
import os
import re
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any, Optional

import h5py
import numpy as np
import xxhash
import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.daemon import BUILD, DaemonTest, readme_lines  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import meniscus_pb2, stream_pb2 as pb  # noqa: E402
from meniscus.asynchronous import AsyncStream  # noqa: E402
from meniscus.streams import Stream  # noqa: E402
from meniscus.wishes import subscription  # noqa: E402

SMALL = {"resolution": 20}


class WithDaemon(DaemonTest):
    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]
        self.client = meniscus.Client(f"ipc://{self.home}/run/meniscus/default/control.ipc")
        self.addCleanup(self.client.close)
        self.client.load("dambreak2d", SMALL)

    def test_what_is_packed_in_any_way_is_what_a_query_tells(self) -> None:
        names = ("position", "pressure", "id", "phase")
        self.client.step(10)
        queried = self.client.particles(list(names))
        order = np.argsort(queried["id"])
        for pack in ("none", "lz4", "zstd"):
            for exact, error in ((None, 0), ({"position": "f32", "pressure": "f32"}, 1e-3), ({"position": 1e-3, "pressure": 0.5}, 0.5)):
                with self.subTest(pack=pack, exact=exact), self.client.stream(
                    "fields", *names, first=True, pack=pack, exact=exact
                ) as stream:
                    item = stream.next(10)
                    assert item
                    found = np.argsort(item["id"])
                    self.assertTrue((item["id"][found] == queried["id"][order]).all())
                    self.assertTrue((item["phase"][found] == queried["phase"][order]).all())
                    bounds = {"position": min(error, 1e-3), "pressure": error}
                    for name, bound in bounds.items():
                        off = np.abs(item[name][found] - queried[name][order]).max()
                        self.assertLessEqual(off, bound)
                    self.assertEqual(item["position"].flags.writeable, True)
                    self.assertEqual(item.units["pressure"], "Pa")
                    self.assertEqual(item.step, 10)

    def test_the_newest_comes_and_what_was_skipped_is_counted(self) -> None:
        with self.client.stream("fields", "position") as stream:
            self.client.start()
            last = 0
            for item in stream:
                self.assertEqual(item.sequence, last + 1 + item.skipped)
                last = item.sequence
                time.sleep(0.1)  # slower than the run
                if stream.stats.skipped > 10:
                    break
            self.assertGreater(last, 10)

    def test_a_box_and_a_refusal_that_names_the_entry(self) -> None:
        with self.client.stream("fields", "position", first=True, box=([0, 0], [0.5, 0.5])) as stream:
            item = stream.next(10)
            assert item
            self.assertTrue(0 < len(item["position"]) and (item["position"] <= 0.5).all())
        with self.assertRaises(meniscus.RefusedError) as refused:
            self.client.stream("fields", "presure")
        self.assertEqual(refused.exception.path, "fields[0].name")
        for wrong in ({"pack": "gzip"}, {"exact": "f16"}):
            with self.assertRaises(meniscus.RefusedError):
                self.client.stream("fields", "pressure", **wrong)

    def test_probes_and_events_come_as_they_are(self) -> None:
        with self.client.stream("probes", timeout=20) as probes, self.client.stream("events", timeout=20) as events:
            self.client.start()
            for item in probes:
                if item.step >= 5:
                    break
            self.assertGreater(item["front"], 1)
            self.assertEqual(item.units["front"], "m")
            self.client.pause()
            self.assertIn("paused", (event.what for event in events))

    def test_snapshot_files_come_byte_for_byte(self) -> None:
        self.client.step(3)
        path = Path(self.client.snapshot().path)
        whole = path.stat().st_size
        with self.client.stream("snapshots") as stream:
            files: dict[str, bytes] = {}
            while len(files.get(path.name, b"")) < whole:
                item = stream.next(60)
                assert item and item.file
                self.assertEqual(len(files.get(item.file, b"")), item.offset)
                files[item.file] = files.get(item.file, b"") + bytes(item.data)
        self.assertEqual(files[path.name], path.read_bytes())
        with self.client.stream("snapshots", since=stream.cursor, timeout=0.5) as stream:
            self.assertEqual(list(stream), [])

    def test_a_series_goes_on_behind_what_was_taken(self) -> None:
        def rows(since: Optional[meniscus.Cursor] = None) -> tuple[list[int], Optional[meniscus.Cursor]]:
            """All that are in the file: the last of them ends it."""
            with h5py.File(directory / "probes.hdf") as file:
                last = int(file["step"][-1])
            found: list[int] = []
            with self.client.stream("series", since=since) as stream:
                while last not in found:
                    item = stream.next(60)
                    assert item
                    found += [int(step) for step in item["step"]]
                return found, stream.cursor

        self.client.set({"output.probe_interval": 1e-3})
        self.client.run_until(0.02)
        directory = Path(self.client.checkpoint().path).parent
        first, cursor = rows()
        self.client.run_until(0.04)
        self.client.checkpoint()
        second, _ = rows(cursor)
        self.assertTrue(first and second)
        self.assertEqual(first + second, rows()[0])
        self.assertEqual(len(set(first + second)), len(first + second))

    def test_the_lines_of_the_documentation_take_streams(self) -> None:
        program, loops = re.subn(r"(?m)^    for item in stream:.*\n(?:        .*\n)+", r"\g<0>        break\n", readme_lines("Streams"))
        self.assertEqual(loops, 2)
        self.client.load("dambreak2d", {"resolution": 10, "end_time": 100}, start=True)
        printed = self.run_python(program, self.home)
        self.assertRegex(printed, r"^[\d.e-]+ \d+ [-\d.e]+ Pa\n\[0\.[^\]]*\] \[[^\]]*\]\n$")

    def test_the_documentation_shows_how_a_run_that_stands_still_is_seen(self) -> None:
        shown = readme_lines("Streams").partition("cursor = None")[0]
        program, loops = re.subn(r"(?m)^    for item in stream:.*\n(?:        .*\n)+", r"\g<0>        break\n", shown)
        self.assertEqual(loops, 1)
        self.client.step(1)
        self.assertRegex(self.run_python(program, self.home), r"^[\d.e-]+ 0 [-\d.e]+ Pa\n$")

    def test_a_word_that_stream_does_not_know_is_refused_by_its_name(self) -> None:
        for stream in (self.client.stream, meniscus.AsyncClient().stream):
            with self.assertRaisesRegex(TypeError, r"^(\w+\.)?stream\(\) got an unexpected keyword argument 'max_herz'$"):
                stream("fields", "pressure", max_herz=10)  # type: ignore[call-arg]

    def test_asyncio_has_the_same(self) -> None:
        async def take() -> meniscus.StreamItem:
            async with meniscus.AsyncClient(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
                async with client.stream("fields", "velocity", first=True, exact="f32", pack="zstd") as stream:
                    async for item in stream:
                        return item
                raise AssertionError("no item")

        item = asyncio.run(take())
        self.assertEqual(item["velocity"].dtype, np.float32)
        self.assertEqual(item["velocity"].shape[1], 2)


PIECE = 5000
DATA = np.arange(3000, dtype="<f8").reshape(1000, 3) / 4


class Misbehaving(threading.Thread):
    """The data socket of a daemon. manner: good, checksum, size, hole, stopped, forgotten, slow (to answer after a stop), silent."""

    def __init__(self, endpoint: str, manner: str, files: bool = False) -> None:
        super().__init__()
        self.manner, self.files, self.endpoint = manner, files, endpoint
        self.subscribed = self.resumed = self.cancelled = self.unsubscribed = 0
        self.granted = self.sent = self.sequence = self.offset = 0
        self.starts: list[pb.Cursor] = []
        self.end, self.waited_for = threading.Event(), threading.Event()
        self.context = zmq.Context()
        self.bind()

    def bind(self) -> None:
        self.router = self.context.socket(zmq.ROUTER)
        self.router.bind(self.endpoint)

    def run(self) -> None:
        while not self.end.is_set():
            if self.router.poll(20):
                peer, frame = self.router.recv_multipart()
                self.serve(peer, pb.StreamRequest.FromString(frame))
        self.router.close(0)
        self.context.term()

    def serve(self, peer: bytes, request: pb.StreamRequest) -> None:
        command = request.WhichOneof("command")
        if command == "unsubscribe":
            self.unsubscribed += 1
            return
        if command == "credit":
            self.granted += request.credit.bytes
        elif command == "cancel":
            self.cancelled += 1
            item = pb.StreamItem(stream=7, sequence=self.sequence, cancelled=pb.StreamEnd(code=meniscus_pb2.ABORTED))
            self.send(peer, item)
            self.sequence, self.offset = self.sequence + 1, 0
        else:
            self.answer(peer, request)
        while self.send_piece(peer):
            if self.manner in ("stopped", "forgotten", "slow") and self.subscribed + self.resumed == 1 and (self.sequence, self.offset) == (2, 2 * PIECE):
                time.sleep(0.1)
                self.router.close(0)
                time.sleep(0.1)
                self.bind()
                return

    def answer(self, peer: bytes, request: pb.StreamRequest) -> None:
        reply = pb.StreamReply(id=request.id, code=meniscus_pb2.OK, stream=7, chunk_bytes=PIECE)
        self.sent = 0
        if request.HasField("resume"):
            self.resumed += 1
            if self.manner == "slow":
                self.waited_for.wait(60)
            if self.manner == "forgotten":
                reply.code = meniscus_pb2.NOT_FOUND
            self.sequence, self.offset = request.resume.sequence, request.resume.offset
            reply.sequence, reply.offset = self.sequence, self.offset
            self.granted = 0 if self.manner == "forgotten" else request.resume.credit
        else:
            start = getattr(request.subscribe, "from")
            self.starts.append(start)
            self.subscribed += 1
            self.sequence, self.offset = start.row // 100 + 1, 0
            self.granted = request.subscribe.credit
            if self.subscribed == 2 and self.manner == "forgotten":  # started again, and has no case yet
                reply.code, self.granted = meniscus_pb2.FAILED_PRECONDITION, 0
            if self.subscribed > 1 and self.manner in ("checksum", "size", "hole"):
                self.manner = "good"
        self.router.send_multipart([peer, pb.StreamMessage(reply=reply).SerializeToString()])

    def send(self, peer: bytes, item: pb.StreamItem, *data: bytes) -> None:
        self.router.send_multipart([peer, pb.StreamMessage(item=item).SerializeToString(), *data])

    def send_piece(self, peer: bytes) -> bool:
        whole = DATA.tobytes()
        data = whole[self.offset : self.offset + PIECE]
        if self.manner == "silent" or self.granted < self.sent + len(data) + 400:
            return False
        item = pb.StreamItem(stream=7, sequence=self.sequence, offset=self.offset, size=len(whole) + (self.manner == "size"))
        if not self.offset and self.files:
            item.file.name = "snapshot-0000000001.hdf"
        elif not self.offset:
            checksum = xxhash.xxh64_intdigest(whole) ^ (self.manner == "checksum")
            item.arrays.add(name="x", type="<f8", shape=DATA.shape, raw_bytes=len(whole), packed_bytes=len(whole), xxh64=checksum)
        if self.offset + len(data) == len(whole):
            item.next.line, item.next.row = 5, 100 * self.sequence
            if self.files:
                item.xxh64 = xxhash.xxh64_intdigest(whole) ^ (self.manner == "checksum")
        self.send(peer, pb.StreamItem(stream=8, sequence=99, offset=0, size=1), b"x")  # of nobody's
        self.send(peer, item, data)
        self.sent += len(data) + 400
        self.offset += len(data) + (PIECE if self.manner == "hole" and self.offset == PIECE else 0)
        if self.offset >= len(whole):
            self.sequence, self.offset = self.sequence + 1, 0
        return True


class WithoutDaemon(unittest.TestCase):
    def begin(self, manner: str, what: str = "series", memory: int = 1 << 20) -> tuple[Misbehaving, Stream]:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        daemon = Misbehaving(f"ipc://{scratch.name}/data.ipc", manner, what == "snapshots")
        daemon.start()
        self.addCleanup(daemon.join)
        self.addCleanup(daemon.end.set)
        wish = subscription(what, ("x",) if what == "fields" else ())
        stream = Stream(f"ipc://{scratch.name}/control.ipc", None, what, wish, None, 10, memory)
        self.addCleanup(stream.close)
        return daemon, stream

    def check(self, item: Any, sequence: int) -> None:
        self.assertEqual(item.sequence, sequence)
        self.assertTrue((item["x"] == DATA).all())

    def test_items_are_paid_for_when_they_are_done_with(self) -> None:
        daemon, stream = self.begin("good", "fields")
        for sequence in range(1, 30):
            self.check(stream.next(10), sequence)
            self.assertLess(daemon.granted, sequence * DATA.nbytes * 1.5 + 600000)
        self.assertEqual((daemon.subscribed, stream.stats.items), (1, 29))

    def test_what_is_damaged_is_told_and_a_series_goes_on_without_a_gap(self) -> None:
        for manner in ("checksum", "size", "hole"):
            with self.subTest(manner):
                daemon, stream = self.begin(manner)
                with self.assertRaises(meniscus.CorruptError):
                    stream.next(10)
                for sequence in range(1, 60):
                    item = stream.next(10)
                    self.check(item, sequence)
                    assert item and item.cursor
                    self.assertEqual(item.cursor.row, 100 * sequence)
                self.assertEqual((daemon.subscribed, daemon.unsubscribed), (2, 1))

    def test_after_a_lost_connection_an_item_goes_on_where_its_bytes_ended(self) -> None:
        for manner, subscribed in (("stopped", 1), ("forgotten", 3)):
            with self.subTest(manner):
                daemon, stream = self.begin(manner)
                for sequence in range(1, 20):
                    self.check(stream.next(10), sequence)
                self.assertEqual((daemon.subscribed, daemon.resumed, stream.stats.reconnects), (subscribed, 1, 1))
                self.assertEqual(daemon.starts[-1].row, 100 if subscribed > 1 else 0)

    def test_an_answer_later_than_anybody_waits_is_that_to_the_one_request(self) -> None:
        daemon, stream = self.begin("slow")
        received, empty = 0, 0  # items; requests for one that ended without
        while received < 10:
            asked = daemon.resumed == 1
            item = stream.next(0.05)
            if item:
                self.check(item, received + 1)
            received, empty = received + bool(item), empty + (asked and item is None)
            if empty > 2:
                daemon.waited_for.set()
        self.assertGreater(empty, 2)
        self.assertEqual((daemon.subscribed, daemon.resumed), (1, 1))

    def test_asyncio_ends_whoever_waits_when_it_is_closed(self) -> None:
        daemon, other = self.begin("silent")
        endpoint = daemon.endpoint.replace("data.ipc", "control.ipc")

        async def iterate(stream: AsyncStream) -> int:
            return len([item async for item in stream])

        async def close_in_the_midst() -> None:
            stream = AsyncStream(endpoint, None, "series", subscription("series"), None, None, 1 << 20)
            waiting = [asyncio.ensure_future(iterate(stream)), asyncio.ensure_future(stream.next())]
            await asyncio.sleep(0.3)
            await stream.aclose()
            done, late = await asyncio.wait(waiting, timeout=10)
            self.assertFalse(late)
            self.assertEqual(waiting[0].result(), 0)
            self.assertIsInstance(waiting[1].exception(), RuntimeError)
            with self.assertRaises(RuntimeError):
                await stream.next()
            await stream.aclose()

        asyncio.run(close_in_the_midst())
        self.assertEqual(daemon.subscribed, 2)  # of both streams, one each
        until = time.monotonic() + 10
        while not daemon.unsubscribed and time.monotonic() < until:  # which nobody answers
            time.sleep(0.01)
        self.assertEqual(daemon.unsubscribed, 1)

    def test_a_file_comes_once_over_two_connections(self) -> None:
        for manner in ("good", "stopped", "forgotten"):
            with self.subTest(manner):
                _, stream = self.begin(manner, "snapshots")
                got, files = b"", 0
                while files < 3:
                    item = stream.next(10)
                    assert item
                    self.assertEqual(item.offset, len(got))
                    got += bytes(item.data)
                    if item.whole:
                        self.assertEqual(got, DATA.tobytes())
                        got, files = b"", files + 1

    def test_an_item_larger_than_there_is_memory_for_is_cancelled(self) -> None:
        daemon, stream = self.begin("good", "fields", memory=1000)
        with self.assertRaises(meniscus.MeniscusError) as refused:
            stream.next(10)
        self.assertEqual(refused.exception.status, "limit reached")
        with self.assertRaises(meniscus.MeniscusError):
            stream.next(10)
        for _ in range(200):
            if daemon.cancelled:
                return
            time.sleep(0.01)
        self.fail("it was not cancelled")

    def test_silence_ends_the_iteration(self) -> None:
        _, stream = self.begin("silent")
        self.assertIsNone(stream.next(0.1))


if __name__ == "__main__":
    unittest.main(verbosity=2)

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A client of 150 lines that was written from proto/README.md alone (tests/support/page_client.py) notices a lost connection and loses no row."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import ROOT, DaemonTest  # noqa: E402

PAGE = (ROOT / "proto" / "README.md").read_text()
COMPILE = re.findall(r"`protoc -I proto --python_out=DIR ([a-z. ]+)` \| `(\w+)`", PAGE)
MODULES = tempfile.TemporaryDirectory(prefix="mns-page-")


def compile_for(module: str, directory: str) -> None:
    """By the command that the page has for this module."""
    (files,) = [files for files, name in COMPILE if name == module]
    subprocess.run(["protoc", "-I", "proto", f"--python_out={directory}", *files.split()], cwd=ROOT, check=True)


compile_for("stream_pb2", MODULES.name)
sys.path.insert(0, MODULES.name)
import stream_pb2 as pb  # noqa: E402
from page_client import Series  # noqa: E402

CLIENT = ROOT / "tests" / "support" / "page_client.py"
CASE = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=1000", "--set", "output.probe_interval=1e-6"]
STOPPED = 9.5  # seconds: longer than the daemon waits for a sign of life of a connection


class PageClient(DaemonTest):
    def client(self, name: str) -> "tuple[subprocess.Popen[bytes], Path]":
        told = self.home / name
        with open(told, "wb") as out:
            client = subprocess.Popen(
                ["/usr/bin/python3", CLIENT, f"ipc://{self.home}/run/meniscus/default/data.ipc"], stdout=out,
                env=self.environment | {"PYTHONPATH": MODULES.name},
            )  # fmt: skip
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        return client, told

    @staticmethod
    def lines(told: Path, word: str) -> "list[list[str]]":
        return [line.split() for line in told.read_text().splitlines() if line.startswith(word)]

    def rows(self, told: Path) -> "list[int]":
        return [int(line[1]) for line in self.lines(told, "row")]

    def test_the_page_says_which_files_a_client_compiles(self) -> None:
        """Each set is whole by itself, and has no file that is of no use to it."""
        self.assertEqual([module for _, module in COMPILE], ["meniscus_pb2", "stream_pb2", "journal_pb2"])
        for files, module in COMPILE:
            with self.subTest(module), tempfile.TemporaryDirectory() as directory:
                compile_for(module, directory)
                words = f"import sys, {module}; print(*sorted(name for name in sys.modules if name.endswith('_pb2') and '.' not in name))"
                taken = subprocess.run([sys.executable, "-c", words], env={"PYTHONPATH": directory}, capture_output=True, text=True, check=True).stdout
                self.assertEqual(taken.split(), sorted(file.replace(".proto", "_pb2") for file in files.split()))

    def test_it_is_150_lines(self) -> None:
        self.assertLessEqual(len(CLIENT.read_text().splitlines()), 150)

    def test_silence_loses_nothing_and_an_idle_run_is_no_silence(self) -> None:
        self.meniscus("load", *CASE)
        self.meniscus("step", "20")
        (stopped, told), (_, idle) = self.client("stopped"), self.client("idle")
        self.wait_until(lambda: len(self.rows(told)) == 21 and len(self.rows(idle)) == 21)
        os.kill(stopped.pid, signal.SIGSTOP)
        time.sleep(STOPPED)
        self.meniscus("step", "20")
        os.kill(stopped.pid, signal.SIGCONT)
        self.wait_until(lambda: len(self.rows(told)) == 41)
        self.assertEqual(self.rows(told), list(range(41)))
        self.assertEqual(len(self.lines(told, "lost")), 1)
        self.assertEqual((len(self.lines(told, "resumed")), len(self.lines(told, "subscribed"))), (1, 1))
        self.wait_until(lambda: len(self.rows(idle)) == 41)
        time.sleep(1)
        self.assertEqual(self.rows(idle), list(range(41)))
        self.assertEqual(self.lines(idle, "lost"), [])

    def test_an_offset_without_a_sequence_is_refused_by_name(self) -> None:
        """As the page has it; without both the stream goes on behind what was sent whole, and with both within an item."""
        self.meniscus("load", *CASE)
        self.meniscus("step", "20")
        series = Series(f"ipc://{self.home}/run/meniscus/default/data.ipc")
        series.connect()
        self.addCleanup(lambda: series.socket.close(linger=0))
        series.subscribe()
        item = series.receive()[0].item
        while item.offset or not item.size:
            item = series.receive()[0].item
        series.connect()
        for offset in (1, item.size):
            reply = series.ask(resume=pb.ResumeStream(stream=series.stream, offset=offset, credit=1 << 20))
            self.assertEqual((reply.code, reply.path), (3, "offset"))
            self.assertRegex(reply.message, f"offset {offset} is of no item, .*give the sequence of the item that was under way, or leave out both")
        reply = series.ask(resume=pb.ResumeStream(stream=series.stream, offset=0, credit=1 << 20))
        self.assertEqual((reply.code, reply.sequence, reply.offset), (0, item.sequence + 1, 0), reply.message)
        reply = series.ask(resume=pb.ResumeStream(stream=series.stream, sequence=item.sequence, offset=8, credit=1 << 20))
        self.assertEqual((reply.code, reply.sequence, reply.offset), (0, item.sequence, 8), reply.message)

    def test_a_daemon_that_was_killed_is_followed_on(self) -> None:
        self.meniscus("load", *CASE)
        self.meniscus("step", "10")
        _, told = self.client("killed")
        self.wait_until(lambda: len(self.rows(told)) == 11)
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED")
        self.meniscus("step", "10")
        self.wait_until(lambda: self.rows(told)[-1] == 20)
        kept: "list[int]" = []
        for line in told.read_text().splitlines():
            word, _, rest = line.partition(" ")
            if word == "abandoned":
                del kept[int(rest):]
            elif word == "row":
                kept.append(int(rest.split()[0]))
        self.assertEqual(kept, list(range(21)))


if __name__ == "__main__":
    unittest.main()

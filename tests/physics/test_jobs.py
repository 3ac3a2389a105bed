#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Several things at once: told in order, with a fair part of the processors each, and none begun after an interruption."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from validation import jobs  # noqa: E402


class Jobs(unittest.TestCase):
    def test_results_come_in_order_however_many_go_at_once(self):
        second = threading.Event()

        def first() -> str:
            self.assertTrue(second.wait(10), "the second task is not run beside the first")
            return "one"

        tasks = {1: first, 2: lambda: second.set() or "two"}
        self.assertEqual(list(jobs.at_once(2, tasks)), [(1, "one"), (2, "two")])
        self.assertEqual(list(jobs.at_once(1, tasks)), [(1, "one"), (2, "two")])

    def test_runs_share_the_processors(self):
        for many, tasks, share in ((1, 3, jobs.processors()), (jobs.processors(), 99, 1), (99, 1, jobs.processors())):
            list(jobs.at_once(many, dict.fromkeys(range(tasks), lambda: None)))
            self.assertEqual(os.environ["OMP_NUM_THREADS"], str(share))

    def test_after_a_failure_nothing_more_is_begun(self):
        begun = []

        def fails() -> None:
            raise KeyboardInterrupt

        def task(k: int) -> None:
            begun.append(k)

        with self.assertRaises(KeyboardInterrupt):
            list(jobs.at_once(1, {0: fails} | {k: lambda k=k: task(k) or threading.Event().wait(0.05) for k in range(1, 50)}))
        self.assertLess(len(begun), 49)

    def test_a_task_that_goes_on_after_an_interruption_begins_no_further_program(self):
        first, over_after = threading.Event(), []

        def goes_on() -> None:
            for _ in range(500):
                with jobs.program(["true"]) as process:
                    process.wait()
                first.set()
                over_after.append(jobs.PROGRAMS.over)

        def is_interrupted() -> None:
            self.assertTrue(first.wait(60))
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            list(jobs.at_once(2, {0: is_interrupted, 1: goes_on}))
        self.assertLessEqual(over_after.count(True), 1, "one was under way, and others came after it")

    def test_a_program_that_is_interrupted_by_itself_ends_the_tasks(self):
        for signal_name in ("INT", "TERM", "KILL"):
            with self.subTest(signal_name):
                self.interrupted_by(signal_name)

    def interrupted_by(self, signal_name: str) -> None:
        begun = []

        def runs(k: int, *words: str) -> None:
            begun.append(k)
            with jobs.program(words) as process:
                process.wait()

        ends = {0: lambda: runs(0, "sleep", "600"), 1: lambda: runs(1, "sh", "-c", f"kill -{signal_name} $$"), 2: lambda: runs(2, "true")}
        with self.assertRaises(KeyboardInterrupt):
            list(jobs.at_once(2, ends))
        self.assertEqual(sorted(begun)[:2], [0, 1])
        self.assertRaises(KeyboardInterrupt, jobs.PROGRAMS.begin, ["true"])


WHOLE = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever this test's own caller ignores
signal.signal(signal.SIGHUP, signal.SIG_DFL)
sys.path.insert(0, sys.argv[1])
from validation import jobs

def task(k):
    for part in range(3):
        with jobs.program(["sh", "-c", f"echo {k} {part}; exec sleep 600"]) as process:
            process.wait()

jobs.heed_signals()
try:
    for _ in jobs.at_once(2, {k: lambda k=k: task(k) for k in range(5)}):
        pass
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


class Signals(unittest.TestCase):
    def test_what_tells_the_command_alone_ends_its_programs_and_begins_no_others(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            with self.subTest(number), tempfile.TemporaryFile("w+") as said, \
                    subprocess.Popen([sys.executable, "-c", WHOLE, str(Path(__file__).parent)], stdout=subprocess.PIPE, stderr=said, text=True) as whole:
                begun = sorted(whole.stdout.readline().split()[:2] for _ in range(2))
                self.assertEqual(begun, [["0", "0"], ["1", "0"]])
                whole.send_signal(number)
                rest = whole.stdout.read()
                whole.wait()
                self.assertEqual(rest, "interrupted\n")


if __name__ == "__main__":
    unittest.main()

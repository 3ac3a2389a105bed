#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Several things at once: told in order, with a fair part of the processors each, and none begun after an interruption."""

from __future__ import annotations

import os
import sys
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


if __name__ == "__main__":
    unittest.main()

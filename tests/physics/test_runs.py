#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs that are kept: one that came to its end or diverged is not made again, one that failed otherwise is."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import h5py

sys.path.insert(0, str(Path(__file__).parent))
from validation import runs  # noqa: E402


class Kept(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.code, self.summary, self.program, self.calls = 0, {"steps": 7, "error": {"message": "it grew"}}, "1", 0
        for name, value in (("BUILD", Path(scratch.name)), ("call", self.call), ("fingerprint", lambda case, settings: self.program)):
            patch = mock.patch.object(runs, name, value)
            patch.start()
            self.addCleanup(patch.stop)
        self.addCleanup(runs.SPENT.runs.clear)

    def call(self, command: "list[str]", log: Path) -> "tuple[int, str]":
        self.calls += 1
        directory = Path(command[command.index("--out") + 1])
        directory.mkdir()
        with h5py.File(directory / "probes.hdf", "w") as file:
            file["time"] = [0.0, 1.0]
            file["probes/front"] = [2.0, 3.0]
        return self.code, json.dumps(self.summary | {"exit_code": self.code, "cpu_s": 1.5}) if self.summary else ""

    def test_a_run_that_came_to_its_end(self) -> None:
        for _ in range(2):
            self.assertEqual(runs.attempt("a", "x=1").at("front", 0.5), 2.5)
        self.assertEqual(self.calls, 1)

    def test_a_run_that_diverged(self) -> None:
        self.code = runs.DIVERGED
        for _ in range(2):
            runs.SPENT.runs.clear()
            self.assertIsNone(runs.attempt("a", "x=1"))
            self.assertEqual(runs.SPENT.runs, {("a", "x=1"): 1.5})
        self.assertEqual(self.calls, 1)
        with self.assertRaises(subprocess.CalledProcessError) as raised:
            runs.run("a", "x=1")
        self.assertEqual((raised.exception.returncode, runs.told(raised.exception)["error"]["message"]), (runs.DIVERGED, "it grew"))

    def test_another_program_makes_it_again(self) -> None:
        self.code = runs.DIVERGED
        self.assertIsNone(runs.attempt("a"))
        self.program, self.code = "2", 0
        self.assertIsNotNone(runs.attempt("a"))
        self.assertEqual(self.calls, 2)

    def test_what_failed_otherwise_is_made_again(self) -> None:
        for self.code, self.summary in ((65, {"steps": 0}), (runs.DIVERGED, {}), (-9, {})):
            self.calls = 0
            for _ in range(2):
                self.assertRaises(subprocess.CalledProcessError, runs.run, "a")
            self.assertEqual(self.calls, 2)


if __name__ == "__main__":
    unittest.main()

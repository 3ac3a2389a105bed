#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A run that goes on where products are rounded otherwise: it does, and says so."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=10", "--set", "threads=1", "--resume", "auto"]
WARNING = "rounds in another way"


class Levels(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-levels-")
        self.addCleanup(scratch.cleanup)
        self.out = Path(scratch.name) / "run"

    def run_until(self, end: float, level: str | None = None) -> str:
        """What it says on standard error."""
        environment = {key: value for key, value in os.environ.items() if key != "MENISCUS_LEVEL"}
        environment |= {"MENISCUS_CASES": str(ROOT / "server" / "cases")} | ({"MENISCUS_LEVEL": level} if level else {})
        words = [BUILD / "meniscusd", "--batch", *CASE, "--out", self.out, "--set", f"end_time={end}"]
        done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def arithmetic(self) -> str:
        newest = max(self.out.glob("checkpoint-*.hdf"), key=lambda path: int(path.stem.split("-")[1]))
        with h5py.File(newest) as file:
            return str(file["meniscus"].attrs["arithmetic"].decode())

    def test_who_goes_on_with_another_arithmetic_is_told(self) -> None:
        self.assertNotIn(WARNING, self.run_until(0.1))
        usual = self.arithmetic()
        self.assertEqual(WARNING in self.run_until(0.2, "x86-64"), usual == "fused")
        self.assertEqual(self.arithmetic(), "separate")
        self.assertEqual(WARNING in self.run_until(0.3), usual == "fused")

    def test_who_goes_on_with_the_same_is_not(self) -> None:
        self.run_until(0.1)
        self.assertNotIn(WARNING, self.run_until(0.2))


if __name__ == "__main__":
    unittest.main()

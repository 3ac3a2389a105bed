#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""A sweep of 50 runs, killed at random moments and started again by the same command, ends with each of them done once, and equal
bit for bit to those that nobody disturbed."""

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

import h5py
import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT  # noqa: E402

RESOLUTIONS = range(6, 31)
SWEEP = {
    "CASE": "hydrostatic",
    "RESOLUTIONS": " ".join(map(str, RESOLUTIONS)),
    "SCHEMES": "riemann dissipation",
    "SETTINGS": "end_time=0.02 output.checkpoint_interval=0.004 output.snapshot_interval=0.005",
}
RUNS = 2 * len(RESOLUTIONS)
KILLS = 60
FEWEST = 10  # of each signal
LIMIT_S = 100.0


def descendants(root: int) -> "dict[int, str]":
    """The processes below this one, with the names of their programs."""
    parents: "dict[int, tuple[int, str]]" = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                name, rest = (entry / "stat").read_text().split("(", 1)[1].rsplit(")", 1)
            except (OSError, IndexError):
                continue  # it has ended
            parents[int(entry.name)] = (int(rest.split()[1]), name)
    found: "dict[int, str]" = {}
    grown = {root}
    while grown:
        grown = {pid for pid, (parent, _) in parents.items() if parent in grown and pid not in found}
        found |= {pid: parents[pid][1] for pid in grown}
    return found


class Kills(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-kills-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith(("MAKE", "MFLAGS"))}
        self.environment |= {"MENISCUS": str(BUILD / "meniscus"), "MENISCUS_CASES": str(ROOT / "server" / "cases"), "OMP_WAIT_POLICY": "passive"}

    def sweep(self, out: str) -> "list[str]":
        return ["make", "-s", "-j2", "-f", str(ROOT / "client/workflows/Makefile"), f"OUT={out}", *(f"{k}={v}" for k, v in SWEEP.items())]

    def start(self, out: str) -> "subprocess.Popen[bytes]":
        with open(self.home / "log", "ab") as log:
            return subprocess.Popen(self.sweep(out), env=self.environment, cwd=self.home, stdout=log, stderr=log)

    def kill_one(self, make: int, chance: random.Random) -> "signal.Signals | None":
        """Mostly a run, at times the job that waits for it. That it may have ended meanwhile is as it should be."""
        below = descendants(make)
        wanted = "python3" if chance.random() < 0.15 else "meniscusd"
        chosen = [pid for pid, name in below.items() if name.startswith(wanted)]
        if not chosen:
            return None
        number = chance.choice([signal.SIGKILL, signal.SIGTERM])
        try:
            os.kill(chance.choice(chosen), number)
        except ProcessLookupError:
            return None
        return number

    def disturbed(self) -> "list[signal.Signals]":
        """Kill, and give the same command again whenever it has ended short of the end."""
        chance, killed, starts = random.Random(5), [], 0
        until = time.monotonic() + LIMIT_S
        while time.monotonic() < until:
            make = self.start("disturbed")
            starts += 1
            while make.poll() is None:
                time.sleep(chance.uniform(0.02, 0.15))
                if len(killed) < KILLS and (number := self.kill_one(make.pid, chance)):
                    killed.append(number)
            if make.returncode == 0:
                print(f"{len(killed)} kills, {starts} starts of the sweep", file=sys.stderr)
                return killed
        raise AssertionError(f"not done in {LIMIT_S} s: {(self.home / 'log').read_text()[-4000:]}")

    def results(self, out: str) -> "dict[str, Any]":
        return {str(path.relative_to(self.home / out)): json.loads(path.read_text()) for path in (self.home / out).glob("*/*.json")}

    def series(self, directory: Path) -> "dict[str, Any]":
        with h5py.File(directory / "probes.hdf") as file:
            return {"time": file["time"][:], **{name: values[:] for name, values in file["probes"].items()}}

    def check_files(self, name: str) -> None:
        """Each sample and each snapshot is there once, with the same bits."""
        runs = [self.home / out / name.replace(".json", ".run") for out in ("disturbed", "undisturbed")]
        ours, theirs = (self.series(run) for run in runs)
        self.assertEqual(set(ours), set(theirs))
        for probe in ours:
            numpy.testing.assert_array_equal(ours[probe], theirs[probe], err_msg=f"{name}: {probe}")
        snapshots = [sorted(path.name for path in run.glob("snapshot*")) for run in runs]
        self.assertEqual(snapshots[0], snapshots[1], name)

    def test_each_run_is_done_once_with_the_same_bits(self) -> None:
        self.assertEqual(self.start("undisturbed").wait(LIMIT_S), 0, (self.home / "log").read_text()[-4000:])
        killed = self.disturbed()
        for number in (signal.SIGKILL, signal.SIGTERM):
            self.assertGreaterEqual(killed.count(number), FEWEST)
        ours, theirs = self.results("disturbed"), self.results("undisturbed")
        self.assertEqual((len(ours), set(ours)), (RUNS, set(theirs)))
        self.assertEqual(len({told["state_hash"] for told in theirs.values()}), RUNS)
        for name, told in ours.items():
            for key in ("state", "t", "steps", "state_hash", "probes"):
                self.assertEqual(told[key], theirs[name][key], (name, key))
            self.check_files(name)
        again = subprocess.run([*self.sweep("disturbed"), "-q"], env=self.environment, cwd=self.home, check=False)
        self.assertEqual(again.returncode, 0, "there is nothing left to do")


if __name__ == "__main__":
    unittest.main()

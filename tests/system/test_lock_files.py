#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Lock files: no other account of the machine can lock them, and so keep a daemon or a run from starting."""

import os
import stat
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, SMALL, DaemonTest  # noqa: E402

STRANGER = 34567


class LockFiles(DaemonTest):
    def run_case(self, out: Path, code: int) -> str:
        words = [BUILD / "meniscus", "run", *SMALL, "--set", "end_time=0.001", "--out", out]
        done = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_they_are_for_their_owner_alone(self) -> None:
        """Those of an earlier version too, once they are locked again."""
        out = self.home / "run-of-shell"
        self.meniscus("load", *SMALL)
        self.run_case(out, 0)
        (out / "lock").chmod(0o644)
        self.run_case(out, 0)
        locks = [path for path in self.home.rglob("lock") if stat.S_ISREG(path.stat().st_mode)]
        self.assertGreaterEqual(len(locks), 4, locks)  # of the name, the state directory, the daemon's run and the other one
        self.assertEqual({stat.S_IMODE(path.stat().st_mode) for path in locks}, {0o600})

    def test_one_of_a_stranger_is_refused(self) -> None:
        """In a directory where everybody may make files. Only root can make a file of somebody else; others see what they see."""
        out = self.home / "everybodys"
        out.mkdir()
        out.chmod(0o1777)
        (out / "lock").touch(mode=0o666)
        if os.geteuid() == 0:
            os.chown(out / "lock", STRANGER, STRANGER)
            self.assertIn(f"belongs to user {STRANGER}, who could keep this from starting; remove it", self.run_case(out, 74))
            (out / "lock").unlink()
        self.run_case(out, 0)


if __name__ == "__main__":
    unittest.main()

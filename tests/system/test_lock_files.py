#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Lock files: no other account of the machine can lock them, and so keep a daemon or a run from starting."""

import os
import stat
import subprocess
import sys
import tempfile
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

    def test_a_directory_that_others_can_write_is_told_of_with_the_remedy(self) -> None:
        """Not refused: volumes of containers are like that. Those that are made here are not, whatever the umask."""
        own, root = os.geteuid(), os.geteuid() == 0
        taken, put = "every account can take away or replace what is in", "every account can put files into"
        for mode, owner, said in (
            (0o777, own, (taken, "(mode 0777); `chmod o-w` it")), (0o1777, own, (put, "(mode 1777); `chmod o-w` it")),
            (0o775, own, ()), (0o700, own, ()),
            *(((0o755, STRANGER, (f"belongs to user {STRANGER}, who can take away or replace", "choose a directory of your own")),) if root else ()),
        ):
            with self.subTest(mode=oct(mode), owner=owner):
                state = Path(tempfile.mkdtemp(dir=self.home))
                state.chmod(mode)
                os.chown(state, owner, -1)
                told = self.run_case(state, 0) + self.log_of_daemon(state)
                doctor = subprocess.run([BUILD / "meniscus", "doctor", "--state-dir", state], env=self.environment, capture_output=True, text=True,
                                        timeout=60, check=False).stdout  # fmt: skip
                for part in said:
                    self.assertEqual(told.count(part), 2, told)
                    self.assertIn(part, doctor)
                self.assertEqual(told.count(str(state)), 2 if said else 0, told)

    def log_of_daemon(self, state: Path) -> str:
        """Of one that starts there, under a umask that forbids nothing, and makes a directory for a run; what it says of warnings."""
        words = [BUILD / "meniscusd", "--name", "other", "--state-dir", state, "--log-level", "warning", "--load", *SMALL]
        with subprocess.Popen(words, env=self.environment, stderr=subprocess.PIPE, text=True, umask=0) as daemon:
            self.wait_until((state / "dambreak2d" / "journal").exists)
            self.assertEqual(stat.S_IMODE((state / "dambreak2d").stat().st_mode), 0o775)
            daemon.terminate()
            assert daemon.stderr
            return daemon.stderr.read()


if __name__ == "__main__":
    unittest.main()

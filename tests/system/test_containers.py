#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""What a container has: a quota of processors, and us as process 1. In namespaces of Linux, as container engines make them."""

import json
import os
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, control_socket, surroundings  # noqa: E402

SHORT = ["dambreak2d", "--set", "resolution=10", "--set", "end_time=0.005", "--set", "threads=0"]
HALF = """mount -t tmpfs none /sys/fs/cgroup && mkdir /sys/fs/cgroup/cpu && cd /sys/fs/cgroup && echo 50000 100000 >cpu.max &&
echo 50000 >cpu/cpu.cfs_quota_us && echo 100000 >cpu/cpu.cfs_period_us && cd "$OLDPWD" && exec "$@" """


def unshare(*options: str) -> "list[str]":
    """The words that start a program in namespaces of its own."""
    for user in ([], ["--map-root-user"]):
        words = ["unshare", *user, *options]
        if subprocess.run([*words, "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True).returncode == 0:
            return words
    raise unittest.SkipTest("this user may not make namespaces")


class Containers(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-container-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        self.environment = surroundings(self.home)
        self.environment.pop("OMP_NUM_THREADS", None)

    def at_half(self, *words: "str | Path", **more: str) -> dict:
        """What a program prints as JSON that may use half of a processor, by the files of both versions of control groups."""
        done = subprocess.run([*unshare("-m"), "bash", "-c", HALF, "bash", *words], env=self.environment | more, cwd=self.home,
                              capture_output=True, text=True, timeout=60)  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_half_of_a_processor_is_one_thread(self) -> None:
        if len(os.sched_getaffinity(0)) < 2:
            self.skipTest("it would be one thread without a quota too")
        self.assertEqual(self.at_half(BUILD / "meniscus", "run", *SHORT, "-o", "json")["threads"], 1)
        self.assertEqual(self.at_half(BUILD / "meniscus", "run", *SHORT, "-o", "json", OMP_NUM_THREADS="2")["threads"], 2)
        self.assertEqual(self.at_half(BUILD / "meniscus", "check", *SHORT, "-o", "json")["threads"], 1)

    def test_doctor_tells_of_the_quota(self) -> None:
        checks = {check["name"]: check for check in self.at_half(BUILD / "meniscus", "doctor", "-o", "json")["checks"]}
        self.assertRegex(checks["threads"]["text"], r"^1 of \d+ processors.*; its control group allows 0\.5 at a time")

    def test_process_1_takes_note_of_the_end_of_orphans(self) -> None:
        words = [*unshare("-m", "-p", "-f", "--kill-child", "--mount-proc"), "bash", "-c", '(sleep 0.3 & sleep 1000 &); exec "$@"', "bash",
                 BUILD / "meniscusd", "--state-dir", self.home / "s"]  # fmt: skip
        with subprocess.Popen(words, env=self.environment, stderr=subprocess.DEVNULL) as process:
            try:
                first = self.only_child(process.pid)
                self.wait_for(lambda: control_socket(self.home).exists())
                self.wait_for(lambda: len(self.children(first)) == 1)
                os.kill(int(self.children(first)[0]), 9)
                self.wait_for(lambda: not self.children(first))
                os.kill(first, 15)
                self.assertEqual(process.wait(60), 0)
            finally:
                process.kill()

    def wait_for(self, what) -> None:  # type: ignore[no-untyped-def]
        until = time.monotonic() + 60
        while not what():
            self.assertLess(time.monotonic(), until, "it did not come")
            time.sleep(0.05)

    @staticmethod
    def children(parent: int) -> "list[str]":
        return subprocess.run(["ps", "--ppid", str(parent), "-o", "pid="], capture_output=True, text=True).stdout.split()

    def only_child(self, parent: int) -> int:
        self.wait_for(lambda: self.children(parent))
        return int(self.children(parent)[0])


if __name__ == "__main__":
    unittest.main()

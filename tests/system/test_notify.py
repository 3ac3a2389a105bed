#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What systemd hears from the daemon: a datagram socket plays systemd."""

import ctypes
import os
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DAEMON = Path(os.environ.get("BUILD", ROOT / "build")).resolve() / "meniscusd"
WATCHDOG_S = 1.0
# One step of it takes minutes: a solve of many iterations.
LONG_STEP = [
    "--load", "hydrostatic-isph", "--set", "resolution=400", "--set", "threads=1", "--start",
    "--set", "scheme.incompressible.solver=bicgstab", "--set", "scheme.incompressible.tolerance=1e-12",
    "--set", "scheme.incompressible.iterations=1000000",
]
PTRACE_ATTACH, PTRACE_DETACH, WAIT_ALL = 16, 17, 0x40000000
RUN_FOR_EVER = ["--load", "dambreak2d", "--set", "resolution=20", "--set", "end_time=1000", "--start"]


class Notify(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.socket.close)
        self.socket.bind(str(self.home / "notify"))
        self.heard: list[str] = []

    def start(self, *options: str) -> subprocess.Popen[bytes]:
        environment = os.environ | {
            "NOTIFY_SOCKET": str(self.home / "notify"),
            "WATCHDOG_USEC": str(int(WATCHDOG_S * 1e6)),
            "XDG_RUNTIME_DIR": str(self.home / "run"),
        }
        (self.home / "run").mkdir(mode=0o700)
        log = open(self.home / "log", "wb")
        self.addCleanup(log.close)
        daemon = subprocess.Popen(
            [DAEMON, "--name", "n", "--state-dir", self.home / "state", *options],
            env=environment, cwd=ROOT, stdout=log, stderr=log,
        )
        self.addCleanup(self.end, daemon)
        return daemon

    def end(self, daemon: subprocess.Popen[bytes]) -> None:
        daemon.kill()
        daemon.wait()

    def listen(self, seconds: float) -> list[str]:
        """Lines that arrive within so many seconds."""
        lines: list[str] = []
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            self.socket.settimeout(left)
            try:
                lines += self.socket.recv(4096).decode().splitlines()
            except TimeoutError:
                break
        self.heard += lines
        return lines

    def wait_for(self, begin: str, seconds: float = 30) -> str:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            for line in self.listen(0.1):
                if line.startswith(begin):
                    return line
        log = (self.home / "log").read_text(errors="replace")
        self.fail(f"no {begin!r} within {seconds} s; heard {self.heard}\n{log}")

    def checkpoints(self) -> list[Path]:
        return list((self.home / "state").rglob("checkpoint-*.hdf"))

    def test_ready_is_said_once_commands_are_taken(self) -> None:
        self.start()
        self.wait_for("READY=1")
        self.assertTrue((self.home / "run/meniscus/n/control.ipc").is_socket())

    def test_watchdog_is_fed_while_idle(self) -> None:
        self.start()
        self.wait_for("READY=1")
        beats = self.listen(4 * WATCHDOG_S).count("WATCHDOG=1")
        self.assertGreaterEqual(beats, 4, "at least one within each interval")

    def test_watchdog_is_fed_and_status_told_while_running(self) -> None:
        self.start(*RUN_FOR_EVER)
        self.wait_for("READY=1")
        self.wait_for("STATUS=")
        lines = self.listen(4 * WATCHDOG_S)
        self.assertGreaterEqual(lines.count("WATCHDOG=1"), 4)
        told = {line for line in lines if line.startswith("STATUS=")}
        self.assertGreaterEqual(len(told), 2, "the status follows the run")
        self.assertTrue(any("step" in line for line in told), told)

    def begin_long_step(self) -> subprocess.Popen[bytes]:
        daemon = self.start(*LONG_STEP)
        self.wait_for("READY=1")
        self.wait_for("STATUS=RUNNING")
        return daemon

    def assert_no_step_has_ended(self) -> None:
        told = [line for line in self.heard if line.startswith("STATUS=RUNNING")]
        self.assertFalse([line for line in told if "step 0" not in line], "the step is too short for this test")

    def test_watchdog_is_fed_within_a_step_that_takes_long(self) -> None:
        self.begin_long_step()
        for _ in range(6):
            self.wait_for("WATCHDOG=1")
        self.assert_no_step_has_ended()

    def test_watchdog_misses_a_solver_that_hangs_within_a_step(self) -> None:
        """One thread is stopped, the one that computes; the others go on."""
        daemon = self.begin_long_step()
        self.listen(2 * WATCHDOG_S)
        ran: dict[int, int] = {}
        for task in Path(f"/proc/{daemon.pid}/task").iterdir():
            ran[int(task.name)] = int((task / "stat").read_text().rsplit(")", 1)[1].split()[11])
        solver = max(ran, key=lambda thread: ran[thread])
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.ptrace(PTRACE_ATTACH, solver, None, None) != 0:
            self.skipTest("this machine lets nobody stop a thread")
        os.waitpid(solver, WAIT_ALL)
        try:
            self.listen(0.5 * WATCHDOG_S)  # what it has done before
            self.assertEqual(self.listen(4 * WATCHDOG_S).count("WATCHDOG=1"), 0)
        finally:
            libc.ptrace(PTRACE_DETACH, solver, None, None)
        self.wait_for("WATCHDOG=1")
        self.assert_no_step_has_ended()

    def test_sigterm_while_running_leaves_a_checkpoint_and_ends_cleanly(self) -> None:
        daemon = self.start(*RUN_FOR_EVER)
        self.wait_for("READY=1")
        self.listen(1.5)
        daemon.send_signal(signal.SIGTERM)
        self.wait_for("STOPPING=1")
        self.assertEqual(daemon.wait(30), 0)
        self.assertEqual(len(self.checkpoints()), 1)
        self.assertEqual(list((self.home / "state").rglob("*.part")), [])

    def test_sigterm_while_idle_ends_at_once(self) -> None:
        daemon = self.start()
        self.wait_for("READY=1")
        daemon.send_signal(signal.SIGTERM)
        self.wait_for("STOPPING=1")
        self.assertEqual(daemon.wait(5), 0)

    def test_sigusr1_writes_a_checkpoint_and_the_run_goes_on(self) -> None:
        daemon = self.start(*RUN_FOR_EVER)
        self.wait_for("READY=1")
        self.listen(1.5)
        daemon.send_signal(signal.SIGUSR1)
        self.listen(3)
        self.assertEqual(len(self.checkpoints()), 1)
        self.assertIsNone(daemon.poll())
        self.wait_for("WATCHDOG=1")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: BSD-3-Clause
"""A daemon for a test: in directories of its own, ended with the test, its log shown if it did not end well."""

import json
import os
import platform
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any, Callable, Optional, Sequence

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("BUILD", ROOT / "build")).resolve()
CHOICES = ("MENISCUS_DAEMON", "MENISCUS_KEY", "MENISCUS_SERVER_KEY", "MENISCUS_KEYS")
IN_MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # a directory where nothing waits for a disk, or that of all
SMALL = ["dambreak2d", "--set", "resolution=20"]


def at_length() -> bool:
    """Whether there is time for more of the same, as in `make nightly` and for who runs a file by hand."""
    return os.environ.get("MENISCUS_TESTS", "nightly") == "nightly"


def of_nightly(test: Callable[..., None]) -> Optional[Callable[..., None]]:
    """A test that is of `make nightly` in a file that is not."""
    return test if at_length() else None


def free_ports() -> int:
    """The first of three in a row that nobody has at this moment."""
    while True:
        with socket.socket() as first, socket.socket() as second, socket.socket() as third:
            first.bind(("127.0.0.1", 0))
            port = int(first.getsockname()[1])
            try:
                second.bind(("127.0.0.1", port + 1))
                third.bind(("127.0.0.1", port + 2))
            except (OSError, OverflowError):
                continue
            return port


def surroundings(home: Path) -> dict[str, str]:
    """The environment that leads a daemon and its clients to a directory, which is there."""
    (home / "run").mkdir(mode=0o700)
    clean = {key: value for key, value in os.environ.items() if key not in CHOICES}
    return clean | {
        "XDG_RUNTIME_DIR": str(home / "run"),
        "MENISCUS_CASES": str(ROOT / "server" / "cases"),
        "OMP_WAIT_POLICY": "passive",
    }


def old_machine() -> dict[str, str]:
    """What has a daemon compute as machines that cannot fuse products with sums; skips the test where none are that old."""
    if platform.machine() != "x86_64":
        raise unittest.SkipTest("all machines of this architecture fuse products with sums")
    return {"MENISCUS_LEVEL": "x86-64"}


def readme_lines(section: str) -> str:
    """The program that a section of the Python client's README shows."""
    text = (ROOT / "client" / "python" / "README.md").read_text()
    _, _, rest = text.partition(f"\n## {section}\n")
    _, _, program = rest.partition("\n## ")[0].partition("```python\n")
    assert program, f"the README shows no program in its section {section}"
    return program.partition("```")[0]


def control_socket(home: Path) -> Path:
    return home / "run" / "meniscus" / "default" / "control.ipc"


def start_in(home: Path, environment: dict[str, str], options: "Sequence[str | Path]",
             program: Path = BUILD / "meniscusd") -> "subprocess.Popen[bytes]":
    """Start a daemon there, and wait until clients can reach it. One that was killed has left a socket, which says nothing."""
    control_socket(home).unlink(missing_ok=True)
    with open(home / "log", "ab") as log:
        daemon = subprocess.Popen(
            [program, "--name", "default", "--state-dir", home / "state", *options],
            env=environment, stdout=log, stderr=log,
        )
    until = time.monotonic() + 20
    while not control_socket(home).exists() and daemon.poll() is None and time.monotonic() < until:
        time.sleep(0.01)
    return daemon


class DaemonTest(unittest.TestCase):
    """Tests that share one daemon, which each finds EMPTY. self.environment leads clients to it."""

    options: list[str] = []  # of the daemon, besides its name and directory
    parent: Optional[str] = None  # of its directories
    home: Path
    environment: dict[str, str]
    daemon: "subprocess.Popen[bytes]"

    @classmethod
    def setUpClass(cls) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-", dir=cls.parent)
        cls.addClassCleanup(scratch.cleanup)
        cls.home = Path(scratch.name)
        cls.environment = surroundings(cls.home)
        cls.start_daemon()
        cls.addClassCleanup(lambda: cls.end_daemon())

    @classmethod
    def start_daemon(cls) -> None:
        cls.daemon = start_in(cls.home, cls.environment, cls.options)

    @classmethod
    def kill_daemon(cls) -> None:
        """As a crash ends it, and start it again."""
        cls.daemon.kill()
        cls.daemon.wait()
        cls.start_daemon()

    def leave_and_come_back(self) -> None:
        """As a service is started anew."""
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(60), 0)
        type(self).start_daemon()

    @classmethod
    def end_daemon(cls) -> None:
        cls.daemon.terminate()
        status = cls.daemon.wait(timeout=60)
        if status != 0:
            print((cls.home / "log").read_text()[-4000:])
            raise AssertionError(f"the daemon ended with {status}")

    def meniscus(self, *words: str, code: int = 0, timeout: float = 90) -> "subprocess.CompletedProcess[str]":
        """Run the command line; its exit code must be `code`."""
        done = subprocess.run(
            [BUILD / "meniscus", *words], env=self.environment, capture_output=True, text=True, timeout=timeout
        )
        self.assertEqual(done.returncode, code, f"meniscus {' '.join(words)}: {done.stdout}{done.stderr}")
        return done

    def wait_until(self, what: Callable[[], bool], seconds: float = 60) -> None:
        """Look again and again, as no machine is too slow; seconds: of patience."""
        until = time.monotonic() + seconds
        while not what():
            self.assertLess(time.monotonic(), until, "it did not come")
            time.sleep(0.02)

    def ask(self, *words: str, code: int = 0, timeout: float = 90) -> Any:
        """The same with -o json: what it printed, as one object."""
        lines = self.meniscus(*words, "-o", "json", code=code, timeout=timeout).stdout.splitlines()
        self.assertEqual(len(lines), 1, lines)
        return json.loads(lines[0])

    def run_python(self, program: str, here: Path) -> str:
        """What a program of the Python client prints, in a directory."""
        done = subprocess.run(
            ["/usr/bin/python3", "-c", program], env=self.environment | {"PYTHONPATH": str(BUILD / "python")}, cwd=here,
            capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def listen_late(self, seconds: float = 0.15) -> None:
        """For a moment nobody is where the daemon listens, as right after its start."""
        socket_file = control_socket(self.home)
        away = socket_file.with_name("away")
        socket_file.rename(away)
        back = threading.Timer(seconds, away.rename, [socket_file])
        back.start()
        self.addCleanup(back.join)

    def tearDown(self) -> None:
        state = self.ask("status")["state"]
        if state == "RUNNING":
            self.meniscus("pause")
        if state != "EMPTY":
            self.meniscus("stop")

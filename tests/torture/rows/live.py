# SPDX-License-Identifier: BSD-3-Clause
"""A daemon for a row, what computes in it, and the programs that ask it or get in its way. All end with their block."""

from __future__ import annotations

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

from daemon import BUILD, ROOT, control_socket, start_in, surroundings

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402

PATIENCE_S = 60.0


class Daemon:
    """In directories of its own; `with` ends it."""

    def __init__(self, *options: "str | Path", **environment: str) -> None:
        self._scratch = tempfile.TemporaryDirectory(prefix="mns-torture-", ignore_cleanup_errors=True)
        self.home = Path(self._scratch.name)
        self.environment = surroundings(self.home) | environment
        self.options = list(options)
        self.environment["MENISCUS_KEYS"] = str(self.home / "keys")
        self.endpoint = f"ipc://{control_socket(self.home)}"
        self.telemetry = self.endpoint.replace("control.ipc", "telemetry.ipc")

    def __enter__(self) -> Daemon:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]
        if "--listen" in self.options:  # which takes somebody who may come
            self.command("keys", "new", "ada", "--role", "admin").check_returncode()
        self.start()
        return self

    def __exit__(self, *_: Any) -> None:
        self.process.terminate()
        try:
            self.process.wait(PATIENCE_S / 3)
        except subprocess.TimeoutExpired:
            self.kill()
        self._scratch.cleanup()

    def start(self) -> None:
        self.process = start_in(self.home, self.environment, self.options)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    @property
    def alive(self) -> bool:
        return self.process.poll() is None

    def client(self, timeout: float = PATIENCE_S) -> meniscus.Client:
        return meniscus.Client(self.endpoint, timeout=timeout)

    def command(self, *words: "str | Path") -> "subprocess.CompletedProcess[str]":
        return subprocess.run([BUILD / "meniscus", *words], env=self.environment, capture_output=True, text=True, timeout=PATIENCE_S)

    def memory_mib(self) -> float:
        """That is in use now, what is mapped and not touched aside."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0]) / 1024


@contextmanager
def beside(program: str, *words: object, ready: bool = False) -> Iterator["subprocess.Popen[str]"]:
    """One of the programs of tests/torture, killed at the end of the block. ready: wait until it says so."""
    process = subprocess.Popen([BUILD / "tests" / "torture" / program, *map(str, words)], stdout=subprocess.PIPE, text=True)
    try:
        if ready and process.stdout and process.stdout.readline() != "ready\n":
            raise RuntimeError(f"{program} did not get ready")
        yield process
    finally:
        process.kill()
        process.wait()
        if process.stdout:
            process.stdout.close()


def told(program: str, *words: object) -> Any:
    """What one of these programs has to say when it has ended, as an object."""
    done = subprocess.run([BUILD / "tests" / "torture" / program, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{program}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def computing(client: meniscus.Client, resolution: float, **settings: object) -> None:
    """A dam break without end, once its first steps are over."""
    threads = len(os.sched_getaffinity(0))
    client.load("dambreak2d", {"resolution": resolution, "end_time": 1e4, "threads": threads} | settings, start=True)
    client.wait(["FAULT"], step=5)


def pace(client: meniscus.Client, seconds: float) -> float:
    """Steps per second of a run that nobody disturbs but whoever is meant to."""
    first, began = client.status().step or 0, time.monotonic()
    time.sleep(seconds)
    return ((client.status().step or 0) - first) / (time.monotonic() - began)


@dataclass(frozen=True)
class Loss:
    """The share of its pace that a run loses to company, and of all processors what the daemon then takes more beside its solver."""

    share: float
    error: float  # standard error of the share: the machine's own unrest
    beside: float

    @property
    def note(self) -> str:
        return f"+- {100 * self.error:.2g} %; it takes {100 * self.beside:.2g} % of the processors beside the solver"


def beside_solver(daemon: Daemon) -> float:
    """Processor time [s] that threads of the daemon have had which do not solve: those that are not nice."""
    spent = 0
    for task in Path(f"/proc/{daemon.process.pid}/task").iterdir():
        with suppress(OSError):  # it has ended
            words = (task / "stat").read_text().rsplit(")", 1)[1].split()
            if int(words[16]) <= 0:
                spent += int(words[11]) + int(words[12])
    return spent / os.sysconf("SC_CLK_TCK")


def loss(daemon: Daemon, client: meniscus.Client, seconds: float, turns: int, company: Callable[[], Any]) -> Loss:
    """It is taken in turns, before, during and after, so that drifts of the flow and the machine cancel."""
    losses, beside_alone, beside_with = [], 0.0, 0.0

    def look() -> tuple[float, float]:
        spent = beside_solver(daemon)
        return pace(client, seconds), beside_solver(daemon) - spent

    before, spent = look()
    for _ in range(turns):
        beside_alone += spent
        with company():
            during, spent = look()
            beside_with += spent
        after, spent = look()
        losses.append(1 - 2 * during / (before + after))
        before = after
    error = statistics.stdev(losses) / math.sqrt(turns) if turns > 1 else math.inf
    return Loss(statistics.fmean(losses), error, (beside_with - beside_alone) / (seconds * turns * len(os.sched_getaffinity(0))))


def test_program(words: Sequence["str | Path"], seconds: float, **environment: str) -> tuple[int, int, str]:
    """Run a program of the tests: how many of its tests passed and failed, and all it said. One that hangs or dies has failed."""
    surroundings_of_tests = os.environ | {"BUILD": str(BUILD), "CMOCKA_MESSAGE_OUTPUT": "TAP", "OMP_WAIT_POLICY": "passive"} | environment
    process = subprocess.Popen(list(map(str, words)), cwd=ROOT, env=surroundings_of_tests, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        said, _ = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        said, _ = process.communicate()
        said += f"\nstill running after {seconds:g} s"
    passed, failed = _count(said)
    return passed, failed or int(process.returncode != 0), said


def _count(said: str) -> tuple[int, int]:
    """Of TAP, or of unittest. What was skipped has shown nothing."""
    lines = said.splitlines()
    failed = sum(line.startswith("not ok") or "# SKIP" in line for line in lines)
    passed = sum(line.startswith("ok") and "# SKIP" not in line for line in lines)
    ran = [int(line.split()[1]) for line in lines if line.startswith("Ran ")]
    if not ran:
        return passed, failed
    summary = next((line for line in reversed(lines) if line.startswith(("OK", "FAILED"))), "FAILED (errors=1)")
    bad = sum(int(part.split("=")[1]) for part in summary.strip(")").replace("(", " ").replace(",", " ").split() if "=" in part)
    return ran[-1] - bad, bad

# SPDX-License-Identifier: BSD-3-Clause
"""What ends other programs: a solver that diverges, memory that ends, a disk that is full. The daemon still answers."""

from __future__ import annotations

import resource
import sys
from typing import Iterator

from .live import Daemon, meniscus, test_program, told
from .metrics import Metric, Size, all_of

ADDRESSES = 3 << 30  # bytes that the daemon may have


def faults(size: Size) -> Iterator[Metric]:
    yield from _diverged(size)
    yield from _without_memory()
    passed, failed, said = test_program([sys.executable, "tests/system/test_disk_full.py"], 240)
    if failed:
        sys.stderr.write(said[-3000:])
    yield all_of("a full disk: tests that passed", passed, passed + failed)


def _diverged(size: Size) -> Iterator[Metric]:
    with Daemon() as daemon, daemon.client() as client:
        client.load("dambreak2d", {"resolution": 20, "threads": 1, "end_time": 10}, start=True)
        client.set({"gravity": [1e12, -1e12]})
        client.wait(["FAULT"], timeout=30)
        status = client.status()
        waits = told("round_trips", daemon.endpoint, size.seconds / 2, 0.5)
        answers = [status.state == "FAULT", status.fault_reason == "diverged", bool(client.query()), bool(client.particles(limit=10**6)),
                   client.snapshot().step == status.step, client.reset().state == "READY"]
        client.set({"gravity": [0, -1]})
        answers.append(client.step(5).state == "PAUSED")
    yield all_of("a diverged solver: status, query, particles, snapshot, reset, and on", sum(answers), len(answers))
    yield Metric("a diverged solver: status, 99 %", waits["p99_ms"], "ms", high=2)


def _without_memory() -> Iterator[Metric]:
    """Cases that need ever more, until there is no more; each is refused or runs, and the one before goes on where it was."""
    with Daemon() as daemon, daemon.client() as client:
        resource.prlimit(daemon.process.pid, resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
        refused = answered = tried = 0
        for resolution in (20, 2000, 4000, 8000, 16000, 40):
            tried += 1
            try:
                client.load("dambreak2d", {"resolution": resolution, "threads": 1, "end_time": 0.1})
                client.step(1)
            except meniscus.MeniscusError as error:
                refused += error.status in ("out of memory", "limit reached")
            answered += daemon.alive and bool(client.status().state)
        last = client.step(3)
    yield all_of("memory that ends: loads after which the daemon still answers", answered, tried, f"{refused} refused")
    yield all_of("memory that ends: a small case runs after all", int(last.state == "PAUSED"), 1)
    yield Metric("memory that ends: loads refused", refused, low=2)

# SPDX-License-Identifier: BSD-3-Clause
"""What those cost who only listen, and those who have stopped to."""

from __future__ import annotations

import os
import signal
import statistics
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Iterator

from .live import Daemon, beside, computing, loss, told
from .metrics import Metric, Size
from .streams import takers

PROBES, FIELDS, HERTZ, MEMORY_MIB = 32, 4, 10.0, 256
LISTEN_S = 600  # the longest that a generator lives by itself
TURNS = 3  # times as many, for differences of a hundredth
SAMPLES = {"output.probe_interval": 0.002}  # one for about ten steps


@contextmanager
def subscribers(daemon: Daemon, count: int, topic: str = "", stopped: bool = False) -> Iterator[Any]:
    """Of the telemetry, all of them connected; stopped: in the midst of it."""
    with beside("subscribers", daemon.telemetry, count, LISTEN_S, topic, ready=True) as process:
        if stopped:
            os.kill(process.pid, signal.SIGSTOP)
        yield process


def _seconds_of(pid: int) -> float:
    """Of processors, that a process has had."""
    times = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]
    return sum(map(int, times)) / os.sysconf("SC_CLK_TCK")


@contextmanager
def _own_time(shares: "list[float]", *processes: Any) -> Iterator[None]:
    """Of all processors, what the company itself takes while the block lasts."""
    began, spent = time.monotonic(), sum(_seconds_of(process.pid) for process in processes)
    yield
    taken = sum(_seconds_of(process.pid) for process in processes) - spent
    shares.append(taken / (time.monotonic() - began) / len(os.sched_getaffinity(0)))


def few(size: Size) -> Iterator[Metric]:
    """Subscribers of probes and of fields, with a processor to themselves and without."""
    processors = len(os.sched_getaffinity(0))
    for threads, most, where in ((max(1, processors - 1), 0.01, "a processor to spare"), (processors, 0.03, "none to spare")):
        with Daemon() as daemon, daemon.client() as client:
            computing(client, size.resolution, threads=threads, **SAMPLES)
            own: "list[float]" = []

            @contextmanager
            def company() -> Iterator[None]:
                with subscribers(daemon, PROBES, "probe") as listening, takers(daemon, FIELDS, HERTZ) as taking, _own_time(own, listening, taking):
                    yield

            lost = loss(daemon, client, size.window, TURNS * size.turns, company)
            yield Metric(f"steps/s lost to {PROBES} subscribers of probes and {FIELDS} of fields, {where}", 100 * lost.share, "%",
                         high=100 * most, note=f"{lost.note}, they themselves {100 * statistics.fmean(own):.2g} %")


def many(size: Size) -> Iterator[Metric]:
    """As many subscribers that listen, and then as many that were stopped: the pace, the daemon's memory, and another client's wait."""
    for stopped, kind in ((False, "that listen"), (True, "that were stopped")):
        yield from _many(size, stopped, f"{size.subscribers} subscribers {kind}")


def _many(size: Size, stopped: bool, who: str) -> Iterator[Metric]:
    with Daemon() as daemon, daemon.client() as client:
        computing(client, size.resolution)
        before, alone = daemon.memory_mib(), told("round_trips", daemon.endpoint, size.seconds)
        grown, waits, own = [0.0], [], []

        @contextmanager
        def company() -> Iterator[None]:
            with subscribers(daemon, size.subscribers, stopped=stopped) as process:
                with _own_time(own, process):
                    yield
                waits.append(told("round_trips", daemon.endpoint, size.window)["p99_ms"])
                grown.append(daemon.memory_mib() - before)

        many_subscribers: Callable[[], Any] = company
        lost = loss(daemon, client, size.window, TURNS * size.turns, many_subscribers)
    yield Metric(f"steps/s lost to {who}", 100 * lost.share, "%", high=2, note=f"{lost.note}, they themselves {100 * statistics.fmean(own):.2g} %")
    yield Metric(f"memory that the daemon takes for {who}", max(grown), "MiB", high=MEMORY_MIB)
    yield Metric(f"status of a healthy client among {who}, 99 %, as many times that alone", statistics.median(waits) / alone["p99_ms"], high=2,
                 note=f"{alone['p99_ms']:.3g} ms alone")

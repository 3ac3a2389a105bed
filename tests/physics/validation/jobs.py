# SPDX-License-Identifier: BSD-3-Clause
"""Several things at once, told in their order: the output is the same however many go at a time. After an interruption nothing more begins."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

Name = TypeVar("Name")
Result = TypeVar("Result")


def processors() -> int:
    """That this process may use."""
    return len(os.sched_getaffinity(0))


def add_option(parser: argparse.ArgumentParser) -> None:
    def count(text: str) -> int:
        if int(text) < 1:
            raise ValueError
        return int(text)

    parser.add_argument("--jobs", type=count, default=processors(), metavar="N",
                        help="runs at a time, which share the processors; default: as many as there are processors")


class Programs:
    """The programs that tasks run. A task runs several, one after another, so each is refused here once the tasks are interrupted."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.running: set[subprocess.Popen] = set()
        self.over = False

    def begin(self, command: Sequence[str], **options: Any) -> subprocess.Popen:
        with self.lock:
            if self.over:
                raise KeyboardInterrupt
            program = subprocess.Popen(command, **options)
            self.running.add(program)
            return program

    def ended(self, program: subprocess.Popen) -> None:
        with self.lock:
            self.running.discard(program)

    def interrupt(self) -> None:
        """End all of them, and refuse others. Ctrl-C reaches them without this; `kill` reaches only this process."""
        with self.lock:
            self.over = True
            for program in self.running:
                if program.returncode is None:  # not terminate(): it collects the exit status that the waiting thread needs
                    with suppress(ProcessLookupError):  # it has just been reaped
                        os.kill(program.pid, signal.SIGTERM)


PROGRAMS = Programs()
# Exit codes: MNS_EXIT_AGAIN of <meniscus/exit.h>, and what Popen makes of signals. A program that is killed, as where memory is short, has no verdict.
INTERRUPTED = (75, -signal.SIGINT, -signal.SIGTERM, -signal.SIGKILL)


@contextmanager
def program(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen]:
    """A program that a task runs. It ends when the tasks are interrupted; KeyboardInterrupt is raised when they were before it began, and when
    the program itself was interrupted, which interrupts the tasks as well."""
    with PROGRAMS.begin(command, **options) as process:
        try:
            yield process
        finally:
            PROGRAMS.ended(process)
    if process.returncode in INTERRUPTED:
        PROGRAMS.interrupt()
        raise KeyboardInterrupt


def heed_signals() -> None:
    """SIGTERM, and a terminal that closes, end this process as Ctrl-C does."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def at_once(jobs: int, tasks: Mapping[Name, Callable[[], Result]]) -> Iterator[tuple[Name, Result]]:
    """What the tasks return, in their order. A task makes one run at a time, and each run has its part of the processors: threads
    of one run that have to share one with another's wait for each other most of the time."""
    os.environ["OMP_NUM_THREADS"] = str(max(1, processors() // max(1, min(jobs, len(tasks)))))
    PROGRAMS.over = False
    pool = ThreadPoolExecutor(jobs)
    try:
        futures = {name: pool.submit(task) for name, task in tasks.items()}
        for name, future in futures.items():
            while not future.done():  # a signal that comes just before a wait does not end it
                wait([future], timeout=0.2)
            yield name, future.result()
    except BaseException:
        PROGRAMS.interrupt()
        raise
    finally:
        pool.shutdown(cancel_futures=True)

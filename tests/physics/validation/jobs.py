# SPDX-License-Identifier: BSD-3-Clause
"""Several things at once, told in their order: the output is the same however many go at a time."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

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


def at_once(jobs: int, tasks: Mapping[Name, Callable[[], Result]]) -> Iterator[tuple[Name, Result]]:
    """What the tasks return, in their order. A task makes one run at a time, and each run has its part of the processors: threads
    of one run that have to share one with another's wait for each other most of the time."""
    os.environ["OMP_NUM_THREADS"] = str(max(1, processors() // max(1, min(jobs, len(tasks)))))
    pool = ThreadPoolExecutor(jobs)
    try:
        futures = {name: pool.submit(task) for name, task in tasks.items()}
        for name, future in futures.items():
            yield name, future.result()
    finally:  # who interrupts wants no more of them begun
        pool.shutdown(cancel_futures=True)

# SPDX-License-Identifier: BSD-3-Clause
"""How long the solver stands still for those who want to see what it has."""

from __future__ import annotations

import os
from typing import Iterator

from .live import told
from .metrics import Metric, Size


def captures(size: Size) -> Iterator[Metric]:
    for threads in sorted({1, len(os.sched_getaffinity(0))}):
        times = told("capture", threads, size.captures)
        note = f"{times['bytes'] / 2**20:.0f} MiB, {times['capture_ms']:.3g} ms; {threads} threads, the first {times['first_ms']:.3g} ms"
        yield Metric("capture of the state, as many times a memcpy of it by one thread", times["ratio"], high=1.2, note=note)

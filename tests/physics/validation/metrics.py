# SPDX-License-Identifier: BSD-3-Clause
"""Metrics, their verdicts, and the table that they are written to."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from validation.runs import ROOT, replace

HEAD = "| case | metric | value | reference | tolerance | verdict | commit |"


@dataclass
class Metric:
    """One line of the table. The verdict is whether |value - reference| <= tolerance, or value within [low, high]; without
    either it is there to be seen."""

    case: str
    name: str
    value: float
    reference: float | None = None
    tolerance: float | None = None
    relative: bool = False
    low: float = -np.inf
    high: float = np.inf
    note: str = ""  # why it is not scored

    @property
    def scored(self) -> bool:
        return not self.note and (self.reference is not None or not (np.isinf(self.low) and np.isinf(self.high)))

    @property
    def passed(self) -> bool:
        if not self.scored:
            return True
        if self.reference is None:
            return bool(self.low <= self.value <= self.high)
        scale = abs(self.reference) if self.relative else 1
        return bool(abs(self.value - self.reference) <= self.tolerance * scale)

    def columns(self) -> list[str]:
        name = f"{self.name} ({self.note})" if self.note else self.name
        if not self.scored:
            reference = "-" if self.reference is None else f"{self.reference:.4g}"
            return [self.case, name, f"{self.value:.4g}", reference, "-", "-"]
        if self.reference is None:
            bounds = f"<= {self.high:.4g}" if np.isinf(self.low) else f">= {self.low:.4g}"
            if not np.isinf(self.low) and not np.isinf(self.high):
                bounds = f"{self.low:.4g} to {self.high:.4g}"
            return [self.case, name, f"{self.value:.4g}", "-", bounds, self.verdict]
        scale = f"{100 * self.tolerance:.3g} %" if self.relative else f"{self.tolerance:.3g}"
        return [self.case, name, f"{self.value:.4g}", f"{self.reference:.4g}", f"+-{scale}", self.verdict]

    @property
    def verdict(self) -> str:
        return "PASS" if self.passed else "MISS"


DECIDING = ("include", "proto", "server", "tests/physics/validate.py", "tests/physics/validation", "tests/reference")


def commit() -> str:
    """With a + where what decides a result is not as it was committed."""

    def git(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False)

    name = git("rev-parse", "--short", "HEAD").stdout.strip()
    changed = git("diff", "--quiet", "HEAD", "--", *DECIDING).returncode != 0
    return f"{name}{'+' if changed else ''}" if name else "unknown"


def duration(seconds: float) -> str:
    hours = seconds / 3600
    return f"{seconds:.0f} s" if seconds < 100 else f"{hours:.2g} h" if hours < 10 else f"{hours:.0f} h"


@dataclass
class Report:
    """The table, on the screen and as Markdown. Cases that are not run now keep the rows they had, with their commit."""

    paper: bool
    directory: Path
    takes: Mapping[str, float]  # the cases in their order, and what their runs take on one processor [s]
    metrics: list[Metric] = field(default_factory=list)
    commit: str = field(default_factory=commit)  # as it was when this began

    @property
    def path(self) -> Path:
        return self.directory / ("RESULTS-paper.md" if self.paper else "RESULTS.md")

    def add(self, metric: Metric) -> None:
        self.metrics.append(metric)
        print("\t".join(metric.columns()), flush=True)

    def rows(self) -> list[str]:
        fresh = {m.case for m in self.metrics}
        old = [line for line in self.path.read_text().splitlines() if line.startswith("| ")] if self.path.exists() else []
        kept = [line for line in old if line != HEAD and line.split(" | ")[0][2:] not in fresh]
        rows = kept + ["| " + " | ".join([*m.columns(), self.commit]) + " |" for m in self.metrics]
        order = list(self.takes)
        return sorted(rows, key=lambda row: order.index(row.split(" | ")[0][2:]))

    def missing(self, rows: list[str]) -> list[str]:
        """A sentence on the cases that no row is of."""
        there = {row.split(" | ")[0][2:] for row in rows}
        away = [f"{case} ({duration(seconds)})" for case, seconds in self.takes.items() if case not in there and seconds > 0]
        return ["", f"Not run at this size, with what they would take on one processor: {', '.join(away)}."] if away else []

    def write(self) -> None:
        command = "make validate SIZE=paper" if self.paper else "make validate"
        lines = ["# Validation" + (" at the papers' sizes" if self.paper else ""), "", f"Written by `{command}`.", "", HEAD]
        rows = self.rows()
        replace(self.path, "\n".join([*lines, "|---" * 7 + "|", *rows, *self.missing(rows)]) + "\n")

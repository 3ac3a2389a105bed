# SPDX-License-Identifier: BSD-3-Clause
"""What a row measures, its verdict, and the table."""

from __future__ import annotations

import json
import math
import os
import platform
import subprocess
import sys
import time
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Iterator

from daemon import BUILD, ROOT

HEAD = "| what | metric | target | measured | verdict | commit |"
HERE = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Metric:
    """One line of the table: PASS if low <= value <= high; without either it is there to be seen."""

    name: str
    value: float
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    note: str = ""

    @property
    def scored(self) -> bool:
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def verdict(self) -> str:
        if not self.scored:
            return "-"
        return "PASS" if self.low <= self.value <= self.high else "MISS"  # also what is no number

    @property
    def target(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        if not self.scored:
            return "-"
        if self.low == self.high:
            return f"{self.low:.12g}{unit}"
        bounds = [f">= {self.low:.12g}{unit}"] if math.isfinite(self.low) else []
        return ", ".join(bounds + ([f"<= {self.high:.12g}{unit}"] if math.isfinite(self.high) else []))

    @property
    def measured(self) -> str:
        exact = isinstance(self.value, int)
        return (f"{self.value}" if exact else f"{self.value:.4g}") + (f" {self.unit}" if self.unit else "")

    def columns(self, row: str) -> list[str]:
        return [row, f"{self.name} ({self.note})" if self.note else self.name, self.target, self.measured, self.verdict]


def none_of(name: str, count: int, note: str = "") -> Metric:
    """Something that must not happen."""
    return Metric(name, count, low=0, high=0, note=note)


def all_of(name: str, count: int, tried: int, note: str = "") -> Metric:
    """Something that must always happen."""
    return Metric(name, count, low=tried, high=tried, note=note)


@dataclass(frozen=True)
class Size:
    """How much of everything; `--set NAME=VALUE` changes one."""

    seconds: float = 5.0  # of each measurement of times
    turns: int = 10  # of a solver alone and with company,
    window: float = 2.0  # so long each
    resolution: float = 60.0  # of the dam break that computes meanwhile: 43,000 particles
    pauses: int = 100
    queued: int = 1000  # commands, at each pause
    runs_until: int = 200
    subscribers: int = 1000  # that listen, and as many that are stopped
    kills: int = 20
    replays: int = 3  # kills of each run that is gone on with and replayed
    samples: int = 20_000  # of a lossless stream
    client_kills: int = 10
    daemon_kills: int = 2
    fuzz_inputs: int = 500_000  # of all targets together, again and again
    inputs: int = 500_000  # until there were so many
    frames: int = 200_000  # in front of the handlers
    parameters: int = 20_000  # random sets
    sequences: int = 500  # of commands, compared with the model
    writers: int = 64
    captures: int = 30


SIZES = {
    "small": Size(),
    "full": Size(
        seconds=60, turns=100, pauses=10_000, runs_until=10_000, kills=200, replays=20, fuzz_inputs=2_000_000, inputs=100_000_000,
        frames=10_000_000, samples=10_000_000, client_kills=100, daemon_kills=10, parameters=1_000_000, sequences=100_000, captures=500,
    ),
}


def resized(size: Size, settings: list[str]) -> Size:
    """With NAME=VALUE; a SystemExit says what is wrong."""
    kinds = {f.name: type(f.default) for f in fields(Size)}
    for setting in settings:
        name, _, value = setting.partition("=")
        if name not in kinds:
            raise SystemExit(f"torture.py: there is no size {name}; there are {', '.join(kinds)}")
        try:
            number = kinds[name](value)
        except ValueError:
            number = kinds[name](0)
        if number <= 0:
            raise SystemExit(f"torture.py: {name}={value}: a number above 0")
        size = replace(size, **{name: number})
    return size


def commit() -> str:
    command = ["git", "-C", str(ROOT), "describe", "--always", "--exclude=*", "--dirty=+"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


def machine() -> str:
    """What the figures depend on."""
    names = [line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in line]
    return f"{len(os.sched_getaffinity(0))} x {names[0] if names else platform.machine()}, Linux {platform.release()}"


@dataclass
class Report:
    """The table, on the screen, as JSON and as Markdown. Rows that are not run now keep the lines they had, with their commit."""

    order: list[str]  # of the rows
    size: str
    lines: list[tuple[str, Metric]] = field(default_factory=list)
    load: float = field(default_factory=lambda: os.getloadavg()[0])

    def add(self, row: str, metric: Metric) -> None:
        self.lines.append((row, metric))
        print("\t".join(metric.columns(row)), flush=True)

    @property
    def passed(self) -> bool:
        return all(metric.verdict != "MISS" for _, metric in self.lines)

    def table(self, path: Path) -> Iterator[str]:
        fresh = {row for row, _ in self.lines}
        old = [line for line in path.read_text().splitlines() if line.startswith("| ")] if path.exists() else []
        rows = [line for line in old if line != HEAD and line.split(" | ")[0][2:] not in fresh | {"what"}]
        rows += ["| " + " | ".join([*metric.columns(row), commit()]) + " |" for row, metric in self.lines]
        names = {row: k for k, row in enumerate(self.order)}
        return iter(sorted(rows, key=lambda line: names.get(line.split(" | ")[0][2:], len(names))))

    def write(self) -> Path:
        """As Markdown beside the sources, as JSON in the build."""
        path = HERE / ("RESULTS.md" if self.size == "small" else f"RESULTS-{self.size}.md")
        full = "; of what is counted, as many as they name" if self.size == "full" else \
            ". Of what is counted, as pauses and kills, there are fewer than they name, so that all takes minutes; RESULTS-full.md has rows with as many"
        words = ["# Torture", "", f"Written by `make torture{'' if self.size == 'small' else ' SIZE=' + self.size}`; the targets are the control plane's promises{full}.",
                 f"Last on {machine()}, {time.strftime('%Y-%m-%d')}; {self.load:.1f} processes wanted a processor when it began.", "", HEAD]
        path.write_text("\n".join([*words, "|---" * 6 + "|", *self.table(path)]) + "\n")
        told = [{"row": row, **asdict(metric), "verdict": metric.verdict} for row, metric in self.lines]
        plain: Any = {"machine": machine(), "commit": commit(), "size": self.size, "load": self.load, "metrics": told}
        (BUILD / "torture.json").write_text(json.dumps(_finite(plain), indent=1) + "\n")
        return path


def _finite(value: Any) -> Any:
    """JSON has no infinities: null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def remark(text: str) -> None:
    print(f"# {text}", file=sys.stderr, flush=True)

# SPDX-License-Identifier: BSD-3-Clause
"""Runs of cases: made by the batch program, or found in the build directory if this very run is there."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from validation import jobs

ROOT = Path(__file__).resolve().parents[3]
BUILD = Path(os.environ.get("BUILD", ROOT / "build")).resolve()
DIVERGED = 70  # MNS_EXIT_DIVERGED of <meniscus/exit.h>


@dataclass
class Snapshot:
    """Fluid particles at one time."""

    t: float
    spacing: float
    x: np.ndarray  # [n, 3]
    phase: np.ndarray  # [n], in the order of the case's fluids
    pressure: np.ndarray | None  # [n]
    density: np.ndarray | None = None  # [n]
    velocity: np.ndarray | None = None  # [n, 3]
    acceleration: np.ndarray | None = None  # [n, 3]
    volume: np.ndarray | None = None  # [n]


@dataclass
class Run:
    """A finished run: its summary and its probe series."""

    directory: Path
    summary: dict
    t: np.ndarray
    probes: dict[str, np.ndarray]

    def at(self, name: str, t: float) -> float:
        return float(np.interp(t, self.t, self.probes[name]))

    def mean(self, name: str, first: float, last: float) -> float:
        inside = (self.t >= first) & (self.t <= last)
        return float(np.nanmean(self.probes[name][inside]))

    def slope(self, name: str, first: float, last: float) -> float:
        """Of the straight line through the series between two times."""
        return slope(self.t, self.probes[name], first, last)

    def snapshots(self, fluids: int = 2) -> list[Snapshot]:
        """All that were written, in the order of time."""
        return [read_snapshot(path, fluids) for path in sorted(self.directory.glob("snapshot-*.hdf"))]

    def last(self, fluids: int = 2) -> Snapshot:
        return read_snapshot(sorted(self.directory.glob("snapshot-*.hdf"))[-1], fluids)


def slope(t: np.ndarray, value: np.ndarray, first: float, last: float) -> float:
    inside = (t >= first) & (t <= last) & np.isfinite(value)
    return float(np.polyfit(t[inside], value[inside], 1)[0])


def read_snapshot(path: Path, fluids: int) -> Snapshot:
    with h5py.File(path) as file:
        phase = file["VTKHDF/PointData/phase"][:]
        fluid = phase < fluids
        attributes = file["meniscus"].attrs
        data = file["VTKHDF/PointData"]
        names = ("pressure", "density", "velocity", "acceleration", "volume")
        fields = {name: data[name][:][fluid] for name in names if name in data}
        return Snapshot(
            float(np.ravel(attributes["time"])[0]), float(np.ravel(attributes["spacing"])[0]),
            file["VTKHDF/Points"][:][fluid], phase[fluid], **({"pressure": None} | fields))


def replace(path: Path, text: str) -> None:
    """Write a file, or leave it as it was."""
    fresh = path.with_name(f".{path.name}.fresh")
    fresh.write_text(text, encoding="utf-8")
    fresh.replace(path)


@functools.cache
def program() -> bytes:
    """Of what the solver's program is linked from, but for the one object that has the name of the commit in it."""
    digest = hashlib.sha256()
    for part in ("server", "proto", "gen"):
        for path in sorted((BUILD / "obj" / part).glob("**/*.o")):
            if path.name != "describe.o":
                digest.update(path.read_bytes())
    return digest.digest()


def fingerprint(case: str, settings: list[str]) -> str:
    """Of what decides a run: the solver's program, the case and its settings."""
    digest = hashlib.sha256(program())
    digest.update((ROOT / f"server/cases/{case}.yaml").read_bytes())
    digest.update("\n".join(settings).encode())
    return digest.hexdigest()


def load(directory: Path, summary: dict) -> Run:
    with h5py.File(directory / "probes.hdf") as file:
        probes = {name: series[:] for name, series in file["probes"].items()}
        return Run(directory, summary, file["time"][:], probes)


def place(case: str, settings: list[str]) -> Path:
    """A directory that says what is in it."""
    label = "-".join([case] + [re.sub(r"[^A-Za-z0-9._-]+", "", s) for s in settings])
    if len(label) > 120:
        label = label[:100] + "-" + hashlib.sha256(label.encode()).hexdigest()[:12]
    return BUILD / "validate" / label


def call(command: list[str], log: Path) -> tuple[int, str]:
    """Exit code and summary of the batch program. The summary has the processor time as well, cpu_s: other programs
    lengthen it less than the time on the wall."""
    environment = os.environ | {"MENISCUS_CASES": str(ROOT / "server/cases")}  # wherever BUILD is
    with open(log, "w", encoding="utf-8") as errors, \
            jobs.program(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment) as process:
        summary = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if summary:
        summary = json.dumps(json.loads(summary) | {"exit_code": process.returncode, "cpu_s": usage.ru_utime + usage.ru_stime})
    return process.returncode, summary


class Spent(threading.local):
    """Processor time of the runs that this thread has asked for [s], by their cases with their settings. A case is scored by one thread."""

    def __init__(self) -> None:
        self.runs: dict[tuple[str, ...], float] = {}
        self.own = 0.0  # of cases of our own making


SPENT = Spent()


def run_file(path: Path, name: str) -> Run:
    """A case that a script wrote to this file. No state of it is recorded, whether it ends well or not: the file goes with the build directory."""
    try:
        return made(BUILD / "validate" / name, hashlib.sha256(program() + path.read_bytes()).hexdigest(), str(path))
    finally:
        SPENT.own += SPENT.runs.pop((str(path),), 0.0)


def run(case: str, *settings: str) -> Run:
    """Run a case to its end, or load it if this very run is there. What it says on the way is in a file beside its directory."""
    return made(place(case, list(settings)), fingerprint(case, list(settings)), case, *settings)


def made(directory: Path, mark: str, case: str, *settings: str) -> Run:
    """In this directory, if what decides it has this mark. A run that diverges does so again, so it is not made twice either."""
    stamp, told_in = directory / "fingerprint", directory / "summary.json"
    command = [str(BUILD / "meniscus"), "run", case, "--out", str(directory), "-o", "json"]
    for setting in settings:
        command += ["--set", setting]
    if not (stamp.exists() and stamp.read_text() == mark):
        sys.stderr.write(f"# {' '.join(command[1:])}\n")
        subprocess.run(["rm", "-rf", str(directory)], check=True)
        directory.parent.mkdir(parents=True, exist_ok=True)
        code, text = call(command, Path(f"{directory}.log"))
        SPENT.runs[case, *settings] = json.loads(text)["cpu_s"] if text else 0.0
        if not text or code not in (0, DIVERGED):
            raise subprocess.CalledProcessError(code, command, text)
        told_in.write_text(text)
        stamp.write_text(mark)
    summary = json.loads(text := told_in.read_text())
    SPENT.runs[case, *settings] = summary["cpu_s"]
    if summary.get("exit_code"):
        raise subprocess.CalledProcessError(summary["exit_code"], command, text)
    return load(directory, summary)


def told(error: subprocess.CalledProcessError) -> dict:
    """The summary of a run that did not come to its end; of one that was killed there is none."""
    return json.loads(error.output) if error.output else {"error": {"message": "it left no word"}}


def attempt(case: str, *settings: str) -> Run | None:
    """A run of which it is known that it may diverge."""
    try:
        return run(case, *settings)
    except subprocess.CalledProcessError as error:
        if error.returncode != DIVERGED:
            raise
        return None

# SPDX-License-Identifier: BSD-3-Clause
"""Series in time, of runs and of references, and what is read off them."""

from __future__ import annotations

import csv

import numpy as np
from validation.runs import ROOT

REFERENCE = ROOT / "tests/reference"


def table(name: str) -> dict[str, np.ndarray]:
    """Columns of a reference file."""
    with open(REFERENCE / name, encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    return {key: np.array([float(row[k]) for row in rows[1:]]) for k, key in enumerate(rows[0])}


def row(name: str, key: str, **where: str) -> dict[str, str]:
    """One line of a reference file, by what its first column begins with and what others are."""
    with open(REFERENCE / name, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return next(r for r in rows if next(iter(r.values())).startswith(key) and where.items() <= r.items())


def at(ref: dict[str, np.ndarray], column: str, t: float, time: str = "t") -> float:
    return float(np.interp(t, ref[time], ref[column]))


def smooth(t: np.ndarray, value: np.ndarray, width: float) -> np.ndarray:
    """Moving mean over a window of this width; the samples are evenly spaced. At the ends it is over what there is."""
    n = max(1, round(width / (t[1] - t[0])))
    ones = np.ones(n)
    return np.convolve(np.nan_to_num(value), ones, mode="same") / np.convolve(np.ones(len(t)), ones, mode="same")


def median(t: np.ndarray, value: np.ndarray, when: float, reach: float) -> float:
    """Of what was sampled within this reach of a time."""
    return float(np.nanmedian(value[np.abs(t - when) <= reach]))


def crossings(t: np.ndarray, value: np.ndarray, level: float) -> np.ndarray:
    """Times at which the value passes the level, either way, by linear interpolation."""
    above = value > level
    k = np.flatnonzero(above[1:] != above[:-1])
    return t[k] + (level - value[k]) / (value[k + 1] - value[k]) * (t[k + 1] - t[k])


def extremum(t: np.ndarray, value: np.ndarray, when: float, reach: float, sign: int) -> tuple[float, float]:
    """Time and value of the crest (sign 1) or trough (-1) about a time: the top of a parabola through the largest three."""
    inside = np.flatnonzero((np.abs(t - when) <= reach) & np.isfinite(value))
    k = inside[np.argmax(sign * value[inside])]
    if k in (0, len(t) - 1) or not np.isfinite(value[[k - 1, k + 1]]).all():
        return float(t[k]), float(value[k])
    a, b, c = value[k - 1], value[k], value[k + 1]
    curvature = a - 2 * b + c
    shift = 0.5 * (a - c) / curvature if curvature else 0.0
    return float(t[k] + shift * (t[k + 1] - t[k])), float(b - 0.25 * (a - c) * shift)


def peaks(t: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of all local maxima."""
    k = np.flatnonzero((value[1:-1] > value[:-2]) & (value[1:-1] >= value[2:])) + 1
    return t[k], value[k]

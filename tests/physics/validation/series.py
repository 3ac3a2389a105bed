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


def extremum(t: np.ndarray, value: np.ndarray, when: float, reach: float, sign: int, width: float = 0.1) -> tuple[float, float]:
    """Time and value of the crest (sign 1) or trough (-1) about a time: the top of the parabola nearest to all that is within this
    width of the largest sample, so that noise on a flat crest does not move it."""
    inside = np.flatnonzero((np.abs(t - when) <= reach) & np.isfinite(value))
    k = inside[np.argmax(sign * value[inside])]
    near = (np.abs(t - t[k]) <= width + 1e-9) & np.isfinite(value)
    a, b, c = np.polyfit(t[near] - t[k], value[near], 2) if np.count_nonzero(near) > 2 else (0.0, 0.0, 0.0)
    top = -b / (2 * a) if sign * a < 0 else np.inf
    if abs(top) > width:  # it is no crest, but the end of a slope
        return float(t[k]), float(value[k])
    return float(t[k] + top), float(c - b * b / (4 * a))


def peaks(t: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of all local maxima."""
    k = np.flatnonzero((value[1:-1] > value[:-2]) & (value[1:-1] >= value[2:])) + 1
    return t[k], value[k]

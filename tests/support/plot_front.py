#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw the water front of a dam break, as its probe recorded it, against theory and a finite-volume computation."""

import argparse
import csv
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

REFERENCE = Path(__file__).resolve().parents[1] / "reference/P3/dam_break_vof_W2H_H95.csv"


def front_of_run(series: Path, probe: str, dam: float, depth: float, gravity: float) -> tuple[np.ndarray, np.ndarray]:
    """Dimensionless time and distance from the dam."""
    with h5py.File(series) as file:
        t = file["time"][:] * np.sqrt(gravity / depth)
        x = (file["probes"][probe][:] - dam) / depth
    return t, x


def toe_of_reference(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The same from the table; once the water has hit the wall the toe means nothing."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    t, toe = (np.array([float(row[name]) for row in rows]) for name in ("t", "toe_from_dam"))
    before_wall = np.maximum.accumulate(toe) < 3.35
    return t[before_wall], toe[before_wall]


def draw(t: np.ndarray, x: np.ndarray, label: str, wall: float, out: Path) -> None:
    plt.rcParams.update({
        "font.family": "serif", "mathtext.fontset": "cm", "font.size": 10, "axes.linewidth": 0.8,
        "xtick.direction": "in", "ytick.direction": "in", "xtick.top": True, "ytick.right": True,
    })
    figure, axes = plt.subplots(figsize=(4.5, 3.4), constrained_layout=True)
    arrival = np.argmax(x >= wall - 0.05) if np.any(x >= wall - 0.05) else len(x)
    t_end = max(1.0, 1.12 * t[min(arrival, len(t) - 1)])

    ritter = np.array([0.0, wall / 2])
    axes.plot(ritter, 2 * ritter, color="0.45", lw=1, ls=(0, (5, 3)), label="Ritter (1892), $2\\,t\\sqrt{g/H}$")
    axes.plot(*toe_of_reference(REFERENCE), color="0.0", lw=1.2, label="volume of fluid, $H/\\Delta x = 95$")
    axes.plot(t[:arrival], x[:arrival], color="#1f78b4", lw=0, marker="o", ms=3.2, mfc="none", mew=0.9,
              markevery=max(1, arrival // 35), label=label)
    axes.axhline(wall, color="0.6", lw=0.8)
    axes.annotate("far wall", (0.02 * t_end, wall), (0, 3), textcoords="offset points", fontsize=8, color="0.4")
    axes.set(xlim=(0, t_end), ylim=(0, 1.1 * wall), xlabel="$t\\,\\sqrt{g/H}$",
             ylabel="front $(x - x_\\mathrm{dam})/H$")
    axes.legend(frameon=False, loc="lower right", fontsize=9)
    figure.savefig(out, dpi=200)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("series", type=Path, help="probes.hdf of the run")
    parser.add_argument("out", type=Path, help="picture to write")
    parser.add_argument("--probe", default="front", help="name of the front probe (%(default)s)")
    parser.add_argument("--dam", type=float, default=2.0, help="where the dam stood [m] (%(default)s)")
    parser.add_argument("--depth", type=float, default=1.0, help="depth H of the water [m] (%(default)s)")
    parser.add_argument("--gravity", type=float, default=1.0, help="[m/s^2] (%(default)s)")
    parser.add_argument("--wall", type=float, default=3.366, help="from dam to far wall, over H (%(default)s)")
    parser.add_argument("--label", default="Meniscus", help="name of the run in the legend (%(default)s)")
    options = parser.parse_args()
    t, x = front_of_run(options.series, options.probe, options.dam, options.depth, options.gravity)
    draw(t, x, options.label, options.wall, options.out)


if __name__ == "__main__":
    main()

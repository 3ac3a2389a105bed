#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plots of a run's probes against their references, for papers.

    plots.py dambreak2d|dambreak3d|sloshing2d PROBES.hdf DIRECTORY

writes front, pressure and heights, of the tank pressure alone, into the directory as PDF or PNG. Other programs call
the functions: each draws one comparison into axes of theirs.

Dam breaks are shown in units of depth H, gravity g and density rho of the water. The band around a reference is the
difference between its two grids: what it does not know itself.

Needs python3-matplotlib.
"""

from __future__ import annotations

import argparse
import csv
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

REFERENCE = Path(__file__).resolve().parents[1] / "reference/P3"
FINE, COARSE = "dam_break_vof_W2H_H95.csv", "dam_break_vof_W2H_H48.csv"
FINE_LABEL = r"volume of fluid, $H/\Delta x = 95$"
RUN = {"color": "#1f78b4", "lw": 1.3}
REFERENCE_LINE = {"color": "black", "lw": 1.0, "ls": (0, (5, 2))}
THEORY_LINE = {"color": "0.5", "lw": 0.9, "ls": (0, (1, 1.5))}

Table = dict[str, np.ndarray]


@dataclass
class Units:
    """What a run of a dam break is measured in."""

    depth: float = 1.0
    gravity: float = 1.0
    density: float = 1.0

    @property
    def time(self) -> float:
        return float(np.sqrt(self.depth / self.gravity))

    @property
    def pressure(self) -> float:
        return self.density * self.gravity * self.depth


def read_probes(path: Path) -> Table:
    """All series of a probes.hdf by name, with "time"."""
    with h5py.File(path) as file:
        return {"time": file["time"][:], **{name: series[:] for name, series in file["probes"].items()}}


def read_table(name: str) -> Table:
    """Columns of a reference by name."""
    with open(REFERENCE / name, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {key: np.array([float(row[key] or "nan") for row in rows]) for key in rows[0]}


def style() -> None:
    plt.rcParams.update({
        "font.family": "serif", "mathtext.fontset": "cm", "font.size": 9, "axes.linewidth": 0.7,
        "xtick.direction": "in", "ytick.direction": "in", "xtick.top": True, "ytick.right": True,
        "legend.frameon": False, "legend.fontsize": 8, "savefig.dpi": 300,
    })


def draw_reference(axes: plt.Axes, column: str) -> None:
    """A column of the dam break of the finer grid, with a band as wide as its distance from the coarser one."""
    fine, coarse = read_table(FINE), read_table(COARSE)
    other = np.interp(fine["t"], coarse["t"], coarse[column])
    axes.fill_between(fine["t"], np.fmin(fine[column], other), np.fmax(fine[column], other), color="0.85", lw=0)
    axes.plot(fine["t"], fine[column], label=FINE_LABEL, **REFERENCE_LINE)


def draw_front(axes: plt.Axes, probes: Table, units: Units, dam: float, wall: float, label: str) -> None:
    """Distance of the front from the dam until it meets the wall. dam, wall: places [m]."""
    distance = (wall - dam) / units.depth
    fine, ritter = read_table(FINE), read_table("ritter_front.csv")
    before = np.maximum.accumulate(fine["toe_from_dam"]) < distance - 0.02
    axes.plot(ritter["t_star"], ritter["front_over_H"], label="Ritter (1892)", **THEORY_LINE)
    axes.plot(fine["t"][before], fine["toe_from_dam"][before], label=FINE_LABEL, **REFERENCE_LINE)
    x = (probes["front"] - dam) / units.depth
    before = np.maximum.accumulate(np.nan_to_num(x)) < distance - 0.02
    axes.plot(probes["time"][before] / units.time, x[before], label=label, **RUN)
    axes.set(xlabel=r"$t\sqrt{g/H}$", ylabel=r"$(x_\mathrm{front} - x_\mathrm{dam})/H$", ylim=(0, 1.05 * distance),
             xlim=(0, 1.1 * max(fine["t"][fine["toe_from_dam"] < distance - 0.02].max(), 1)))


def draw_pressure(axes: plt.Axes, probes: Table, units: Units, probe: str, column: str, label: str) -> None:
    draw_reference(axes, column)
    axes.plot(probes["time"] / units.time, probes[probe] / units.pressure, label=label, **RUN)
    axes.set(xlabel=r"$t\sqrt{g/H}$", ylabel=r"$p/(\rho g H)$")
    focus(axes, probes["time"] / units.time)


def draw_height(axes: plt.Axes, probes: Table, units: Units, probe: str, label: str) -> None:
    draw_reference(axes, probe)
    axes.plot(probes["time"] / units.time, probes[probe] / units.depth, label=label, **RUN)
    axes.set(xlabel=r"$t\sqrt{g/H}$", ylabel=rf"${probe[0]}_{{{probe[1:]}}}/H$")
    focus(axes, probes["time"] / units.time)


def draw_sloshing(axes: plt.Axes, probes: Table, probe: str, column: str, label: str, quantity: str,
                  offset: float = 0) -> None:
    """A series of the tank in seconds. offset: added to the reference, such as the depth at rest to an elevation."""
    reference = read_table("sloshing_vof2d.csv")
    axes.plot(reference["t_s"], reference[column] + offset, label=r"volume of fluid, $h/\Delta x = 29$",
              **REFERENCE_LINE)
    axes.plot(probes["time"], probes[probe], label=label, **RUN)
    axes.set(xlabel="$t$ (s)", ylabel=quantity)
    focus(axes, probes["time"])


def focus(axes: plt.Axes, time: np.ndarray) -> None:
    """Show the time of the run, and the values of that time: references may be longer."""
    if not len(time) or time[-1] <= 0:
        return
    seen = [y[(x <= time[-1]) & np.isfinite(y)] for x, y in (line.get_data() for line in axes.get_lines())]
    low, high = min(y.min() for y in seen if len(y)), max(y.max() for y in seen if len(y))
    margin = 0.06 * (high - low) or 1.0
    axes.set(xlim=(0, time[-1]), ylim=(low - margin, high + margin))


def save(figure: plt.Figure, path: Path) -> Path:
    figure.axes[0].legend()
    figure.savefig(path)
    plt.close(figure)
    return path


def panels(n: int) -> tuple[plt.Figure, list[plt.Axes]]:
    style()
    figure, axes = plt.subplots(n, 1, figsize=(4.6, 1.0 + 2.1 * n), constrained_layout=True, squeeze=False)
    return figure, list(axes[:, 0])


def plot_dam_break(probes: Table, out: Path, label: str, kind: str = "pdf", units: Units | None = None) -> list[Path]:
    """The three figures of a dam break of the paper's geometry: water 2 H wide in a tank of 5.366 H."""
    units = units or Units()
    figure, axes = panels(1)
    draw_front(axes[0], probes, units, 2 * units.depth, 5.366 * units.depth, label)
    paths = [save(figure, out / f"front.{kind}")]
    for name, wanted, draw in (
        ("pressure", {"P19": "p_0.19", "P267": "p_0.267"},
         lambda a, k, c: draw_pressure(a, probes, units, k, c, label)),
        ("heights", {"h1": "h1", "h2": "h2"}, lambda a, k, _: draw_height(a, probes, units, k, label)),
    ):
        found = {probe: column for probe, column in wanted.items() if probe in probes}
        if not found:
            continue
        figure, axes = panels(len(found))
        for panel, (probe, column) in zip(axes, found.items()):
            draw(panel, probe, column)
            panel.set_title(probe, loc="left", fontsize=9)
        paths.append(save(figure, out / f"{name}.{kind}"))
    return paths


def plot_sloshing(probes: Table, out: Path, label: str, kind: str = "pdf") -> list[Path]:
    """Pressures at the paper's sensors, as far as the run has them under the names of the reference."""
    found = [name for name in ("P1", "P2", "P3") if name in probes]
    if not found:
        raise SystemExit(f"The run has none of the probes P1, P2, P3; it has: {', '.join(sorted(probes))}.")
    figure, axes = panels(len(found))
    for panel, probe in zip(axes, found):
        draw_sloshing(panel, probes, probe, probe, label, "$p$ (Pa)")
        panel.set_title(probe, loc="left", fontsize=9)
    return [save(figure, out / f"pressure.{kind}")]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", choices=("dambreak2d", "dambreak3d", "sloshing2d"))
    parser.add_argument("probes", type=Path)
    parser.add_argument("directory", type=Path)
    parser.add_argument("--label", default="Meniscus")
    parser.add_argument("--format", choices=("pdf", "png"), default="pdf")
    args = parser.parse_args()
    probes = read_probes(args.probes)
    args.directory.mkdir(parents=True, exist_ok=True)
    plot = plot_sloshing if args.case == "sloshing2d" else plot_dam_break
    for path in plot(probes, args.directory, args.label, args.format):
        print(path)


if __name__ == "__main__":
    main()

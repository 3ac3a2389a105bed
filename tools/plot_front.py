#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draw the water front of a dam break, as its probe recorded it, against theory and a finite-volume computation."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cairo  # python3-cairo
import h5py
import numpy as np

REFERENCE = Path(__file__).resolve().parents[1] / "tests/reference/P3/dam_break_vof_W2H_H95.csv"
SIZE = WIDTH, HEIGHT = 900, 680  # of the picture [pixels]
LEFT, RIGHT, TOP, BOTTOM = 95, 875, 25, 600  # of the axes [pixels]
TEXT, SMALL = 22, 18  # [pixels]
TICK = 8  # [pixels]
BLACK, GREY, BLUE = (0, 0, 0), (0.45, 0.45, 0.45), (0.12, 0.47, 0.71)


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


@dataclass
class Axes:
    """Both from 0 to these."""

    context: cairo.Context
    x_end: float
    y_end: float

    def at(self, x: float, y: float) -> tuple[float, float]:
        return LEFT + x / self.x_end * (RIGHT - LEFT), BOTTOM - y / self.y_end * (BOTTOM - TOP)

    def line(self, x: np.ndarray, y: np.ndarray) -> None:
        for a, b in zip(x, y, strict=True):
            self.context.line_to(*self.at(a, b))
        self.context.stroke()

    def rings(self, x: np.ndarray, y: np.ndarray) -> None:
        for a, b in zip(x, y, strict=True):
            self.ring(*self.at(a, b))

    def ring(self, x: float, y: float) -> None:
        self.context.arc(x, y, 5, 0, 2 * np.pi)
        self.context.stroke()

    def text(self, x: float, y: float, words: str, along: float = 0, across: float = 0) -> None:
        """With this share of its width to the left of x, and of its height below y [pixels]."""
        box = self.context.text_extents(words)
        self.context.move_to(x - along * box.x_advance, y + across * -box.y_bearing)
        self.context.show_text(words)

    def ticks(self, step: float) -> None:
        c = self.context
        for k in range(1, int(self.x_end / step) + 1):
            x, _ = self.at(k * step, 0)
            for start, way in ((BOTTOM, -TICK), (TOP, TICK)):
                c.move_to(x, start)
                c.rel_line_to(0, way)
            c.stroke()
            self.text(x, BOTTOM + 12, f"{k * step:g}", 0.5, 1)
        for k in range(0, int(self.y_end / step) + 1):
            _, y = self.at(0, k * step)
            for start, way in ((LEFT, TICK), (RIGHT, -TICK)):
                c.move_to(start, y)
                c.rel_line_to(way, 0)
            c.stroke()
            self.text(LEFT - 12, y, f"{k * step:g}", 1, 0.5)


def drawing() -> tuple[cairo.ImageSurface, cairo.Context]:
    surface = cairo.ImageSurface(cairo.FORMAT_RGB24, WIDTH, HEIGHT)
    context = cairo.Context(surface)
    context.set_source_rgb(1, 1, 1)
    context.paint()
    context.select_font_face("serif")
    context.set_font_size(TEXT)
    return surface, context


def frame(axes: Axes, wall: float) -> None:
    c = axes.context
    c.set_source_rgb(*GREY)
    axes.line(np.array([0, axes.x_end]), np.array([wall, wall]))
    c.set_font_size(SMALL)
    x, y = axes.at(0.02 * axes.x_end, wall)
    axes.text(x, y - 6, "far wall")
    c.set_font_size(TEXT)
    c.set_source_rgb(*BLACK)
    c.rectangle(LEFT, TOP, RIGHT - LEFT, BOTTOM - TOP)
    c.stroke()
    axes.ticks(0.5)
    axes.text((LEFT + RIGHT) / 2, HEIGHT - 20, "t \N{SQUARE ROOT}(g/H)", 0.5)
    c.save()
    c.translate(28, (TOP + BOTTOM) / 2)
    c.rotate(-np.pi / 2)
    axes.text(0, 0, "distance of the front from the dam / H", 0.5)
    c.restore()


def draw(t: np.ndarray, x: np.ndarray, label: str, wall: float, out: Path) -> None:
    arrival = int(np.argmax(x >= wall - 0.05)) if np.any(x >= wall - 0.05) else len(x)
    t_end = max(1.0, 1.12 * t[min(arrival, len(t) - 1)])
    surface, c = drawing()
    axes = Axes(c, t_end, 1.1 * wall)
    c.set_line_width(1.5)
    frame(axes, wall)
    every = max(1, arrival // 35)
    c.set_line_width(2)
    entry = 0

    def curve(words: str, colour: tuple[float, ...], dashes: tuple[float, ...], put: Callable[[np.ndarray, np.ndarray], None], *at: np.ndarray) -> None:
        """Clipped to the axes, with its entry in the legend."""
        nonlocal entry
        left, y = 430, BOTTOM - 95 + 30 * entry
        entry += 1
        c.set_source_rgb(*colour)
        c.set_dash(dashes)
        c.save()
        c.rectangle(LEFT, TOP, RIGHT - LEFT, BOTTOM - TOP)
        c.clip()
        put(*at)
        c.restore()
        if put == axes.rings:
            axes.ring(left + 20, y)
        else:
            c.move_to(left, y)
            c.rel_line_to(40, 0)
            c.stroke()
        c.set_source_rgb(*BLACK)
        c.set_dash(())
        axes.text(left + 52, y, words, 0, 0.5)

    ritter = np.array([0.0, wall / 2])
    curve("Ritter (1892), 2 t \N{SQUARE ROOT}(g/H)", GREY, (10, 6), axes.line, ritter, 2 * ritter)
    curve("volume of fluid, H/\N{GREEK CAPITAL LETTER DELTA}x = 95", BLACK, (), axes.line, *toe_of_reference(REFERENCE))
    curve(label, BLUE, (), axes.rings, t[:arrival:every], x[:arrival:every])
    surface.write_to_png(str(out))


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

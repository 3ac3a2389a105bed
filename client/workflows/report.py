#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Lay the JSON objects of many runs side by side: a table as CSV or Markdown, a picture of a probe over a parameter.

    report.py [--csv FILE] [--markdown FILE] [--picture FILE] [--probe NAME]... RESULT.json...

What distinguishes the runs is in their paths: sweep/scheme~riemann/resolution~20.json has the parameters scheme and resolution.
The last parameter is the axis of the picture, of the first probe; each combination of the others is a line.
"""

import argparse
import csv
import json
import os
import sys
from pathlib import Path
from typing import Any

KEYS = ("state", "t", "steps", "particles", "wall_s", "state_hash")


def parameters(path: Path) -> "dict[str, str]":
    parts = [*path.parent.parts, path.stem]
    return dict(part.split("~", 1) for part in parts if "~" in part)


def order(value: str) -> "tuple[int, float, str]":
    """Numbers by size, before words."""
    try:
        return 0, float(value), value
    except ValueError:
        return 1, 0.0, value


def read(paths: "list[Path]", probes: "list[str]") -> "list[dict[str, Any]]":
    """A row for each run; without names of probes, those that all runs have."""
    results = [(parameters(path), json.loads(path.read_text(encoding="utf-8"))) for path in paths]
    names = probes or [n for n in results[0][1]["probes"] if all(n in told["probes"] for _, told in results)]
    rows = [{**given, **{key: told[key] for key in KEYS}, **{name: told["probes"].get(name, {}).get("value") for name in names}}
            for given, told in results]
    return sorted(rows, key=lambda row: [order(row[name]) for name in results[0][0]])


def text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def write(path: Path, words: str) -> None:
    part = path.with_name(path.name + ".part")
    part.write_text(words, encoding="utf-8")
    os.replace(part, path)


def write_csv(path: Path, rows: "list[dict[str, Any]]") -> None:
    """With all digits, as it is for programs."""
    part = path.with_name(path.name + ".part")
    with open(part, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    os.replace(part, path)


def markdown(rows: "list[dict[str, Any]]") -> str:
    lines = [list(rows[0]), ["---"] * len(rows[0]), *([text(value) for value in row.values()] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def draw(path: Path, rows: "list[dict[str, Any]]", given: "list[str]", probe: str) -> None:
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4), dpi=120)
    *others, along = given
    lines: "dict[str, list[tuple[float, float]]]" = {}
    for row in rows:
        if row[probe] is not None:
            lines.setdefault(", ".join(row[name] for name in others), []).append((float(row[along]), row[probe]))
    for label, points in lines.items():
        axes.plot(*zip(*points), marker="o", label=label)
    places = sorted({place for points in lines.values() for place, _ in points})
    values = [value for points in lines.values() for _, value in points]
    if len(places) <= 12:
        axes.set_xticks(places)  # that were run, not what lies between
    if values and min(values) > 0 and max(values) > 20 * min(values):
        axes.set_yscale("log")
    axes.set_xlabel(along)
    axes.set_ylabel(probe)
    if any(lines):
        axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path)


def main() -> int:
    parser = argparse.ArgumentParser(description="A table and a picture of the JSON objects of many runs.")
    parser.add_argument("--csv", type=Path, metavar="FILE")
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    parser.add_argument("--picture", type=Path, metavar="FILE")
    parser.add_argument("--probe", action="append", default=[], metavar="NAME", help="only these probes, in this order")
    parser.add_argument("results", nargs="+", type=Path, metavar="RESULT.json")
    o = parser.parse_args()
    rows = read(o.results, o.probe)
    given = list(parameters(o.results[0]))
    probes = [name for name in rows[0] if name not in given and name not in KEYS]
    if o.csv:
        write_csv(o.csv, rows)
    if o.markdown:
        write(o.markdown, markdown(rows))
    if o.picture and given and probes:
        draw(o.picture, rows, given, probes[0])
    elif o.picture:
        print("a picture takes a parameter, in the paths, and a probe", file=sys.stderr)
        return 2
    if not (o.csv or o.markdown or o.picture):
        print(markdown(rows), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())

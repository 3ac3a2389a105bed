#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Rows of RESULTS.md whose value or verdict is another than at a commit, with both: `since.py COMMIT` prints a table. What is not scored, what runs took, and
what is rounding in both is left out, and rows that are in only one of the two."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RESULTS = Path(__file__).with_name("RESULTS.md")
ROUNDING = 1e-10

Rows = dict[tuple[str, str], list[str]]  # by case and metric: value, reference, tolerance, verdict, commit


def rows(text: str) -> Rows:
    lines = (line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ") and " | " in line)
    return {(cells[0], cells[1]): cells[2:] for cells in lines if len(cells) == 7 and cells[0] != "case"}


def is_of_interest(before: list[str], now: list[str]) -> bool:
    if before[3] == now[3] == "-" or (before[0], before[3]) == (now[0], now[3]):
        return False
    return not (abs(float(before[0])) <= ROUNDING and abs(float(now[0])) <= ROUNDING)


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    command = ["git", "-C", str(RESULTS.parent), "show", f"{sys.argv[1]}:./{RESULTS.name}"]
    before, now = rows(subprocess.run(command, capture_output=True, text=True, check=True).stdout), rows(RESULTS.read_text(encoding="utf-8"))
    print("| case | metric | before | now | reference | tolerance | verdict |\n|---|---|---|---|---|---|---|")
    for key in now:
        if key in before and is_of_interest(before[key], now[key]):
            was, (value, reference, tolerance, verdict, _) = before[key], now[key]
            verdicts = verdict if was[3] == verdict else f"{was[3]} -> {verdict}"
            print(f"| {key[0]} | {key[1]} | {was[0]} | {value} | {reference} | {tolerance} | {verdicts} |")


if __name__ == "__main__":
    main()

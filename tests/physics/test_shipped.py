#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""All shipped cases that have steps come to the states that are recorded in shipped.txt, with one thread and with two.

    make all build/tests/physics/state_after && tests/physics/test_shipped.py --write

records them again, after a change that was meant to change them. Where 200 steps take more than 20 s, a quarter of the case's resolution is recorded, or the
next that fits its domain.

Run by: make nightly"""

from __future__ import annotations

import os
import subprocess
import sys
import unittest
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from validation.runs import BUILD, ROOT, replace  # noqa: E402

RECORD = Path(__file__).parent / "shipped.txt"
CASES = ROOT / "server/cases"
STEPS = 200
LONG = 20  # [s], of a machine that does nothing else
OPERATORS = "operators"  # what the names of cases without steps end in
COARSER = 4
REFUSED = 65  # the exit code of a case that is


def state(case: str, settings: Sequence[str], threads: int, limit: float | None = None) -> str:
    """The hash of the state after STEPS steps. Raises TimeoutExpired."""
    command = [str(BUILD / "tests/physics/state_after"), case, str(STEPS), *settings, f"threads={threads}"]
    environment = os.environ | {"MENISCUS_CASES": str(CASES), "OMP_WAIT_POLICY": "passive"}
    return subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True, timeout=limit).stdout.strip()


def shipped() -> list[str]:
    return sorted(path.stem for path in CASES.glob("*.yaml") if not path.stem.endswith(OPERATORS))


def resolution(case: str) -> int:
    line = next(line for line in (CASES / f"{case}.yaml").read_text(encoding="utf-8").splitlines() if line.startswith("resolution:"))
    return int(line.split()[1])


def found(case: str) -> str:
    try:
        return "\t".join((case, state(case, (), 1, LONG)))
    except subprocess.TimeoutExpired:
        pass
    for n in range(resolution(case) // COARSER, resolution(case)):
        try:
            return "\t".join((case, state(case, (f"resolution={n}",), 1), f"resolution={n}"))
        except subprocess.CalledProcessError as error:
            if error.returncode != REFUSED:
                raise
    raise ValueError(f"{case} is refused at every coarser resolution")


class Shipped(unittest.TestCase):
    def test_states_are_those_recorded(self) -> None:
        lines = [line.split("\t") for line in RECORD.read_text(encoding="utf-8").splitlines()]
        self.assertEqual([case for case, *_ in lines], shipped())
        for case, recorded, *settings in lines:
            for threads in (1, 2):
                with self.subTest(case=case, threads=threads):
                    self.assertEqual(state(case, settings, threads), recorded)


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        replace(RECORD, "".join(f"{found(case)}\n" for case in shipped()))
    else:
        unittest.main()

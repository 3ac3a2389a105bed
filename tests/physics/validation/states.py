# SPDX-License-Identifier: BSD-3-Clause
"""Which cases a change of the program has changed: each run's state after a few steps, by its hash, against the recorded one.

The record is states.txt beside the results: a line for each run of each case at reduced size, with the hash, the run's case and its settings.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from validation import jobs
from validation.runs import BUILD, ROOT

STEPS = 50
RECORD = Path(__file__).parents[1] / "states.txt"
NONE = "none"  # for a hash, of a case that is refused

Asked = tuple[str, ...]  # the run's case, and its settings
Of = dict[Asked, str]  # the hash of each run
Record = dict[str, Of]  # by the case that is scored


def state_after(asked: Asked) -> str:
    """The hash after STEPS steps."""
    command = [str(BUILD / "tests/physics/state_after"), asked[0], str(STEPS), *asked[1:]]
    environment = os.environ | {"MENISCUS_CASES": str(ROOT / "server/cases")}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    return done.stdout.strip() or NONE


def read(path: Path = RECORD) -> Record:
    record: Record = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        name, state, *asked = line.split("\t")
        record.setdefault(name, {})[tuple(asked)] = state
    return record


def note(fresh: Record, order: Sequence[str], path: Path = RECORD) -> None:
    """Take over what these cases have asked for now; the others keep their lines."""
    record = read(path) | fresh
    lines = ["\t".join((name, state, *asked)) for name in order for asked, state in record.get(name, {}).items()]
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def changed(names: Iterable[str], processes: int, record: Mapping[str, Of]) -> list[str]:
    """Those of the cases of which a run's state is another than recorded, or of which nothing is recorded."""
    known = {asked: state for name in names for asked, state in record.get(name, {}).items()}
    tasks = {asked: lambda asked=asked: state_after(asked) for asked in known}
    differs = {asked for asked, state in jobs.at_once(processes, tasks) if state != known[asked]}
    return [name for name in names if name not in record or differs & set(record[name])]

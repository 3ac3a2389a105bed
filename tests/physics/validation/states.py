# SPDX-License-Identifier: BSD-3-Clause
"""Which cases a change has changed: each run's state after a few steps, by its hash, and what scores them, by the hash of its source, against
the recorded ones.

The record is states.txt beside the results. A case has a line with the hash of what scores it, and one for each of its runs at reduced size, with
the hash, the run's case and its settings. A case that makes runs of its own, from files that it writes, has none, and is always run.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from validation import jobs, sources
from validation.runs import BUILD, ROOT, replace

STEPS = 50
RECORD = Path(__file__).parents[1] / "states.txt"
# Of server/sim: what a run measures besides its state. Other terms with a share of the power of walls push by it, too, and change states.
MEASURED = ("probes/*.[ch]", "sample.[ch]", "shown.[ch]", "energy.[ch]", "losses.c", "fluid_sum.[ch]", "terms/wall_power.[ch]")
NONE = "none"  # for a hash, of a case that is refused
REFUSED = 65  # the exit code then

Asked = tuple[str, ...]  # the run's case, and its settings
SCORING: Asked = ()  # in place of a run: what scores them
Of = dict[Asked, str]  # the hash of each
Record = dict[str, Of]  # by the case that is scored


def state_after(asked: Asked) -> str:
    """The hash after STEPS steps."""
    command = [str(BUILD / "tests/physics/state_after"), asked[0], str(STEPS), *asked[1:]]
    environment = os.environ | {"MENISCUS_CASES": str(ROOT / "server/cases")}
    with jobs.program(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment) as process:
        state = process.communicate()[0].strip()
    if process.returncode not in (0, REFUSED):
        raise subprocess.CalledProcessError(process.returncode, command)
    return state or NONE


def scoring(score: Callable, runs: Iterable[Asked]) -> str:
    """The hash of what scores these runs, of what measures them, and of their cases, which say what is measured and until when: all may change without
    a state."""
    sha = hashlib.sha256(sources.digest(score).encode())
    measuring = sorted(path for pattern in MEASURED for path in (ROOT / "server/sim").glob(pattern))
    for path in (*measuring, *(ROOT / f"server/cases/{case}.yaml" for case in sorted({asked[0] for asked in runs}))):
        sha.update(path.read_bytes())
    return sha.hexdigest()[:16]


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
    replace(path, "".join(f"{line}\n" for line in lines))


def changed(names: Iterable[str], processes: int, record: Mapping[str, Of], scores: Mapping[str, Callable]) -> list[str]:
    """Those of the cases of which a run's state, or what scores it, is not the recorded one, or of which nothing is recorded."""
    known = {asked: state for name in names for asked, state in record.get(name, {}).items() if asked != SCORING}
    tasks = {asked: lambda asked=asked: state_after(asked) for asked in known}
    differs = {asked for asked, state in jobs.at_once(processes, tasks) if state != known[asked]}

    def as_recorded(name: str) -> bool:
        runs = record.get(name, {}).keys() - {SCORING}
        return record.get(name, {}).get(SCORING) == scoring(scores[name], runs) and not differs & runs

    return [name for name in names if not as_recorded(name)]

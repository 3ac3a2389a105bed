#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Try whether the control plane keeps its promises, and print the table of them with what was measured beside.

usage: torture.py [ROW...] [--size small|full] [--set NAME=VALUE...] [--list]

One line per metric: row, metric, target, measured, PASS or MISS; the same as Markdown in tests/torture/RESULTS.md (RESULTS-full.md)
and as JSON in $BUILD/torture.json. Exit code 1 if anything was missed. Times mean something on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from rows import captures, company, contention, crashes, faults, latency, rubbish, streams  # noqa: E402
from rows.metrics import SIZES, Metric, Report, Size, remark, resized  # noqa: E402


@dataclass(frozen=True)
class Row:
    """A promise, what tries it, and after how long it is given up."""

    run: Callable[[Size], Iterator[Metric]]
    what: str
    limit_s: float = 120  # at the small size; the full one may take a hundred times as long


ROWS = {
    "status": Row(latency.status, "status round trip, all cores computing and idle"),
    "pause": Row(latency.pause, "pause at the first step boundary, with commands queued"),
    "run-until": Row(latency.run_until, "run_until to exactly the asked time, whatever else is commanded"),
    "subscribers": Row(company.few, "32 subscribers of probes and 4 of fields", 500),
    "many-subscribers": Row(company.many, "1000 subscribers, and 1000 that were stopped", 800),
    "lossless": Row(streams.lossless, "lossless stream over kills of clients and daemon: no gap, no duplicate", 240),
    "snapshot": Row(streams.snapshot, "snapshot to one loopback client, and its cancel"),
    "kills": Row(crashes.kills, "kill -9 at random moments", 240),
    "replay": Row(crashes.replays, "restart, and replay of the journal, bit for bit", 240),
    "capture": Row(captures.captures, "capture stall of the solver"),
    "frames": Row(rubbish.frames, "malformed frames under sanitizers", 240),
    "model": Row(rubbish.model, "random sequences of commands against the reference model", 600),
    "parameters": Row(rubbish.parameters, "fuzzed parameter sets", 240),
    "writers": Row(contention.writers, "64 contending writers with leases: never two at once"),
    "handshakes": Row(contention.handshakes, "10^4 half-open handshakes a second"),
    "faults": Row(faults.faults, "a diverged solver, no memory, a full disk: the daemon answers", 300),
}


class GivenUp(Exception):
    """A row took too long."""


def give_up(*_: object) -> None:
    raise GivenUp


def metrics_of(name: str, size: Size, limit_s: float) -> Iterator[Metric]:
    """What the row has to say. One that fails has a line that says so, and the others go on."""
    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(int(limit_s))
    try:
        yield from ROWS[name].run(size)
    except GivenUp:
        yield Metric("ended in time", 0, low=1, high=1, note=f"not in {limit_s:g} s")
    except Exception as error:  # whatever went wrong, the daemon, its client or the harness, is a miss
        traceback.print_exc()
        yield Metric("came to its end", 0, low=1, high=1, note=f"{type(error).__name__}: {error}"[:200].replace("|", "/").replace("\n", " "))
    finally:
        signal.alarm(0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("rows", nargs="*", metavar="ROW", help="these only; --list names them")
    parser.add_argument("--size", choices=sorted(SIZES), default="small")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=f"of {', '.join(vars(SIZES['small']))}")
    parser.add_argument("--list", action="store_true", help="print the rows and run none")
    options = parser.parse_args()
    if options.list:
        for name, row in ROWS.items():
            print(f"{name}\t{row.what}")
        return 0
    unknown = [name for name in options.rows if name not in ROWS]
    if unknown:
        parser.error(f"there is no row {unknown[0]}; there are {', '.join(ROWS)}")
    size = resized(SIZES[options.size], options.set)
    report = Report(list(ROWS), options.size)
    for name, row in ROWS.items():
        if options.rows and name not in options.rows:
            continue
        began = time.monotonic()
        for metric in metrics_of(name, size, row.limit_s * (1 if options.size == "small" else 100)):
            report.add(name, metric)
        remark(f"{name}: {time.monotonic() - began:.0f} s")
    if options.set:
        remark("sizes were set by hand: no table is written")
    else:
        remark(f"{report.write()}")
    return 0 if report.passed else 1


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Run a case until it is done, whatever stops it on the way, and leave its JSON object in RESULT, once.

    until_done.py [OPTION...] RESULT RUN_DIRECTORY CASE [OPTION OF meniscus run...]

What workflow managers have in common: they start a command, send it signals and look at its exit code and its files. This one
may be given again at any time: if RESULT is there it does nothing, else it goes on where the run was. RESULT appears whole or not
at all. SIGTERM and SIGINT, or --deadline, have the run write a checkpoint, and end this with 75; SIGUSR1 is a checkpoint only.
Should this be killed, the run leaves with a checkpoint too.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

AGAIN, BAD_RESULT = 75, 1  # <meniscus/exit.h>
# From outside; any other signal is a defect, which comes again.
STOPPED_BY = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGUSR1)
PAUSE_S, PATIENCE_S = 0.2, 60.0  # for another run to leave the directory


class Job:
    """A command that is tried again, and the child that tries it now."""

    def __init__(self, command: "list[str]") -> None:
        self.command = command
        self.child: "subprocess.Popen[str] | None" = None
        self.leaving = False
        # Once this is gone, nobody would wait for the run.
        if shutil.which("setpriv"):
            self.command = ["setpriv", "--pdeathsig", "TERM", *command]

    def leave(self, *_: Any) -> None:
        self.leaving = True
        self.send(signal.SIGTERM)

    def checkpoint(self, *_: Any) -> None:
        self.send(signal.SIGUSR1)

    def send(self, number: int) -> None:
        if self.child:
            self.child.send_signal(number)

    def attempt(self) -> "tuple[int, dict[str, Any] | None]":
        """Exit code, negative for a signal, and the object, if there is one."""
        # In a session of its own, so that Ctrl-C reaches it once, through us.
        self.child = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        if self.leaving:
            self.send(signal.SIGTERM)
        words, _ = self.child.communicate()
        try:
            return self.child.returncode, json.loads(words)
        except ValueError:
            return self.child.returncode, None


def keep(path: Path, told: "dict[str, Any]") -> None:
    """Under its final name it is whole, and on the disk."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    with open(part, "w", encoding="utf-8") as file:
        json.dump(told, file, indent=1)
        file.write("\n")
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def is_taken(code: int, told: "dict[str, Any] | None") -> bool:
    """Another run is still in the directory, such as one that was told to leave."""
    return code == AGAIN and bool(told) and (told.get("error") or {}).get("status") == "wrong state"


def until_done(job: Job, result: Path, tries: int, accepted: "list[int]") -> int:
    patience = time.monotonic() + PATIENCE_S
    while not job.leaving and tries > 0:
        code, told = job.attempt()
        if code in accepted:
            if told is None:
                print(f"{result}: the run printed no JSON object", file=sys.stderr)
                return BAD_RESULT
            keep(result, told)
            return 0
        if is_taken(code, told) and time.monotonic() < patience:
            time.sleep(PAUSE_S)
        elif code == AGAIN or -code in STOPPED_BY:
            tries -= 1
        else:
            return code if code >= 0 else 128 - code
    return AGAIN


def main() -> int:
    parser = argparse.ArgumentParser(usage="%(prog)s [OPTION...] RESULT RUN_DIRECTORY CASE [OPTION OF meniscus run...]",
                                     description="Run a case until it is done; its JSON object goes to RESULT, once.")
    parser.add_argument("--deadline", type=float, metavar="S", help="leave with a checkpoint and exit code 75 after so long")
    parser.add_argument("--tries", type=int, default=20, metavar="N", help="how often the run is started at most (20)")
    parser.add_argument("--accept", type=int, action="append", default=[0], metavar="CODE",
                        help="take the object of a run that ended with this code for a result too: 70 for one that diverged")
    parser.add_argument("result", type=Path, metavar="RESULT")
    parser.add_argument("directory", type=Path, metavar="RUN_DIRECTORY")
    parser.add_argument("case", metavar="CASE")
    parser.add_argument("options", nargs=argparse.REMAINDER, metavar="OPTION OF meniscus run")
    o = parser.parse_args()
    if o.result.exists():
        print(f"{o.result}: is there already, so nothing is run; remove it and {o.directory} for a new run", file=sys.stderr)
        return 0
    o.result.parent.mkdir(parents=True, exist_ok=True)
    job = Job([os.environ.get("MENISCUS", "meniscus"), "run", o.case, "--out", str(o.directory), *o.options,
               "--resume", "auto", "-o", "json"])
    signal.signal(signal.SIGTERM, job.leave)
    signal.signal(signal.SIGINT, job.leave)
    signal.signal(signal.SIGUSR1, job.checkpoint)
    signal.signal(signal.SIGALRM, job.leave)
    if o.deadline:
        signal.setitimer(signal.ITIMER_REAL, o.deadline)
    return until_done(job, o.result, o.tries, o.accept)


if __name__ == "__main__":
    sys.exit(main())

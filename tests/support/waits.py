#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""waits.py FILE COMMAND...: run a command, and write to FILE what it and its children wait for: shares of its time, the largest first.

A sample is taken ten times a second, of all processes of the command. One that computes counts for all of them; else those count that do not just
wait for their children. What a thread waits for is told by the system call that it is in, which only x86-64 is asked for.
"""

from __future__ import annotations

import os
import platform
import sys
import time
from collections import Counter
from pathlib import Path

EVERY = 0.1  # [s]
PROCESSOR, CHILDREN, DISK, OTHER = "the processor", "its children", "the disk", "something else"
CALLS = {
    "a pipe": (0, 20),
    "sockets": (7, 23, 43, 45, 47, 232, 270, 271, 281, 288),
    "time to pass": (35, 230),
    "other threads": (202,),
    CHILDREN: (61, 247),
    DISK: (74, 75),
}
NAMED = {call: name for name, calls in CALLS.items() for call in calls}


def family(pid: int) -> list[int]:
    """A process and all below it that are still there."""
    found = [pid]
    for one in found:  # grows as it goes
        for task in Path(f"/proc/{one}/task").glob("*/children"):
            found += [int(child) for child in task.read_text().split()]
    return found


def state(pid: int) -> str:
    """What the main thread of a process waits for; the processor if any of its threads computes."""
    for stat in Path(f"/proc/{pid}/task").glob("*/stat"):
        letter = stat.read_text().rpartition(")")[2].split()[0]
        if letter in "RD":
            return PROCESSOR if letter == "R" else DISK
    call = Path(f"/proc/{pid}/syscall").read_text().split()[0]
    known = call.isdigit() and platform.machine() == "x86_64"
    return NAMED.get(int(call), OTHER) if known else OTHER


def watch(pid: int, file: Path) -> None:
    seen: Counter[str] = Counter()
    while Path(f"/proc/{pid}").exists():
        time.sleep(EVERY)
        try:
            states = [state(one) for one in family(pid)]
        except (OSError, IndexError):  # one of them has just ended
            continue
        waits = [PROCESSOR] if PROCESSOR in states else [one for one in states if one != CHILDREN] or states
        for one in waits:
            seen[one] += 1 / len(waits)
    total = sum(seen.values())
    file.write_text(", ".join(f"{name} {100 * count / total:.0f} %" for name, count in seen.most_common(3)) + "\n")


def main() -> None:
    file, command = Path(sys.argv[1]), sys.argv[2:]
    pid = os.getpid()
    if os.fork():
        os.wait()
        os.execvp(command[0], command)
    if os.fork():  # a second time: the watcher must not be a child of the command, which may wait for all its children
        os._exit(0)
    os.setsid()
    for stream in range(3):
        os.dup2(os.open(os.devnull, os.O_RDWR), stream)
    watch(pid, file)
    os._exit(0)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: BSD-3-Clause
"""Daemons and runs that are killed at random moments, and what is the same afterwards, to the bit."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Iterator

from daemon import BUILD, ROOT, surroundings

from .live import test_program
from .metrics import Metric, Size, all_of

# One of each scheme, small, to an end within seconds.
RUNS = {
    "dambreak2d": ["resolution=16", "end_time=0.4"],
    "sloshing2d-three-layers": ["resolution=20", "end_time=0.02"],
    "square-drop2d": ["resolution=20", "end_time=0.02"],
    "droplet-oscillation2d": ["resolution=20", "end_time=0.02"],
    "taylor-green2d-differences": ["resolution=20", "end_time=0.02"],
}


def kills(size: Size) -> Iterator[Metric]:
    """By the test of it, more often: commands go on under ids of their own while the daemon is killed and started again."""
    test = "Crash.test_nothing_is_lost_and_nothing_done_twice"
    passed, failed, said = test_program(
        [sys.executable, "tests/system/test_crash.py", test], 60 + 5 * size.kills, MENISCUS_KILLS=str(size.kills))
    told = re.search(r"(\d+) kills, (\d+) commands, (\d+) steps, back in ([\d.]+) s at most", said)
    if not told or failed:
        sys.stderr.write(said[-3000:])
    note = f"{told[1]} kills, {told[2]} commands, {told[3]} steps" if told else "the test failed"
    yield all_of("kill -9: no accepted command lost, none done twice, every file opens, the journal replays", passed, 1, note)
    yield Metric("back in", float(told[4]) if told else float("nan"), "s", high=5)


def batch(home: Path, environment: "dict[str, str]", case: str, out: str, *more: str) -> "list[str]":
    settings = [word for setting in RUNS[case] for word in ("--set", setting)]
    return [str(BUILD / "meniscus"), "run", case, *settings, "--out", str(home / out), "-o", "json", *more]


def replays(size: Size) -> Iterator[Metric]:
    """A run of each scheme, alone and killed and gone on with, and done again from its journal: by one thread and by two."""
    same = again = killed = 0
    with tempfile.TemporaryDirectory(prefix="mns-torture-") as scratch:
        home = Path(scratch)
        environment = surroundings(home)
        for case in RUNS:
            alone = json.loads(_run(batch(home, environment, case, f"{case}-alone", "--set", "threads=1"), environment).stdout)
            words = batch(home, environment, case, f"{case}-killed", "--set", "threads=2", "--set", f"output.checkpoint_interval={alone['t'] / 20}",
                          "--resume", "auto")
            done, times = _disturbed(words, environment, size.replays, alone["wall_s"])
            killed += times
            same += done["state_hash"] == alone["state_hash"]
            replay = _run([str(BUILD / "meniscus"), "replay", str(home / f"{case}-killed"), "--verify", "-o", "json"], environment)
            again += json.loads(replay.stdout)["agrees"]
    yield all_of("runs killed and gone on with that end as if alone, bit for bit", same, len(RUNS), f"{killed} kills, 1 and 2 threads")
    yield all_of("their journals, replayed, bit for bit", again, len(RUNS))


def _run(words: "list[str]", environment: "dict[str, str]") -> "subprocess.CompletedProcess[str]":
    done = subprocess.run(words, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words[:4])} ended with {done.returncode}: {done.stderr[-300:]}")
    return done


def _disturbed(words: "list[str]", environment: "dict[str, str]", times: int, wall_s: float) -> "tuple[Any, int]":
    """Kill it so often on its way, and let it end; what it prints then, and how often it was killed before its end."""
    killed = 0
    for _ in range(times):
        process = subprocess.Popen(words, env=environment, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(random.uniform(0.1, 0.3 + wall_s / 2))
        os.kill(process.pid, signal.SIGKILL)
        killed += process.wait() != 0
    return json.loads(_run(words, environment).stdout), killed

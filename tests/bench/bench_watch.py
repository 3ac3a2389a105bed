#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What one watching client costs the solver: steps per second of a daemon alone and while `meniscus watch` follows it, in turns.

Prints one JSON line. usage: bench_watch.py [SECONDS_A_TURN [TURNS]]
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BUILD = Path(os.environ.get("BUILD", Path(__file__).resolve().parents[2] / "build")).resolve()
NAME = "bench"


def command(*words: str) -> str:
    done = subprocess.run([BUILD / "meniscus", "--daemon", NAME, *words], check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout


def status() -> dict:
    return json.loads(command("status", "-o", "json"))


def steps_per_second(seconds: float) -> float:
    first, start = status()["step"], time.monotonic()
    time.sleep(seconds)
    last, end = status()["step"], time.monotonic()
    return (last - first) / (end - start)


def watched(seconds: float) -> float:
    watcher = subprocess.Popen([BUILD / "meniscus", "--daemon", NAME, "watch"], stdout=subprocess.DEVNULL)
    try:
        time.sleep(0.3)
        return steps_per_second(seconds)
    finally:
        watcher.terminate()
        watcher.wait()


def measure(seconds: float, turns: int) -> dict:
    command("load", "dambreak2d", "--set", "resolution=60", "--set", "end_time=1000", "--start")
    time.sleep(1)
    pairs = []
    for _ in range(turns):  # the one before and the one after: drifts of the flow and the machine cancel
        before, during, after = steps_per_second(seconds), watched(seconds), steps_per_second(seconds)
        pairs.append((0.5 * (before + after), during))
    state = status()
    losses = [1 - during / alone for alone, during in pairs]
    return {
        "name": "watching-client",
        "threads": state["threads"],
        "particles": state["particles"],
        "steps_per_second_alone": round(statistics.median(p[0] for p in pairs), 1),
        "steps_per_second_watched": round(statistics.median(p[1] for p in pairs), 1),
        "loss": round(statistics.median(losses), 4),
        "turns": turns,
    }


def main() -> int:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 3
    turns = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    with tempfile.TemporaryDirectory() as directory:
        os.environ["XDG_RUNTIME_DIR"] = directory
        log = Path(directory) / "log"
        with log.open("w", encoding="utf-8") as stderr:
            daemon = subprocess.Popen(
                [BUILD / "meniscusd", "--name", NAME, "--state-dir", f"{directory}/state"], stderr=stderr
            )
        try:
            for _ in range(100):
                if (Path(directory) / "meniscus" / NAME / "control.ipc").exists():
                    break
                time.sleep(0.05)
            print(json.dumps(measure(seconds, turns)), flush=True)
        finally:
            daemon.terminate()
            daemon.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())

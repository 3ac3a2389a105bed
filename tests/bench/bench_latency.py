#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""How long a client waits for `status` and `pause` while the solver has every processor. Prints one JSON line.

usage: bench_latency.py [SECONDS]
"""

from __future__ import annotations

import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BUILD = Path(os.environ.get("BUILD", Path(__file__).resolve().parents[2] / "build")).resolve()
sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402

PAUSE_EVERY_S = 0.2


def milliseconds(call) -> float:  # type: ignore[no-untyped-def]
    start = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - start)


def measure(client: meniscus.Client, seconds: float) -> dict:
    client.load("dambreak2d", {"resolution": 40, "end_time": 1000, "threads": os.cpu_count()}, start=True)
    time.sleep(0.5)
    first = client.status().step
    status: list[float] = []
    pause: list[float] = []
    until = time.monotonic() + seconds
    pause_at = time.monotonic() + PAUSE_EVERY_S
    while time.monotonic() < until:
        status.append(milliseconds(client.status))
        if time.monotonic() > pause_at:
            pause.append(milliseconds(client.pause))
            client.resume()
            pause_at = time.monotonic() + PAUSE_EVERY_S
        time.sleep(random.uniform(0.006, 0.012))  # not in step with the solver, and less often than the pace of questions allows
    last = client.status()
    percentiles = statistics.quantiles(status, n=100)
    return {
        "name": "control-latency",
        "status_p50_ms": round(percentiles[49], 3),
        "status_p99_ms": round(percentiles[98], 3),
        "status_max_ms": round(max(status), 3),
        "pause_p50_ms": round(statistics.median(pause), 3),
        "pause_ms_max": round(max(pause), 3),
        "statuses": len(status),
        "pauses": len(pause),
        "steps": last.step - first,
        "steps_per_second": round((last.step - first) / seconds, 1),
        "particles": last.particles,
        "threads": last.threads,
    }


def main() -> int:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 8
    with tempfile.TemporaryDirectory(prefix="mns-") as home:
        os.environ["XDG_RUNTIME_DIR"] = home
        words = [BUILD / "meniscusd", "--name", "bench", "--state-dir", f"{home}/state", "--log-level", "error"]
        daemon = subprocess.Popen(words)
        try:
            socket = Path(home) / "meniscus" / "bench" / "control.ipc"
            for _ in range(200):
                if socket.exists():
                    break
                time.sleep(0.05)
            with meniscus.Client("bench") as client:
                print(json.dumps(measure(client, seconds)), flush=True)
        finally:
            daemon.terminate()
            daemon.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())

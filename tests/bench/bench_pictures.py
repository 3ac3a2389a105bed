#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""How many pictures of 10^5 particles a second reach one browser from a running solver, and what they cost: the gateway, and the page in Chromium.

The first browser is none: it says that it has drawn each picture as soon as that is there, so that what is measured is the way to it. The second is
headless Chromium without a graphics processor, whose drawing says nothing of others; what its page computes for a picture does. It is left out where
there is no Chromium, or its remote control was not fetched (`make check CI=1` does).

Prints one JSON line. usage: bench_pictures.py [SECONDS]
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from browser import Browser  # noqa: E402

BUILD = Path(os.environ.get("BUILD", ROOT / "build")).resolve()
NAME = "pictures"
RESOLUTION = 97  # 100,900 particles of fluid


def meniscus(*words: str) -> "dict[str, Any]":
    done = subprocess.run([BUILD / "meniscus", "--daemon", NAME, "-o", "json", *words], check=True, stdout=subprocess.PIPE, text=True)
    told: "dict[str, Any]" = json.loads(done.stdout)
    return told


def cpu_s(process: "subprocess.Popen[bytes]") -> float:
    words = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def to_nobody(port: int, gateway: "subprocess.Popen[bytes]", seconds: float) -> "dict[str, Any]":
    with Browser(port) as browser:
        browser.say(do="hello")
        browser.until("hello")
        browser.say(do="show", field="pressure", limit=1_000_000, walls=False)
        first = browser.picture()
        while first["field"] != "pressure":
            browser.say(do="drawn", count=1)
            first = browser.picture()
        began, before, steps, pictures, skipped = time.monotonic(), cpu_s(gateway), meniscus("status")["step"], 0, 0
        while time.monotonic() < began + seconds:
            browser.say(do="drawn", count=1)
            skipped += browser.picture()["skipped"]
            pictures += 1
        took = time.monotonic() - began
        return {
            "particles": first["particles"], "pictures_per_s": round(pictures / took, 1), "skipped": skipped,
            "steps_per_s": round((meniscus("status")["step"] - steps) / took, 1),
            "gateway_ms_per_picture": round(1e3 * (cpu_s(gateway) - before) / pictures, 2),
            "bytes_per_picture": first["particles"] * (4 * first["dimensions"] + 5),
        }


def to_chromium(port: int, seconds: float) -> "dict[str, Any]":
    script = Path(__file__).with_name("pictures.mjs")
    done = subprocess.run(["node", script, BUILD, str(port), str(seconds)], capture_output=True, text=True, timeout=seconds + 60)
    told: "dict[str, Any]" = json.loads(done.stdout) if done.returncode == 0 else {}
    return told


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10
    with tempfile.TemporaryDirectory() as home:
        os.environ["XDG_RUNTIME_DIR"] = home
        daemon = subprocess.Popen([BUILD / "meniscusd", "--name", NAME, "--state-dir", f"{home}/runs"], stderr=subprocess.DEVNULL)
        log = Path(home) / "gateway.log"
        try:
            meniscus("load", "dambreak2d", "--set", f"resolution={RESOLUTION}", "--set", "threads=1", "--start")
            with open(log, "wb") as file:
                gateway = subprocess.Popen([BUILD / "meniscus-dashboard", "--daemon", NAME, "--http", "0", "--no-token"], stderr=file)
            try:
                found = None
                while not (found := re.search(r"is at http://127\.0\.0\.1:(\d+)/", log.read_text())) and gateway.poll() is None:
                    time.sleep(0.05)
                port = int(found[1]) if found else 0
                told = {"name": "pictures", "threads": 1, **to_nobody(port, gateway, seconds), **to_chromium(port, seconds)}
            finally:
                gateway.terminate()
                gateway.wait()
        finally:
            daemon.terminate()
            daemon.wait()
    print(json.dumps(told))


if __name__ == "__main__":
    main()

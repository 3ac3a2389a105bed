#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What streams deliver and cost, as JSON lines: bench_streams.py [SECONDS]

  snapshots   bytes a second of a file of --megabytes to one client, and the time from a cancel to its answer
  (cores: of processors that the threads which serve streams take; of ZeroMQ's too)
  cost        steps a second with 32 streams of probes and 4 of fields at 10 Hz, over those without, in alternation
  stopped     the same with 1000 streams of fields at 10 Hz to clients that take nothing, and the memory that streams hold
"""

import json
import os
import re
import statistics
import sys
import threading
import time
import urllib.request
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import DaemonTest, free_ports  # noqa: E402
from streaming import Taker, sb  # noqa: E402

SECONDS = float(sys.argv[1]) if len(sys.argv) > 1 else 5
CASE = ["dambreak2d", "--set", "resolution=60", "--set", "end_time=1000", "--set", "output.snapshot_interval=1000",
        "--set", "output.checkpoint_interval=1000"]
CREDIT = 8 << 20
FIELDS = sb.FieldStream(fields=[sb.FieldWish(name=name) for name in ("position", "velocity", "pressure", "density")])


def tell(**what: Any) -> None:
    print(json.dumps(what), flush=True)


class Bench(DaemonTest):
    def rate(self, seconds: float = SECONDS) -> float:
        before, began = self.ask("status")["step"], time.monotonic()
        time.sleep(seconds)
        return float((self.ask("status")["step"] - before) / (time.monotonic() - began))

    def endpoint(self) -> str:
        return f"ipc://{self.home}/run/meniscus/default/data.ipc"

    def cpu(self) -> float:
        """Seconds that the threads which serve streams have computed: on a machine that is busy otherwise, steps a second say little."""
        total = 0
        for task in Path(f"/proc/{self.daemon.pid}/task").iterdir():
            name, rest = (task / "stat").read_text().split("(", 1)[1].rsplit(")", 1)
            if name == "streams" or name.startswith("ZMQbg/IO"):
                total += sum(int(x) for x in rest.split()[11:13])
        return total / os.sysconf("SC_CLK_TCK")

    def memory(self) -> float:
        text = urllib.request.urlopen(f"http://127.0.0.1:{self.port}/metrics").read().decode()
        return float(re.search(r"^meniscus_streams_memory_bytes (\S+)", text, re.MULTILINE).group(1))

    def snapshots(self, megabytes: int = 512) -> None:
        """A file that looks like a snapshot: the solver need not write one so large."""
        self.meniscus("load", *CASE)
        directory = Path(self.ask("status")["run_directory"])
        (directory / "snapshot-0000000001.hdf").write_bytes(os.urandom(1 << 20) * megabytes)
        rates, cores, held = [], [], 0.0
        for _ in range(5):
            taker = Taker(self.endpoint())
            stream = taker.subscribe(snapshots=sb.SnapshotStream(), credit=CREDIT, chunk_bytes=1 << 20).stream
            began, cpu, taken = time.monotonic(), self.cpu(), 0
            while taken < megabytes << 20:
                frames = taker.socket.recv_multipart(copy=False)
                if len(frames) < 2:
                    continue
                taken += len(frames[1].buffer)
                taker.grant(stream, len(frames[0].buffer) + len(frames[1].buffer))
            rates.append(taken / (time.monotonic() - began))
            cores.append((self.cpu() - cpu) / (taken / 1e9))
            held = max(held, self.memory())
            taker.close()
        taker = Taker(self.endpoint())
        cancels = []
        for _ in range(5):
            stream = taker.subscribe(snapshots=sb.SnapshotStream(), credit=1 << 30).stream
            taker.socket.recv_multipart()
            began = time.monotonic()
            taker.send(cancel=sb.CancelItem(stream=stream))
            while not (item := sb.StreamMessage.FromString(taker.socket.recv_multipart()[0]).item).HasField("cancelled"):
                assert item.offset < megabytes << 20
            cancels.append(time.monotonic() - began)
        taker.close()
        tell(bench="snapshots", gigabytes_per_second=[round(rate / 1e9, 2) for rate in rates], held_mib=held / 2**20,
             cpu_seconds_per_gigabyte=round(statistics.median(cores), 3),
             cancel_ms=[round(1e3 * t, 1) for t in cancels])

    def taking(self, takers: "list[Taker]", over: threading.Event) -> None:
        while not over.is_set():
            for taker in takers:
                while taker.socket.poll(0):
                    frames = taker.socket.recv_multipart()
                    item = sb.StreamMessage.FromString(frames[0]).item
                    if item.size:
                        taker.grant(item.stream, sum(len(frame) for frame in frames))
            time.sleep(0.02)

    def alternate(self, name: str, begin: Any) -> None:
        """Without, with, without ...: other things on this machine change more slowly than that."""
        without, with_, held, busy = [], [], [], []
        for _ in range(3):
            without.append(self.rate())
            end = begin()
            time.sleep(0.3)
            cpu, began = self.cpu(), time.monotonic()
            with_.append(self.rate())
            busy.append((self.cpu() - cpu) / (time.monotonic() - began))
            held.append(self.memory())
            end()
            time.sleep(0.3)
        tell(bench=name, steps_per_second=[round(x, 1) for x in without], with_streams=[round(x, 1) for x in with_],
             cost=round(1 - statistics.median(b / a for a, b in zip(without, with_)), 4), held_mib=max(held) / 2**20,
             cores=round(statistics.median(busy), 4))

    def watchers(self) -> Any:
        over = threading.Event()
        takers = [Taker(self.endpoint()) for _ in range(36)]
        for k, taker in enumerate(takers):
            what = dict(probes=sb.ProbeStream()) if k < 32 else dict(fields=FIELDS)
            taker.subscribe(when=sb.When(max_hz=10), credit=CREDIT, **what)
        thread = threading.Thread(target=self.taking, args=(takers, over))
        thread.start()

        def end() -> None:
            over.set()
            thread.join()
            for taker in takers:
                taker.close()

        return end

    def stopped(self) -> Any:
        takers = [Taker(self.endpoint()) for _ in range(20)]
        for k in range(1000):
            taker = takers[k % 20]
            taker.subscribe(fields=FIELDS, when=sb.When(max_hz=10 + k % 10), credit=300000)

        def end() -> None:
            for taker in takers:
                taker.close()

        return end

    def test(self) -> None:
        self.snapshots()
        self.meniscus("start")
        time.sleep(2)
        self.alternate("cost", self.watchers)
        self.alternate("stopped", self.stopped)


if __name__ == "__main__":
    Bench.port = free_ports()
    Bench.options = ["--http", str(Bench.port)]
    Bench.setUpClass()
    bench = Bench("test")
    try:
        bench.test()
    finally:
        bench.tearDown()
        Bench.doClassCleanups()

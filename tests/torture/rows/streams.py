# SPDX-License-Identifier: BSD-3-Clause
"""Streams: a snapshot as fast as a client takes it, and samples of which none is missing whoever is killed."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

import h5py
import numpy as np
from daemon import BUILD
from streaming import Taker, sb

from .live import Daemon
from .metrics import Metric, Size, all_of, none_of

SMALL = {  # a row a step, thousands a second
    "resolution": 3, "threads": 1, "end_time": 1e6,
    "probes": "[{name: kinetic, kinetic_energy: {}}, {name: front, front: {fluid: water, axis: x}}]",
    "output.probe_interval": 1e-6, "output.checkpoint_interval": 100, "output.snapshot_interval": 100,
}
CHUNK, WINDOW = 1 << 20, 32 << 20  # bytes of a message, and that may be under way
GRANT_AT = 4 << 20  # bytes taken after which there is more credit
GB_S, CANCEL_MS, MEMORY_MIB = 1.4, 50, 256
PARTICLES = 1000**2  # of the snapshot, about
LIMIT_S = 100


def data_endpoint(daemon: Daemon) -> str:
    return daemon.endpoint.replace("control.ipc", "data.ipc")


@contextmanager
def takers(daemon: Daemon, count: int, hertz: float) -> "Iterator[subprocess.Popen[str]]":
    """Clients that take positions and pressures of all particles, so often; ready when each has had the first."""
    words = [sys.executable, "-m", "rows.takers", "fields", data_endpoint(daemon), str(count), str(hertz)]
    process = subprocess.Popen(words, cwd=Path(__file__).parents[1], env=os.environ | {"BUILD": str(BUILD)}, stdout=subprocess.PIPE, text=True)
    try:
        if process.stdout and process.stdout.readline() != "ready\n":
            raise RuntimeError("who takes fields did not get ready")
        yield process
    finally:
        process.kill()
        process.wait()
        if process.stdout:
            process.stdout.close()


# --- a snapshot -------------------------------------------------------------------------------------------------------


class Peak:
    """The most memory that the daemon has while the block lasts."""

    def __init__(self, daemon: Daemon) -> None:
        self.daemon, self.before, self.most = daemon, daemon.memory_mib(), 0.0
        self.over = threading.Event()
        self.watch = threading.Thread(target=self._look)

    def __enter__(self) -> Peak:
        self.watch.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.over.set()
        self.watch.join()

    def _look(self) -> None:
        while not self.over.wait(0.01):
            self.most = max(self.most, self.daemon.memory_mib() - self.before)


def snapshot(size: Size) -> Iterator[Metric]:
    """The files of a run, byte for byte, from the page cache, to one client that does nothing with them."""
    with Daemon() as daemon, daemon.client(timeout=LIMIT_S) as client:
        client.load("dambreak2d", {"resolution": (PARTICLES / 12) ** 0.5, "end_time": 1e4})
        total = Path(client.snapshot(["velocity", "pressure", "density"]).path).stat().st_size
        with Peak(daemon) as peak:
            began = time.monotonic()
            taken = sum(_take_all(daemon) for _ in range(size.turns))
            seconds = time.monotonic() - began
        late = [_cancel(daemon) for _ in range(5 * size.turns)]
    yield all_of("bytes of a snapshot that came", taken, size.turns * total)
    yield Metric("snapshot to one client of this machine", taken / seconds / 1e9, "GB/s", low=GB_S, note=f"{total / 1e6:.0f} MB, {size.turns} times")
    yield Metric("memory that the daemon takes for it", peak.most, "MiB", high=MEMORY_MIB)
    yield Metric("from a cancel to the last byte, the longest", 1e3 * max(late), "ms", high=CANCEL_MS, note=f"of {len(late)}")


def _messages(taker: Taker, seconds: float) -> "Iterator[tuple[sb.StreamItem, int]]":
    """Items, with the bytes of both frames, which are not looked at."""
    while taker.socket.poll(int(1000 * seconds)):
        frames = taker.socket.recv_multipart(copy=False)
        message = sb.StreamMessage.FromString(frames[0].bytes)
        if message.HasField("item"):
            yield message.item, sum(len(frame) for frame in frames)
    raise TimeoutError("nothing came")


def _take_all(daemon: Daemon) -> int:
    """All bytes of the files that there are; the stream begins anew with each call."""
    taker = Taker(data_endpoint(daemon))
    try:
        stream = taker.subscribe(snapshots=sb.SnapshotStream(), credit=WINDOW, chunk_bytes=CHUNK).stream
        used = 0
        for item, n in _messages(taker, 30):
            used += n
            if item.HasField("next") and item.HasField("xxh64"):
                return int(item.size)
            if used >= GRANT_AT:
                taker.grant(stream, used)
                used = 0
        raise AssertionError  # not reached: the messages do not end
    finally:
        taker.close()


def _cancel(daemon: Daemon) -> float:
    """How long after a cancel in the midst of an item the last of it comes."""
    taker = Taker(data_endpoint(daemon))
    try:
        stream = taker.subscribe(snapshots=sb.SnapshotStream(), credit=1 << 29, chunk_bytes=CHUNK).stream
        began = 0.0
        for item, _ in _messages(taker, 30):
            if item.HasField("cancelled"):
                return time.monotonic() - began
            if not began:
                began = time.monotonic()
                taker.send(cancel=sb.CancelItem(stream=stream, sequence=item.sequence))
        raise TimeoutError("the item was not cancelled")
    finally:
        taker.close()


# --- samples ----------------------------------------------------------------------------------------------------------


class Cursor:
    """What one has of the series, and where it goes on."""

    def __init__(self) -> None:
        self.times: "list[float]" = []
        self.place = b""

    def take_until(self, daemon: Daemon, rows: int) -> None:
        """Until there are so many; a part of those that one had may be abandoned on the way."""
        while len(self.times) < rows:
            had = len(self.times)
            self.take(daemon, rows - had, LIMIT_S)
            if len(self.times) == had:
                raise TimeoutError(f"no row came behind {had} in {LIMIT_S} s")

    def take(self, daemon: Daemon, rows: int, seconds: float) -> None:
        """By a process of its own, which ends when so many rows have come, or is killed in the midst of it after so many seconds."""
        words = [sys.executable, "-m", "rows.takers", "samples", data_endpoint(daemon), self.place.hex() or "-", str(rows)]
        process = subprocess.Popen(words, cwd=Path(__file__).parents[1], env=os.environ | {"BUILD": str(BUILD)}, stdout=subprocess.PIPE)
        timer = threading.Timer(seconds, process.kill)
        timer.start()
        said, _ = process.communicate()
        timer.cancel()
        self._read(said)

    def _read(self, said: bytes) -> None:
        """Records of the process, up to the one that its end cut off: two lengths, a cursor, times; a cut-off is as if it never came."""
        at = 0
        while at + 24 <= len(said):
            keep, n_cursor, n_times = (int(n) for n in np.frombuffer(said, "<i8", 3, at))
            end = at + 24 + n_cursor + 8 * n_times
            if end > len(said):
                return
            if keep >= 0:
                del self.times[keep:]  # a time line was left
            self.place = said[at + 24:at + 24 + n_cursor]
            self.times += np.frombuffer(said, "<f8", n_times, at + 24 + n_cursor).tolist()
            at = end


def lossless(size: Size) -> Iterator[Metric]:
    """All along the series clients are killed and go on from the cursor they had, and the daemon is killed and comes back. At the end
    one has what the file has."""
    chance, cursor = random.Random(3), Cursor()
    with Daemon() as daemon:
        with daemon.client() as client:
            client.load("dambreak2d", SMALL, start=True)
            directory = Path(client.status().run_directory or "")
        for k in range(1, size.client_kills + 1):
            cursor.take(daemon, size.samples, chance.uniform(0.2, 1))
            if k % max(1, size.client_kills // size.daemon_kills) == 0:
                daemon.kill()
                daemon.start()
            cursor.take_until(daemon, size.samples * k // size.client_kills)
        cursor.take_until(daemon, len(cursor.times) + 1)  # on the way back after a kill the file has not yet what one had before
        with daemon.client() as client:
            client.pause()
            client.stop(checkpoint=True)
        with h5py.File(directory / "probes.hdf") as file:
            wanted = file["time"][:]
    had = np.array(cursor.times)
    same = min(len(had), len(wanted))
    yield Metric("samples that came", len(had), low=size.samples, note=f"{size.client_kills} kills of the client, {size.daemon_kills} of the daemon")
    yield none_of("samples twice or out of order", int(np.sum(np.diff(had) <= 0)))
    yield none_of("samples that are not those of the file, from the first on", int(np.sum(had[:same] != wanted[:same])) + max(0, len(had) - len(wanted)))

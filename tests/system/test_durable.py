#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the journal does not have on the disk yet, nobody sees: neither who asks, nor who listens, nor who waits for it."""

import os
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path
from typing import Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, control_socket  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import Client  # noqa: E402

DELAY = 0.25  # [s], of the disk
SLOW_DISK = f"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>
static int late(const char *name, int fd)
{{
    int (*sync)(int) = (int (*)(int))dlsym(RTLD_NEXT, name);
    const struct timespec delay = {{.tv_nsec = {round(1e9 * DELAY)}}};
    nanosleep(&delay, 0);
    return sync(fd);
}}
int fdatasync(int fd) {{ return late("fdatasync", fd); }}
int fsync(int fd) {{ return late("fsync", fd); }}
"""


class Durable(DaemonTest):
    @classmethod
    def start_daemon(cls) -> None:
        """With a disk that takes its time."""
        source, library, plain = cls.home / "slow.c", cls.home / "slow.so", cls.environment
        source.write_text(SLOW_DISK)
        subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
        cls.environment = plain | {"LD_PRELOAD": str(library)}
        super().start_daemon()
        cls.environment = plain

    def setUp(self) -> None:
        self.meniscus("load", "dambreak2d", "--set", "resolution=8", "--set", "threads=1", "--set", "end_time=30")

    def client(self) -> Client:
        client = Client(f"ipc://{control_socket(self.home)}", timeout=30)
        self.addCleanup(client.close)
        return client

    def sees_late(self, command: Callable[[Client], object], see: Callable[[Client], object]) -> None:
        """Who looks from the moment of a command on sees what it does when the disk has it, and not before."""
        seen: list[float] = []
        looker = self.client()
        looker.status()  # it is there

        def look() -> None:
            see(looker)
            seen.append(time.monotonic())

        thread = threading.Thread(target=look)
        thread.start()
        time.sleep(0.3)
        began = time.monotonic()
        command(self.client())
        answered = time.monotonic()
        thread.join(timeout=60)
        self.assertGreater(seen[0] - began, DELAY)
        self.assertLess(seen[0] - answered, 20)

    def test_nobody_who_asks_sees_a_new_value_before(self) -> None:
        version = self.client().status().case_version

        def see(client: Client) -> None:
            while client.status().case_version == version and client.get("end_time")["end_time"].value == 30:
                time.sleep(0.002)

        self.sees_late(lambda client: client.set({"end_time": 2}), see)

    def test_nobody_who_listens_hears_of_it_before(self) -> None:
        self.sees_late(lambda client: client.set({"end_time": 2}),
                       lambda client: next(event for event in client.events() if event.what == "set"))

    def test_nobody_who_waits_for_a_state_is_answered_before(self) -> None:
        self.client().start()
        self.sees_late(lambda client: client.pause(), lambda client: client.wait(["PAUSED"]))

    def test_a_step_is_told_as_long_as_it_takes(self) -> None:
        """What sets out is on the disk before it begins, and whoever looks on sees it run."""
        self.sees_late(lambda client: client.run_until(0.5), lambda client: client.wait(step=1))

    def test_a_run_in_motion_does_not_wait_for_files_that_people_want(self) -> None:
        files, watcher = 12, self.client()
        watcher.set({"output.snapshot_interval": 100, "output.checkpoint_wall_interval": 0})  # its own files it does wait for
        watcher.start()
        threads = [threading.Thread(target=self.client().snapshot) for _ in range(files)]
        for thread in threads:
            thread.start()
        steps, longest, moved = watcher.status().step, 0.0, time.monotonic()
        while any(thread.is_alive() for thread in threads):
            now = watcher.status().step
            if now > steps:
                longest, steps, moved = max(longest, time.monotonic() - moved), now, time.monotonic()
            time.sleep(0.01)
        self.assertLess(longest, 2 * files * DELAY)  # it stands for the journal, which has all that it is told at a boundary at once
        self.assertGreaterEqual(len(list((self.home / "state").glob("*/snapshot-*.hdf"))), 2)


if __name__ == "__main__":
    unittest.main()

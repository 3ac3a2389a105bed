#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""meniscus top: what daemons do, for people on a terminal and for scripts."""

import json
import os
import pty
import re
import signal
import socket
import subprocess
import sys
import termios
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, SMALL, DaemonTest  # noqa: E402

KEYS = set(
    "name endpoint alive silent state case fault time end_time step recovery_step steps_per_second eta_s memory_bytes clients streams".split()
)


class Top(DaemonTest):
    def daemons(self) -> dict:
        rows = self.ask("top", "--once")["daemons"]
        for row in rows:
            self.assertEqual(set(row), KEYS)
        return {row["name"]: row for row in rows}

    def test_a_daemon_tells_what_it_does(self) -> None:
        empty = self.daemons()["default"]
        self.assertEqual((empty["state"], empty["case"], empty["clients"]), ("EMPTY", None, 0))
        self.meniscus("load", *SMALL, "--start")
        self.meniscus("wait", "--for", "step=20")
        running = self.daemons()["default"]
        self.assertEqual((running["state"], running["case"]), ("RUNNING", "dambreak2d"))
        self.assertGreater(running["steps_per_second"], 0)
        self.assertGreater(running["memory_bytes"], 1 << 20)

    def test_clients_are_counted_and_a_fault_is_shown(self) -> None:
        self.meniscus("load", *SMALL, "--set", "limits.density_max=1.0000001")
        waiting = subprocess.Popen([BUILD / "meniscus", "wait"], env=self.environment, stderr=subprocess.PIPE)
        until = time.monotonic() + 20
        while self.daemons()["default"]["clients"] != 1 and time.monotonic() < until:
            time.sleep(0.05)
        self.assertEqual(self.daemons()["default"]["clients"], 1)
        self.meniscus("start")
        self.assertEqual(waiting.wait(timeout=60), 70)
        waiting.communicate()
        self.assertTrue(self.daemons()["default"]["fault"])
        self.assertRegex(self.meniscus("top").stdout, "(?m)^default +FAULT +dambreak2d ")

    def test_without_a_terminal_it_is_one_plain_table(self) -> None:
        place = self.home / "run" / "meniscus" / "gone"
        place.mkdir(mode=0o700)
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(place / "control.ipc"))
        self.addCleanup((place / "control.ipc").unlink)
        lines = self.meniscus("top").stdout.splitlines()
        self.assertEqual(lines[0].split(), "NAME STATE CASE DONE STEPS/S ETA CLIENTS MEMORY FAULT".split())
        self.assertEqual({tuple(line.split()[:2]) for line in lines[1:]}, {("default", "EMPTY"), ("gone", "dead")})
        self.assertNotIn("\033", "".join(lines))

    def test_a_daemon_that_hangs_is_silent_and_holds_nobody_up(self) -> None:
        self.daemon.send_signal(signal.SIGSTOP)
        self.addCleanup(self.daemon.send_signal, signal.SIGCONT)
        began = time.monotonic()
        top, listed = self.daemons()["default"], self.ask("ls")["daemons"][0]
        for row in (top, listed):
            self.assertEqual((row["alive"], row["silent"], row["state"]), (False, True, None))
        self.assertRegex(self.meniscus("top").stdout, "(?m)^default +silent +- ")
        self.assertRegex(self.meniscus("ls").stdout, "(?m)^default +silent +- ")
        self.assertLess(time.monotonic() - began, 30)
        self.assertIn("no answer from ", self.meniscus("status", code=69).stderr)
        self.daemon.send_signal(signal.SIGCONT)
        self.assertTrue(self.daemons()["default"]["alive"])

    def test_one_that_is_stopped_and_has_a_full_queue_holds_nobody_up(self) -> None:
        place = self.home / "run" / "meniscus" / "full"
        place.mkdir(mode=0o700)
        path = str(place / "control.ipc")
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(path)
        listener.listen(0)
        queue = []
        self.addCleanup((place / "control.ipc").unlink)
        self.addCleanup(listener.close)
        with self.assertRaises(BlockingIOError):
            while True:
                queue.append(socket.socket(socket.AF_UNIX))
                self.addCleanup(queue[-1].close)
                queue[-1].setblocking(False)
                queue[-1].connect(path)
        began = time.monotonic()
        self.assertTrue(self.daemons()["full"]["silent"])
        self.assertRegex(self.meniscus("ls").stdout, "(?m)^full +silent +- ")
        self.assertRegex(self.meniscus("doctor", "--daemon", "full", code=1).stdout, "(?m)^problem +daemon ")
        self.assertLess(time.monotonic() - began, 50)

    def on_terminal(self, columns: int) -> "list[str]":
        """The first table on a terminal of so many columns."""
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        termios.tcsetwinsize(theirs, (24, columns))
        top = subprocess.Popen([BUILD / "meniscus", "top"], env=self.environment, stdout=theirs)
        os.close(theirs)
        shown = b""
        while not shown.endswith(b"\033[J"):
            shown += os.read(ours, 4096)
        top.terminate()
        top.wait(timeout=60)
        return [re.sub("\033\\[[0-9;]*[mKJ]", "", line) for line in shown.decode().splitlines()][:-1]

    def test_a_narrow_terminal_shows_all_of_it(self) -> None:
        self.meniscus("load", *SMALL, "--set", "limits.density_max=1.0000001", "--start")
        self.meniscus("wait", code=70)
        head, row, *fault = self.on_terminal(80)
        self.assertEqual(head.split(), "NAME STATE CASE DONE STEPS/S ETA CLIENTS MEMORY".split())
        self.assertRegex(row, r"^default +FAULT +dambreak2d .* [0-9.]+ MiB$")
        self.assertRegex(fault[0], "^  FAULT: diverged in step 1 ")
        self.assertLess(max(map(len, (head, row, *fault))), 80)
        self.assertEqual("FAULT: " + self.daemons()["default"]["fault"], "".join(line[2:] for line in fault), "to its end")
        self.meniscus("stop")
        self.meniscus("load", "dambreak2d-interfacial-square", "--set", "resolution=10")
        self.assertIn(" dambreak2d-interfacial-square ", self.meniscus("top").stdout, "whole, for who reads it by a program")
        self.meniscus("stop")
        self.meniscus("load", *SMALL, "--set", "limits.density_max=1.0000001", "--start")
        self.meniscus("wait", code=70)
        head, row = self.on_terminal(140)
        self.assertTrue(head.endswith("  FAULT"))
        self.assertIn("diverged in step 1 ", row)

    def test_no_more_daemons_are_shown_than_the_terminal_has_lines(self) -> None:
        for k in range(9):
            place = self.home / "run" / "meniscus" / f"gone{k}"
            place.mkdir(mode=0o700)
            with socket.socket(socket.AF_UNIX) as listener:
                listener.bind(str(place / "control.ipc"))
            self.addCleanup((place / "control.ipc").unlink)
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        termios.tcsetwinsize(theirs, (8, 80))
        top = subprocess.Popen([BUILD / "meniscus", "top"], env=self.environment, stdout=theirs)
        os.close(theirs)
        shown = b""
        while shown.count(b"STEPS/S") < 2 or not shown.endswith(b"\033[J"):
            shown += os.read(ours, 4096)
        top.terminate()
        top.wait(timeout=60)
        first = shown.split(b"\033[J")[0].decode().splitlines()
        self.assertEqual(len(first), 7, "and the last line is the cursor's")
        self.assertTrue(first[-1].startswith("... 5 more"), first)
        self.assertIn(b"\033[7A\r", shown)
        self.assertEqual(len(self.meniscus("top").stdout.splitlines()), 11)

    def test_an_interrupt_waits_for_no_more_than_one_daemon(self) -> None:
        for k in range(60):  # sockets that never answer
            place = self.home / "run" / "meniscus" / f"hung{k}"
            place.mkdir(mode=0o700)
            listener = socket.socket(socket.AF_UNIX)
            listener.bind(str(place / "control.ipc"))
            listener.listen()
            self.addCleanup((place / "control.ipc").unlink)
            self.addCleanup(listener.close)
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        top = subprocess.Popen([BUILD / "meniscus", "top"], env=self.environment, stdout=theirs)
        os.close(theirs)
        time.sleep(0.7)
        began = time.monotonic()
        top.send_signal(signal.SIGINT)
        self.assertEqual(top.wait(timeout=60), -signal.SIGINT)
        self.assertLess(time.monotonic() - began, 15)

    def test_on_a_terminal_it_is_made_anew_until_it_is_interrupted(self) -> None:
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        environment = self.environment | {"TERM": "xterm"}
        top = subprocess.Popen([BUILD / "meniscus", "top"], env=environment, stdout=theirs)
        os.close(theirs)
        shown = b""
        while shown.count(b"STEPS/S") < 2:
            shown += os.read(ours, 4096)
        top.send_signal(signal.SIGINT)
        self.assertEqual(top.wait(timeout=60), -signal.SIGINT)
        self.assertIn(b"\033[1m", shown)
        self.assertIn(b"\033[2A", shown)

    def test_scripts_get_an_object_each_second(self) -> None:
        words = [BUILD / "meniscus", "top", "-o", "json"]
        top = subprocess.Popen(words, env=self.environment, stdout=subprocess.PIPE, text=True)
        assert top.stdout
        for _ in range(2):
            self.assertEqual(json.loads(top.stdout.readline())["daemons"][0]["name"], "default")
        top.terminate()
        self.assertEqual(top.wait(timeout=60), -signal.SIGTERM)
        top.stdout.close()


if __name__ == "__main__":
    unittest.main()

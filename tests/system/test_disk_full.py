#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""A disk that is really full: a small tmpfs, which only this test sees, as it is mounted in a namespace of its own."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=20", "--set", "end_time=0.4", "--set", "output.snapshot_interval=0.02",
        "--set", "output.probe_interval=0.005", "--set", "threads=1"]
SNAPSHOTS, ROWS = 21, 81
TINY_BYTES, SMALL_BYTES, LARGE_BYTES = 2 << 20, 8 << 20, 64 << 20  # room for no run, for some snapshots, for all
INSIDE = "MENISCUS_TEST_NAMESPACE"


def enter_namespace() -> bool:
    """Start this script again where mounts are its own; False where that is refused."""
    for unshare in (["unshare", "-m"], ["unshare", "-rm"]):
        if subprocess.run([*unshare, "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True).returncode == 0:
            os.environ[INSIDE] = "yes"
            os.execvp("unshare", [*unshare, sys.executable, *sys.argv])
    return False


def batch(out: Path, *more: str) -> "subprocess.CompletedProcess[str]":
    words = [BUILD / "meniscusd", "--batch", *CASE, "--out", out, "-o", "json", *more]
    return subprocess.run(words, env=DiskFull.environment, capture_output=True, text=True, timeout=120)


def series(directory: Path) -> dict[str, list[float]]:
    with h5py.File(directory / "probes.hdf") as file:
        columns = {"time": file["time"][:].tolist()}
        return columns | {name: data[:].tolist() for name, data in file["probes"].items()}


def names(directory: Path) -> list[str]:
    return sorted(path.name for path in directory.glob("snapshot-*.hdf"))


class DiskFull(DaemonTest):
    """The state directory of the daemon and of batch runs is on the small disk; `undisturbed` is a run with room."""

    undisturbed: dict[str, Any]
    room: Path
    disk: Path

    @classmethod
    def setUpClass(cls) -> None:
        if INSIDE not in os.environ:
            raise unittest.SkipTest("this user may not mount a file system of its own")
        scratch = tempfile.TemporaryDirectory(prefix="mns-disk-")
        cls.addClassCleanup(scratch.cleanup)
        cls.disk = Path(scratch.name)
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={SMALL_BYTES}", "none", cls.disk], check=True)
        cls.addClassCleanup(lambda: subprocess.run(["umount", cls.disk], check=True))
        super().setUpClass()
        cls.room = cls.home / "undisturbed"
        done = batch(cls.room)
        assert done.returncode == 0, done.stderr
        cls.undisturbed = json.loads(done.stdout)

    @classmethod
    def start_daemon(cls) -> None:
        os.symlink(cls.disk, cls.home / "state")
        super().start_daemon()

    def resize(self, size: int) -> None:
        subprocess.run(["mount", "-o", f"remount,size={size}", self.disk], check=True)

    def fill(self, free: int) -> Path:
        """A file that leaves so many bytes of the disk."""
        filler = self.disk / "filler"
        self.addCleanup(filler.unlink, missing_ok=True)
        with contextlib.suppress(OSError):  # the daemon may just have written something
            filler.write_bytes(bytes(shutil.disk_usage(self.disk).free - free))
        return filler

    def clear(self, directory: Path) -> None:
        self.addCleanup(shutil.rmtree, directory, ignore_errors=True)

    def assert_whole(self, directory: Path) -> None:
        """Every file with a final name opens; nothing unfinished is left."""
        self.assertEqual(list(directory.rglob("*.tmp")), [])
        for path in directory.glob("*.hdf"):
            with h5py.File(path) as file:
                self.assertTrue(list(file))

    def assert_complete(self, directory: Path) -> None:
        self.assert_whole(directory)
        self.assertEqual(len(names(directory)), SNAPSHOTS)
        self.assertEqual(names(directory), names(self.room))
        self.assertEqual(len(series(directory)["time"]), ROWS)
        self.assertEqual(series(directory), series(self.room))

    def disturbed_batch(self, *more: str) -> None:
        """Run until the disk is full, make room, go on: nothing may be missing."""
        out = self.disk / "batch"
        self.resize(SMALL_BYTES)
        self.clear(out)
        done = batch(out, *more)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertEqual(done.stderr.count("fault: cannot write"), 1, done.stderr)
        self.assertEqual(done.stderr.count("cannot"), 1, done.stderr)
        self.assertNotIn("lost: ", done.stderr)
        self.assertIn("No space left on device", done.stderr)
        self.assertIn(str(out), done.stderr)
        told = json.loads(done.stdout)
        self.assertEqual(told["state"], "FAULT")
        self.assertTrue((out / f"checkpoint-{told['steps']:010d}.hdf").exists())
        self.assert_whole(out)
        self.assertIn(len(names(out)), range(2, SNAPSHOTS))
        self.resize(LARGE_BYTES)
        done = batch(out, *more, "--resume", "auto")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["state_hash"], self.undisturbed["state_hash"])
        self.assert_complete(out)
        shutil.rmtree(out)

    def test_a_batch_run_keeps_its_state_and_goes_on_once_there_is_room(self) -> None:
        for more in ([], ["--set", "output.checkpoint_interval=0.1"]):
            with self.subTest(more=more):
                self.disturbed_batch(*more)

    def test_a_run_that_could_not_keep_its_state_is_refused(self) -> None:
        out = self.disk / "batch"
        self.resize(TINY_BYTES)
        self.clear(out)
        done = batch(out)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertRegex(done.stderr, r"cannot keep \d+ kB free.* in '.*batch': No space left on device; make room")
        self.assertFalse(out.exists())

    def disturbed_run(self, free: int) -> None:
        """Run into a disk with so many bytes left, make room, go on: nothing may be missing."""
        self.resize(LARGE_BYTES)
        directory = Path(self.ask("load", *CASE)["message"])
        self.clear(directory)
        filler = self.fill(free)
        subprocess.run([BUILD / "meniscus", "start"], env=self.environment, capture_output=True, timeout=60)
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        status = self.ask("status")
        self.assertEqual((status["state"], status["fault_reason"]), ("FAULT", "no space"))
        self.assertIn("No space left on device", status["fault"])
        self.assertEqual(len(self.ask("query", "probes", "front")["values"]), 1)
        self.assert_whole(directory)
        self.assertIn("No space left", self.meniscus("resume", code=74).stderr)
        self.assertEqual(self.ask("status")["state"], "FAULT")
        filler.unlink()
        self.meniscus("resume")
        self.meniscus("wait", "--for", "state=DONE", "--timeout", "60")
        self.assertEqual(self.ask("status")["state_hash"], self.undisturbed["state_hash"])
        self.assert_complete(directory)
        self.meniscus("stop")

    def test_the_daemon_waits_for_room_and_nothing_is_lost(self) -> None:
        for free in (300_000, 1_000_000, 4_000_000):
            with self.subTest(free=free):
                self.disturbed_run(free)

    def test_files_are_answered_for_on_a_full_disk_and_are_in_the_journal(self) -> None:
        """The rows of the series fail before the file that was asked for; the next checkpoint has room that was kept for it."""
        self.resize(LARGE_BYTES)
        directory = Path(self.ask("load", *CASE, "--set", "output.snapshot_interval=0")["message"])
        self.clear(directory)
        self.meniscus("step", "30")
        filler = self.fill(0)
        self.meniscus("step", "20")
        self.assertIn("No space left", self.meniscus("checkpoint", "--timeout", "60", code=74).stderr)
        self.assertEqual(self.ask("status")["state"], "FAULT")
        self.meniscus("snapshot", "--timeout", "60", code=1)
        self.meniscus("checkpoint", "--timeout", "60")
        self.assertTrue((directory / "checkpoint-0000000050.hdf").exists())
        filler.unlink()
        self.meniscus("resume")
        self.meniscus("pause")
        done = [record["command"] for record in self.ask("log", str(directory))["records"] if record["kind"] == "command"]
        self.assertEqual(done, ["load", "step", "step", "checkpoint", "resume", "pause"])
        self.assertTrue(self.ask("replay", str(directory), "--verify")["agrees"])
        self.meniscus("stop")

    def test_a_way_back_that_the_disk_holds_up_goes_on_by_resume(self) -> None:
        self.resize(LARGE_BYTES)
        directory = Path(self.ask("load", *CASE)["message"])
        self.clear(directory)
        filler = self.fill(1_000_000)
        subprocess.run([BUILD / "meniscus", "start"], env=self.environment, capture_output=True, timeout=60)
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        self.meniscus("set", "gravity=[0, -2]")
        before = self.ask("status")
        self.daemon.kill()
        self.daemon.wait()
        super().start_daemon()
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        held = self.ask("status")
        self.assertLess(held["step"], before["step"])
        self.assertIn("not back where it was", held["fault"])
        self.assertIn("make room and resume", self.meniscus("set", "gravity=[0, -3]", code=1).stderr)
        self.meniscus("resume", code=74)
        self.meniscus("load", "nowhere.yaml", code=65)
        self.meniscus("load", *CASE, "--name", "beside", code=74)  # for which there is no room either
        self.assertEqual(self.ask("status")["fault"], held["fault"])
        filler.unlink()
        self.meniscus("resume")
        self.meniscus("wait", "--for", f"step={before['step'] + 1}", "--timeout", "60")
        self.meniscus("wait", "--for", "state=DONE", "--timeout", "60")
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -2]")
        self.assert_whole(directory)
        self.assertEqual(len(names(directory)), SNAPSHOTS)
        self.assertTrue(self.ask("replay", str(directory), "--verify")["agrees"])
        self.meniscus("stop")

    def test_a_snapshot_at_the_end_of_the_way_back_is_waited_for(self) -> None:
        """It was asked for by hand, and nothing is computed or written behind it."""
        self.resize(LARGE_BYTES)
        quiet = ["--set", "probes=[]", "--set", "output.snapshot_interval=0", "--set", "output.checkpoint_wall_interval=0", "--set", "end_time=100"]
        directory = Path(self.ask("load", *CASE, *quiet, "--name", "shown-last")["message"])
        self.clear(directory)
        self.meniscus("step", "10")
        self.meniscus("checkpoint")
        self.meniscus("step", "600", timeout=120)
        shown = Path(self.ask("snapshot")["path"])
        self.daemon.kill()
        self.daemon.wait()
        super().start_daemon()
        while self.ask("status")["state"] != "RECOVERING":
            pass
        filler = self.fill(20_000)
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        self.assertFalse(shown.exists())
        self.assertIn(shown.name, self.ask("status")["fault"])
        self.meniscus("resume", code=74)
        filler.unlink()
        self.meniscus("resume")
        self.meniscus("pause")
        self.assertTrue(shown.exists())
        self.assert_whole(directory)
        self.assertTrue(self.ask("replay", str(directory), "--verify")["agrees"])
        self.meniscus("stop")

    def test_a_scheduled_file_behind_one_that_failed_waits_and_the_journal_has_it(self) -> None:
        self.resize(LARGE_BYTES)
        directory = Path(self.ask("load", *CASE, "--set", "output.snapshot_interval=1e-9")["message"])
        self.clear(directory)
        self.meniscus("step", "3")
        words = [BUILD / "meniscus", "snapshot", "--at-step", "4"]
        waiting = subprocess.Popen(words, env=self.environment, stderr=subprocess.DEVNULL)
        self.addCleanup(waiting.kill)
        while not self.ask("status").get("scheduled"):
            self.assertIsNone(waiting.poll())
        filler = self.fill((directory / names(directory)[0]).stat().st_size // 2)  # so that the file of step 4 fails late
        subprocess.run([BUILD / "meniscus", "step"], env=self.environment, capture_output=True, timeout=60)
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        self.assertIsNone(waiting.poll(), "what is scheduled for step 4 is neither written nor answered")
        self.assertEqual(len(self.ask("status")["scheduled"]), 1)
        filler.unlink()
        self.meniscus("resume")
        self.assertEqual(waiting.wait(60), 0)
        records = [r for r in self.ask("log", str(directory))["records"] if r.get("command") == "snapshot"]
        self.assertEqual([(r["kind"], r["step"]) for r in records], [("scheduled", 3), ("command", 4)])
        self.meniscus("stop")

    def test_a_command_without_room_for_its_record_is_refused_and_nothing_is_done(self) -> None:
        self.resize(LARGE_BYTES)
        directory = Path(self.ask("load", *CASE)["message"])
        self.clear(directory)
        filler = self.fill(0)
        accepted = 1.0
        for k in range(1000):  # until the room that the journal had taken before is used up
            words = [BUILD / "meniscus", "set", f"end_time={k + 2}"]
            done = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=60)
            if done.returncode:
                break
            accepted = float(k + 2)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn("cannot make room in", done.stderr)
        self.assertEqual(float(self.ask("get", "end_time")["values"]["end_time"]["value"]), accepted)
        self.assertEqual(self.ask("status")["state"], "READY")
        self.meniscus("step", code=74)
        self.meniscus("pause")
        filler.unlink()
        self.meniscus("set", "end_time=0.4")
        self.meniscus("step", "3")
        self.assertEqual(self.ask("log", str(directory))["error"], None)
        self.assertTrue(self.ask("replay", str(directory), "--verify")["agrees"])
        self.meniscus("stop")


if __name__ == "__main__":
    if INSIDE not in os.environ:
        enter_namespace()
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Pipes, directories and devices in the places of files: nothing waits for them, and what is missing for them is said."""

import os
import shutil
import signal
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, start_in, surroundings  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=8", "--set", "threads=1", "--set", "output.snapshot_interval=0.01",
        "--set", "output.probe_interval=0.01"]  # fmt: skip
NO_LOG = "there is no log of this run: "


class OddFiles(DaemonTest):
    def batch(self, out: Path, until: float, *more: str, code: int = 0) -> str:
        """What a run says; it takes a fraction of the time that it has."""
        return self.meniscus("run", *CASE, "--until", str(until), "--out", str(out), *more, code=code, timeout=20).stderr

    def test_a_log_that_is_no_file_is_said_once_and_the_run_goes_on(self) -> None:
        kinds: "tuple[tuple[Callable[[Path], object], str], ...]" = (
            (os.mkfifo, "is a pipe"),
            (lambda path: path.mkdir(), "is a directory"),
            (lambda path: path.symlink_to("/dev/full"), "is a link to '/dev/full', which is a device"),
        )
        for k, (make, found) in enumerate(kinds):
            with self.subTest(found):
                out = self.home / f"logged-{k}"
                out.mkdir()
                make(out / "log")
                for more in ([], ["--resume", "auto"], ["--overwrite"]):
                    said = self.batch(out, 0.005, *more)
                    self.assertEqual(said.count(f"{NO_LOG}'{out}/log' {found}; move it away"), 1, said)
                self.assertIn("whole", self.meniscus("log", str(out), "--verify").stdout)

    def test_a_log_that_is_a_link_to_a_file_is_written(self) -> None:
        out, there = self.home / "linked", self.home / "there.log"
        out.mkdir()
        (out / "log").symlink_to(there)
        self.assertNotIn("log", self.batch(out, 0.005))
        self.assertIn("ready: loaded", there.read_text())

    def test_a_log_that_lacks_lines_is_said_once(self) -> None:
        out, size = self.home / "short", 40000
        out.mkdir()
        (out / "log").write_bytes(b"x" * 1024 * size)
        done = subprocess.run(["bash", "-c", f'ulimit -f {size}; exec "$@"', "bash", BUILD / "meniscus", "run", *CASE, "--until", "0.005", "--out", out],
                              env=self.environment, capture_output=True, text=True, timeout=60)  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr.count("the log of this run lacks lines: cannot write '"), 1, done.stderr)

    def test_a_pipe_in_the_place_of_any_file_of_a_run_holds_nothing_up(self) -> None:
        whole = self.home / "whole"
        self.batch(whole, 0.02)
        refused = ("lock", "journal", "probes.hdf")
        for name in sorted(path.name for path in whole.iterdir() if path.is_file()):
            for end in ("", ".tmp"):
                out = self.home / f"piped-{name}{end}"
                shutil.copytree(whole, out)
                (out / f"{name}{end}").unlink(missing_ok=True)
                os.mkfifo(out / f"{name}{end}")
                with self.subTest(name + end):
                    said = self.batch(out, 0.03, "--resume", "auto", code=74 if name in refused and not end else 0)
                    if name in refused and not end:
                        self.assertIn(f"{out}/{name}' is no file", said)
                    self.meniscus("log", str(out), code=74 if (name, end) == ("journal", "") else 0, timeout=20)
        pipe = self.home / "snapshot.hdf"
        os.mkfifo(pipe)
        for words in (("export", str(pipe), "--out", f"{self.home}/table.csv"), ("render", str(pipe), "--out", f"{self.home}/picture.png")):
            self.assertIn("it is no file", self.meniscus(*words, code=74, timeout=20).stderr)

    def test_a_directory_that_another_run_has_by_now_is_left_to_it(self) -> None:
        out, away = self.home / "replaced", self.home / "away"
        words = [BUILD / "meniscus", "run", *CASE, "--set", "end_time=1000", "--set", "output.snapshot_interval=0.001", "--out", out]
        first = subprocess.Popen(words, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(first.kill)
        self.wait_until(lambda: any(out.glob("snapshot-*.hdf")))
        first.send_signal(signal.SIGSTOP)
        out.rename(away)
        self.batch(out, 0.02)
        before = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
        first.send_signal(signal.SIGCONT)
        said = first.communicate(timeout=60)[1]
        self.assertEqual(first.returncode, 74, said)
        self.assertIn(f"'{out}' is not the directory of this run any more", said)
        self.assertEqual({path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}, before)

    def test_a_run_whose_directory_is_not_its_own_any_more_is_halted_until_it_is_back(self) -> None:
        other, away = self.home / "other", self.home / "away-from-daemon"
        self.batch(other, 0.02)
        self.meniscus("load", *CASE, "--name", "owned", "--set", "end_time=1000")
        run = self.home / "state" / "owned"

        def removed() -> None:
            run.rename(away)

        def replaced() -> None:
            run.rename(away)
            shutil.copytree(other, run)

        def emptied() -> None:
            run.rename(away)
            run.mkdir()

        for take_away in (removed, replaced, emptied):
            with self.subTest(take_away.__name__):
                self.meniscus("step", "5")
                step = self.ask("status")["step"]
                take_away()
                for words in (("set", "output.probe_interval=0.02"), ("checkpoint",), ("restore",), ("reset",)):
                    self.assertRegex(self.meniscus(*words, code=74).stderr, f"'{run}(/journal)?' is not the (directory|journal) of this run")
                status = self.ask("status")
                self.assertEqual((status["state"], status["step"]), ("FAULT", step))
                self.assertIn("put it back", status["fault"])
                shutil.rmtree(run, ignore_errors=True)
                away.rename(run)
                self.meniscus("resume")
                self.meniscus("pause")
        self.meniscus("step", "5")
        self.assertIn("whole", self.meniscus("log", str(run), "--verify").stdout)
        (run / "journal").rename(self.home / "journal")
        os.mkfifo(run / "journal")
        self.assertIn("is not the journal of this run", self.meniscus("set", "output.probe_interval=0.03", code=74, timeout=20).stderr)
        self.meniscus("load", *CASE, "--name", "beside")  # the daemon takes commands
        self.meniscus("stop")

    def test_a_picture_is_not_written_into_a_pipe(self) -> None:
        out, picture = self.home / "drawn", self.home / "drawn.png"
        self.batch(out, 0.005)
        os.mkfifo(f"{picture}.part")
        said = self.meniscus("render", str(out / "snapshot-0000000000.hdf"), "--out", str(picture), code=74, timeout=20).stderr
        self.assertIn("drawn.png", said)
        self.assertFalse(picture.exists())

    def test_a_daemon_loads_into_a_directory_whose_log_is_a_pipe(self) -> None:
        run = Path(self.ask("load", *CASE, "--name", "b")["message"])
        self.meniscus("step", "2")
        self.meniscus("checkpoint")
        self.meniscus("stop")
        (run / "log").unlink()
        os.mkfifo(run / "log")
        self.meniscus("load", *CASE, "--name", "b", "--resume", timeout=20)
        self.assertEqual(self.ask("status")["state"], "READY")
        self.assertIn(f"{NO_LOG}'{run}/log' is a pipe", (self.home / "log").read_text())
        self.leave_and_come_back()
        self.meniscus("wait", "--for", "step=2", "--timeout", "60")

    def test_pipes_in_the_state_directory_do_not_hold_up_a_daemon(self) -> None:
        other = self.home / "other"
        (other / "state").mkdir(parents=True)
        environment = surroundings(other)
        os.mkfifo(other / "state" / "lock")
        done = subprocess.run([BUILD / "meniscusd", "--name", "other", "--state-dir", other / "state"], env=environment,
                              capture_output=True, text=True, timeout=20)  # fmt: skip
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn(f"{other}/state/lock' is no file", done.stderr)
        (other / "state" / "lock").unlink()
        os.mkfifo(other / "state" / "current.tmp")
        daemon = start_in(other, environment, [])
        subprocess.run([BUILD / "meniscus", "load", *CASE], env=environment, capture_output=True, timeout=20)
        daemon.terminate()
        self.assertEqual(daemon.wait(20), 0)


if __name__ == "__main__":
    unittest.main()

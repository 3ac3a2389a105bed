#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""What workflow managers rely on: exit codes, signals, one object as the schema says; and the examples for them do what they say.

Snakemake runs its example (package snakemake); where it is not there that test is skipped."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

import jsonschema
import matplotlib.image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, DaemonTest  # noqa: E402

HERE = ROOT / "client" / "workflows"
PYTHON = "/usr/bin/python3"
SCHEMA = json.loads((HERE / "run.schema.json").read_text())
SMALL = ["hydrostatic", "--set", "resolution=10", "--set", "threads=1", "--set", "end_time=0.02"]
# It falls from rest, so that it is denser than this soon, not at once.
WILD = ["dambreak2d", "--set", "resolution=8", "--set", "threads=1", "--set", "limits.density_max=1.0000001"]
LONG = ["hydrostatic", "--set", "resolution=20", "--set", "threads=1", "--set", "end_time=1000"]
SWEEP = {"RESOLUTIONS": "8 10", "SCHEMES": "riemann dissipation", "SETTINGS": "end_time=0.02 probes[0].name=first"}
RESULTS = [f"scheme~{s}/resolution~{r}.json" for s in ("dissipation", "riemann") for r in (8, 10)]


def wait_for(what: Any, seconds: float = 60) -> Any:
    """What it returns once that is true."""
    until = time.monotonic() + seconds
    while not (found := what()):
        if time.monotonic() > until:
            raise AssertionError("it did not come")
        time.sleep(0.01)
    return found


def end(process: "subprocess.Popen[str]") -> None:
    """What a failed test has left at work."""
    if process.poll() is None:
        process.terminate()
        process.communicate()


class Workflow(unittest.TestCase):
    """In a directory of its own, with the programs that were built."""

    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-workflow-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith(("SLURM_", "MAKE", "MFLAGS"))}
        self.environment |= {"MENISCUS": str(BUILD / "meniscus"), "MENISCUS_CASES": str(ROOT / "server" / "cases"),
                             "MENISCUS_WORKFLOWS": str(HERE), "OMP_WAIT_POLICY": "passive", "HOME": str(self.home),
                             "XDG_CACHE_HOME": str(self.home / "cache")}

    def start(self, *words: "str | Path") -> "subprocess.Popen[str]":
        # Into a file, as a pipe that nobody reads could fill up.
        with open(self.home / "errors", "w") as errors:
            process = subprocess.Popen([str(w) for w in words], env=self.environment, cwd=self.home, text=True,
                                       stdout=subprocess.PIPE, stderr=errors)
        self.addCleanup(end, process)
        return process

    def finish(self, process: "subprocess.Popen[str]", code: int) -> str:
        words, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, code, words + (self.home / "errors").read_text())
        return words

    def do(self, *words: "str | Path", code: int = 0) -> str:
        return self.finish(self.start(*words), code)

    def batch(self, *words: str) -> "list[str]":
        return [str(BUILD / "meniscus"), "run", *words, "-o", "json"]

    def job(self, name: str, *words: str, options: "tuple[str, ...]" = ()) -> "list[str]":
        return [PYTHON, str(HERE / "until_done.py"), *options, f"{name}.json", f"{name}.run", *words]

    def object_of(self, words: str) -> Any:
        """The only line, which must be as the schema says, and the schema must say all that is in it."""
        lines = words.splitlines()
        self.assertEqual(len(lines), 1, words)
        told = json.loads(lines[0])
        jsonschema.Draft202012Validator(SCHEMA).validate(told)
        if "state" in told:
            self.assertEqual(set(told), set(SCHEMA["$defs"]["run"]["properties"]))
        return told


class Contract(Workflow):
    def test_the_schema_is_one(self) -> None:
        jsonschema.Draft202012Validator.check_schema(SCHEMA)

    def test_every_end_has_its_exit_code_and_an_object_as_the_schema_says(self) -> None:
        for code, state, words in (
            (0, "DONE", [*SMALL, "--out", "done"]),
            (0, "PAUSED", [*SMALL, "--out", "until", "--until", "0.01"]),
            (65, "EMPTY", ["no-such-case"]),
            (65, "EMPTY", [*SMALL, "--set", "foo=1", "--out", "foo"]),
            (70, "FAULT", [*WILD, "--out", "wild"]),
            (74, "EMPTY", [*SMALL, "--out", "/dev/null/x"]),
            (2, None, [*SMALL, "--bogus"]),
        ):  # fmt: skip
            with self.subTest(words):
                told = self.object_of(self.do(*self.batch(*words), code=code))
                self.assertEqual(told.get("state"), state)
                self.assertEqual(told.get("exit_code", code), code)
                self.assertEqual(told["error"] is None, code == 0)

    def test_the_schema_refuses_what_is_not_so(self) -> None:
        told = self.object_of(self.do(*self.batch(*SMALL)))
        validator = jsonschema.Draft202012Validator(SCHEMA)
        error = {"status": "diverged", "message": "m", "path": "", "hint": "h", "exit_code": 70}
        for wrong in ({"state": "FINE"}, {"steps": -1}, {"state_hash": "12"}, {"exit_code": 3}, {"t": "0"}, {"probes": {"p": 1}},
                      {"error": error}, {"exit_code": 70}):  # fmt: skip
            self.assertFalse(validator.is_valid(told | wrong), wrong)
        self.assertFalse(validator.is_valid({key: value for key, value in told.items() if key != "outputs"}))

    def test_signals_ask_for_checkpoints_and_the_same_command_goes_on(self) -> None:
        command = self.batch(*LONG, "--out", "run", "--resume", "auto")
        run = self.start(*command)
        wait_for(lambda: list(self.home.glob("run/snapshot-*.hdf")))
        before = set(self.home.glob("run/checkpoint-*.hdf"))
        run.send_signal(signal.SIGUSR1)
        wait_for(lambda: set(self.home.glob("run/checkpoint-*.hdf")) - before)
        self.assertIsNone(run.poll(), "it goes on")
        busy = self.object_of(self.do(*command, code=75))
        self.assertEqual(busy["error"]["status"], "wrong state")
        run.terminate()
        first = self.object_of(self.finish(run, 75))
        self.assertEqual((first["state"], first["error"]["status"]), ("PAUSED", "interrupted"))
        self.assertTrue((self.home / f"run/checkpoint-{first['steps']:010d}.hdf").exists())
        # A deadline from outside: timeout(1).
        second = self.object_of(self.do("timeout", "--preserve-status", "1", *command, code=75))
        self.assertGreater(second["steps"], first["steps"])

    def test_what_is_done_is_told_again(self) -> None:
        command = self.batch(*SMALL, "--out", "run", "--resume", "auto")
        first, again = (self.object_of(self.do(*command)) for _ in range(2))
        for key in ("state", "t", "steps", "state_hash", "probes", "error", "exit_code"):
            self.assertEqual(again[key], first[key], key)

    def test_a_job_is_done_once_and_its_result_is_whole(self) -> None:
        command = self.job("a", *SMALL)
        self.do(*command)
        told = self.object_of(json.dumps(json.loads((self.home / "a.json").read_text())))
        self.assertEqual((told["state"], told["t"]), ("DONE", 0.02))
        shutil.rmtree(self.home / "a.run")
        self.do(*command)
        self.assertFalse((self.home / "a.run").exists(), "what is done is not done again")
        self.do(*self.job("b", *SMALL, "--set", "foo=1"), code=65)
        self.do(*self.job("c", *WILD), code=70)
        self.do(*self.job("d", *WILD, options=("--accept", "70")))
        self.assertEqual(json.loads((self.home / "d.json").read_text())["exit_code"], 70)
        self.assertEqual(sorted(p.name for p in self.home.glob("*.json*")), ["a.json", "d.json"])

    def test_a_job_that_is_told_to_leave_leaves_a_checkpoint_and_no_result(self) -> None:
        self.do(*self.job("late", *LONG, options=("--deadline", "1.2")), code=75)
        kept = set(self.home.glob("late.run/checkpoint-*.hdf"))
        self.assertTrue(kept)
        seen = set(self.home.glob("late.run/snapshot-*.hdf"))
        job = self.start(*self.job("late", *LONG))
        wait_for(lambda: set(self.home.glob("late.run/snapshot-*.hdf")) - seen)
        job.terminate()
        self.finish(job, 75)
        self.assertTrue(set(self.home.glob("late.run/checkpoint-*.hdf")) - kept)
        self.assertFalse((self.home / "late.run/abandoned").exists(), "it went on")
        self.assertEqual(list(self.home.glob("*.json*")), [])

    def test_a_run_whose_job_is_killed_leaves_too_and_the_next_one_goes_on(self) -> None:
        job = self.start(*self.job("killed", *LONG))
        wait_for(lambda: list(self.home.glob("killed.run/snapshot-*.hdf")))
        job.kill()
        self.finish(job, -signal.SIGKILL)
        self.do(*self.job("killed", *LONG, options=("--deadline", "1.2")), code=75)
        self.assertFalse((self.home / "killed.run/abandoned").exists())


class RequestId(DaemonTest):
    def test_a_load_under_an_id_happens_once(self) -> None:
        words = ["load", *LONG, "--name", "sweep-7", "--id", "0123456789abcdef0123456789abcde7"]
        first = self.ask(*words)
        self.assertEqual(self.ask(*words), first)
        go = ["start", "--id", "1123456789abcdef0123456789abcde7"]
        self.assertEqual(self.ask(*go), self.ask(*go))
        self.assertEqual([p.name for p in (self.home / "state").iterdir() if p.is_dir()], ["sweep-7"])


class Sweeps(Workflow):
    def states(self, directory: Path) -> "list[str]":
        return [json.loads((directory / name).read_text())["state"] for name in RESULTS]

    def check_report(self, directory: Path) -> None:
        self.assertEqual(self.states(directory), ["DONE"] * 4)
        lines = (directory / "report.md").read_text().splitlines()
        self.assertTrue(lines[0].startswith("| scheme | resolution | state | t |"), lines[0])
        rows = [line.strip("| ").split(" | ") for line in lines[2:]]
        self.assertEqual([row[:3] for row in rows],
                         [[s, r, "DONE"] for s in ("dissipation", "riemann") for r in ("8", "10")])
        table = (directory / "report.csv").read_text().splitlines()
        self.assertEqual(len(table), 5)

    def test_make_sweeps_once(self) -> None:
        command = ["make", "-s", "-j2", "-f", HERE / "Makefile", "OUT=out", *(f"{k}={v}" for k, v in SWEEP.items())]
        self.do(*command)
        self.check_report(self.home / "out")
        self.assertIn("| first |", (self.home / "out/report.md").read_text())
        self.do(command[0], "-q", *command[1:])  # there is nothing left to do
        (self.home / "out" / RESULTS[2]).unlink()
        self.do(*command)
        self.check_report(self.home / "out")

    def test_a_run_that_diverges_is_a_row_and_a_wrong_one_stops_no_other(self) -> None:
        command = ["make", "-s", "-k", "-f", HERE / "Makefile", "OUT=out", "RESOLUTIONS=8"]
        self.do(*command, "CASE=dambreak2d", "SCHEMES=riemann", "SETTINGS=limits.density_max=1.0000001")
        self.assertIn("| riemann | 8 | FAULT |", (self.home / "out/report.md").read_text())
        self.do(*command, "OUT=more", "SCHEMES=nonsense riemann", "SETTINGS=end_time=0.01", code=2)
        self.assertEqual([p.name for p in self.home.glob("more/*/*.json")], ["resolution~8.json"])

    def test_a_sweep_that_is_stopped_in_the_morning_goes_on_in_the_evening(self) -> None:
        command = ["timeout", "600", "make", "-k", "-j2", "-f", HERE / "Makefile", "OUT=.", "RESOLUTIONS=20", "SCHEMES=riemann dissipation",
                   "SETTINGS=end_time=1000 output.checkpoint_interval=0.02"]  # fmt: skip
        newest = ["", ""]

        def found() -> "list[str]":
            return [max((p.name for p in self.home.glob(f"scheme~{s}/*.run/checkpoint-*")), default="") for s in ("riemann", "dissipation")]

        for _ in range(2):
            stopped = self.start(*command)
            wait_for(lambda: all(now > before for now, before in zip(found(), newest)), 400)
            stopped.terminate()  # and with it all whom it started
            self.finish(stopped, -signal.SIGTERM)
            newest = found()  # with those that were written on leaving
        self.assertEqual(list(self.home.glob("*/*.run/abandoned")), [], "none began anew")
        self.assertEqual(list(self.home.glob("*/*.json")), [])

    @unittest.skipUnless(shutil.which("snakemake"), "needs the package snakemake")
    def test_snakemake_sweeps_and_draws(self) -> None:
        command = ["snakemake", "--cores", "2", "--snakefile", HERE / "Snakefile", "--directory", self.home / "out", "--config",
                   "probe=kinetic", *(f"{k.lower()}={v}" for k, v in SWEEP.items())]
        self.do(*command)
        self.check_report(self.home / "out")
        picture = matplotlib.image.imread(self.home / "out/report.png")[:, :, :3]
        self.assertGreater((picture.min(axis=2) < 0.9).mean(), 0.01, "something is drawn")

    @unittest.skipUnless(shutil.which("snakemake"), "needs the package snakemake")
    def test_a_snakemake_that_was_killed_goes_on_when_it_is_unlocked(self) -> None:
        command = ["snakemake", "--cores", "1", "--snakefile", HERE / "Snakefile", "--directory", self.home / "out"]
        config = ["--config", "probe=kinetic", *(f"{k.lower()}={v}" for k, v in SWEEP.items())]
        errors = open(self.home / "errors", "w")
        self.addCleanup(errors.close)
        killed = subprocess.Popen(
            [str(w) for w in (*command, *config)], env=self.environment, cwd=self.home, start_new_session=True, stdout=errors, stderr=errors
        )
        wait_for(lambda: list(self.home.glob("out/*/*.run/journal")) or killed.poll() is not None)
        os.killpg(killed.pid, signal.SIGKILL)  # with its jobs, as a power cut does
        self.assertEqual(killed.wait(), -signal.SIGKILL)
        self.do(*command, "--rerun-incomplete", *config, code=1)
        self.assertIn("--unlock", (self.home / "errors").read_text())
        self.do(*command, "--unlock", *config)
        self.do(*command, "--rerun-incomplete", *config)
        self.check_report(self.home / "out")

    def test_a_slurm_job_that_runs_out_of_time_goes_back_in_line(self) -> None:
        fake = self.home / "bin"
        fake.mkdir()
        (fake / "scontrol").write_text('#!/bin/sh\necho "scontrol $*"\n')
        (fake / "scontrol").chmod(0o755)
        self.environment |= SWEEP | {"PATH": f"{fake}:{self.environment['PATH']}", "SLURM_JOB_ID": "71", "SLURM_ARRAY_TASK_ID": "3",
                                     "SETTINGS": "end_time=1000"}
        directory = self.home / "scheme~dissipation/resolution~10.run"
        job = self.start("bash", HERE / "slurm.sh")
        wait_for(lambda: list(directory.glob("snapshot-*.hdf")))
        job.send_signal(signal.SIGUSR1)
        words = self.finish(job, 0)
        self.assertIn("exit code 75", words)
        self.assertIn("scontrol requeue 71", words)
        self.assertTrue(list(directory.glob("checkpoint-*.hdf")))
        seen = set(directory.glob("snapshot-*.hdf"))
        job = self.start("bash", HERE / "slurm.sh")
        wait_for(lambda: set(directory.glob("snapshot-*.hdf")) - seen)
        job.terminate()
        self.assertNotIn("requeue", self.finish(job, 75))
        self.environment |= {"SLURM_ARRAY_TASK_ID": "0", "SETTINGS": "end_time=0.01"}
        self.do("bash", HERE / "slurm.sh")
        self.assertTrue((self.home / "scheme~riemann/resolution~8.json").exists())
        self.environment["SLURM_ARRAY_TASK_ID"] = "4"
        self.do("bash", HERE / "slurm.sh", code=2)


if __name__ == "__main__":
    unittest.main()

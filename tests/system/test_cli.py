#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The command line against a real daemon: what scripts rely on."""

import csv
import json
import os
import pty
import pwd
import re
import signal
import subprocess
import sys
import tempfile
import termios
import time
import unittest
from pathlib import Path
from socket import gethostname
from typing import Any
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, SMALL, DaemonTest  # noqa: E402

CASES = ROOT / "server" / "cases"



def documented(command: str) -> "set[str]":
    """The keys that client/README.md promises scripts of a command."""
    rows = re.findall(r"^\| ([^|]+) \| (.*) \|$", (ROOT / "client" / "README.md").read_text(), re.MULTILINE)
    keys = {name: text for names, text in rows for name in names.split(", ")}
    text = keys[command] + " " + (keys["load"] if keys[command].startswith("the same") else "")
    return set(re.findall("[a-z_]+", text))


REPLY = {"state", "step", "time", "effect_step", "daemon_epoch", "message", "case_version"}
STATUS = set(
    "state case title run_directory fault fault_reason version time end_time time_step eta_s wall_s steps_per_second "
    "ns_per_particle_step step particles fluid_particles guarded uncorrected energy_excess samples_dropped memory_bytes threads state_hash timers "
    "breakpoints scheduled case_version recovery_step lease_holder lease_s streams".split()
)


def read_to_the_end(terminal: int) -> bytes:
    """What is written to it until nobody has its other end; it is closed then."""
    text = b""
    try:
        while chunk := os.read(terminal, 65536):
            text += chunk
    except OSError:  # what Linux says when the other end is closed
        pass
    os.close(terminal)
    return text


class Commands(DaemonTest):
    def load(self, *more: str) -> dict:
        return self.ask("load", *SMALL, *more)

    def test_a_case_is_loaded_stepped_and_stopped(self) -> None:
        self.assertEqual(self.load()["state"], "READY")
        reply = self.ask("step", "5")
        self.assertEqual((reply["state"], reply["step"]), ("PAUSED", 5))
        self.assertEqual(self.ask("stop")["state"], "EMPTY")

    def test_a_daemon_that_was_started_in_the_line_before_is_waited_for(self) -> None:
        self.listen_late()
        self.meniscus("status")

    def test_every_reply_has_the_documented_keys(self) -> None:
        self.assertEqual(set(self.load()), REPLY | {"path"})
        self.assertEqual(set(self.ask("status")), STATUS)
        self.assertEqual(set(self.ask("step")), REPLY)
        self.assertEqual(set(self.ask("get", "end_time")), REPLY | {"values"})
        self.assertEqual(set(self.ask("query")), REPLY | {"values"})
        self.assertEqual(set(self.ask("checkpoint")), REPLY | {"path"})
        lease = self.ask("lease")
        self.assertEqual(set(lease), REPLY | {"lease_epoch", "lease_s"})
        self.ask("lease", "release", "--lease", str(lease["lease_epoch"]))

    def test_every_key_that_is_printed_is_documented(self) -> None:
        directory = Path(self.load()["path"])
        self.meniscus("step", "3")
        for words in (
            ["step"], ["run-until", "0.01"], ["set", "end_time=3"], ["rollback", "1"], ["get", "end_time"], ["query", "probes", "front"],
            ["query", "at", "pressure", "1,1"], ["query", "box"], ["checkpoint"], ["wait", "--for", "step=1"],
            ["status"], ["capabilities"], ["schemes"], ["ls"], ["top", "--once"], ["breakpoint", "b", "--step", "99"], ["help"],
            ["export", str(directory / "probes.hdf"), "--out", str(self.home / "probes.csv")],
            ["render", "--field", "pressure", "--out", str(self.home / "p.png")],
        ):
            command = " ".join(words[:2]) if words[0] == "query" else words[0]
            answer = self.ask(*words)
            for row in [answer, *answer.get("daemons", [])]:
                self.assertLessEqual(set(row), documented(command), words)
        lease = self.ask("lease")
        for answer in (lease, self.ask("lease", "release", "--lease", str(lease["lease_epoch"]))):
            self.assertLessEqual(set(answer), documented("lease"))

    def test_what_another_scheme_has_cannot_be_set_and_is_not_listed(self) -> None:
        self.load()
        for listed in (set(self.ask("get")["values"]), {entry["name"] for entry in self.ask("capabilities")["parameters"]}):
            self.assertIn("scheme.riemann.limiter", listed)
            self.assertEqual({name for name in listed if re.match(r"scheme\.(dissipation|interfacial|incompressible|differences)\.", name)}, set())
        for wrong in ("scheme.dissipation.delta=0.1", "scheme.dissipation={}"):
            said = self.meniscus("set", wrong, code=1).stderr
            self.assertIn('the run has "riemann" instead of "dissipation", and keeps it: load a case that has "dissipation"', said)
        self.meniscus("stop")
        self.assertIn("scheme.dissipation.delta", {entry["name"] for entry in self.ask("capabilities")["parameters"]})

    def test_every_command_has_its_row_of_keys(self) -> None:
        for command in self.ask("help")["commands"]:
            if command["name"] not in ("keys", "query"):  # whose words have rows
                self.assertTrue(documented(command["name"]))

    def test_the_run_directory_is_the_path_of_whatever_begins_or_ends_a_run(self) -> None:
        loaded = self.load("--start")
        self.assertEqual(loaded["state"], "RUNNING")
        directory = loaded["path"]
        self.assertEqual(directory, self.ask("status")["run_directory"])
        self.meniscus("pause")
        self.meniscus("checkpoint")
        for command in ("reset", "stop"):
            self.assertEqual(self.ask(command)["path"], directory)
        self.assertIn(f": {self.load()['path']}\n", self.meniscus("stop").stdout)

    def test_the_step_that_is_printed_is_that_of_the_file_and_of_the_end(self) -> None:
        directory = Path(self.load("--start")["path"])
        self.meniscus("wait", "--for", "step=3")
        for command in ("snapshot", "checkpoint"):
            text = self.meniscus(command).stdout
            printed, named = re.findall(r"step (\d+)", text) + re.findall(r"-(\d+)\.hdf", text)
            self.assertEqual(int(printed), int(named), text)
        text = self.meniscus("stop", "--checkpoint").stdout
        step = re.match(r"EMPTY, stopped at step (\d+), t = ", text)
        assert step, text
        self.assertTrue((directory / f"checkpoint-{int(step[1]):010}.hdf").exists(), text)
        self.assertRegex((directory / "log").read_text().splitlines()[-1], rf" step {step[1]} t .* stopped: on request$")

    def test_what_has_no_effect_has_no_step_of_it(self) -> None:
        self.load()
        self.meniscus("step", "2")
        self.assertIsNone(self.ask("get", "end_time")["effect_step"])
        self.assertEqual(self.ask("set", "end_time=3")["effect_step"], 2)

    def test_run_until_ends_exactly_there(self) -> None:
        self.load()
        self.assertEqual(self.ask("run-until", "0.05")["time"], 0.05)

    def test_set_is_seen_by_get_and_all_or_nothing(self) -> None:
        self.load()
        self.meniscus("set", "end_time=3", "gravity=[0,-1.5]")
        values = self.ask("get", "end_time", "gravity")["values"]
        self.assertEqual(values["end_time"], {"value": 3.0, "unit": "s"})
        self.assertIn("-1.5", values["gravity"]["value"])
        used = self.ask("set", "threads=1000")
        self.assertEqual(used["message"], f"of 1000 threads asked for, {self.ask('status')['threads']} are used")
        self.assertIn(used["message"], self.meniscus("set", "threads=1000").stdout)
        self.assertEqual(self.ask("set", "threads=1")["message"], "")
        refused = self.meniscus("set", "end_time=4", "scheme.cfl=99", code=1)
        self.assertIn("meniscus: scheme.cfl: ", refused.stderr)
        self.assertEqual(self.ask("get", "end_time")["values"]["end_time"]["value"], 3.0)

    def test_what_cannot_be_set_is_told_with_what_can(self) -> None:
        self.load()
        done = self.meniscus("set", "resolution=10", code=1)
        self.assertRegex(done.stderr, r"resolution: cannot change while the simulation runs; allowed: gravity, .*, and \d+ more \(`meniscus get` lists all\)\n$")

    def test_a_number_without_a_unit_is_printed_without_one(self) -> None:
        self.load()
        self.assertRegex(self.meniscus("query", "probes", "escaped").stdout, r"^escaped = 0\n$")
        self.assertRegex(self.meniscus("get", "scheme.cfl").stdout, r"^scheme.cfl = 0.25\n$")
        self.assertEqual(self.ask("query", "probes", "escaped")["values"]["escaped"]["unit"], "1")

    def test_whoever_may_not_is_told_what_helps(self) -> None:
        self.load("--start")
        for command in ("start", "resume"):
            refused = self.meniscus(command, code=1).stderr
            self.assertIn("it runs already", refused)
            self.assertNotIn("pause it first", refused)
        self.assertIn("cannot run-until while RUNNING", self.meniscus("run-until", "1", code=1).stderr)
        self.assertIn("`meniscus query probes front`", self.meniscus("query", "front", code=2).stderr)
        self.assertIn("--for time=-1: a time to wait for is 0 s or more", self.meniscus("wait", "--for", "time=-1", code=2).stderr)

    def test_capabilities_are_named_where_they_know_the_name(self) -> None:
        self.load()
        self.assertIn("`meniscus capabilities`", self.meniscus("query", "probes", "fron", code=1).stderr)
        for words in (["restore", "nosuch"], ["rollback", "99"], ["export", "nosuch.hdf"]):
            done = self.meniscus(*words, code=74 if words[0] == "export" else 1)
            self.assertNotIn("capabilities", done.stderr, words)

    def test_a_file_that_is_not_there_has_one_exit_code(self) -> None:
        for words in (["export", "no.hdf", "--out", "x.csv"], ["render", "no.hdf", "--out", "x.png"], ["log", "no"], ["replay", "no", "--verify"]):
            self.meniscus(*words, code=74)
            object = json.loads(self.meniscus(*words, "-o", "json", code=74).stdout)
            self.assertEqual(object["error"]["exit_code"], 74, words)
            self.assertNotIn("capabilities", object["error"]["hint"], words)

    def test_a_name_that_is_not_there_is_answered_with_the_likeliest(self) -> None:
        self.load()
        for words in (["snapshot", "--fields", "presure"], ["query", "at", "presure", "0,0"], ["query", "box", "0,0", "1,1", "--fields", "presure"],
                      ["stream", "fields", "presure", "--count", "1"]):  # fmt: skip
            error = self.meniscus(*words, code=1).stderr
            self.assertIn('there is no field "presure" in this simulation; did you mean "pressure"? Allowed: ', error, words)
        for words in (["query", "probes", "fron"], ["stream", "probes", "fron", "--count", "1"]):
            self.assertIn('no probe "fron"; did you mean "front"? Allowed: P05, ', self.meniscus(*words, code=1).stderr, words)
        probe = "probes[0]={name: a, extremum: {field: presure}}"
        self.assertRegex(self.meniscus("run", *SMALL, "--set", probe, code=65).stderr, 'did you mean "pressure"?.* more .`meniscus capabilities` lists all')
        self.assertIn("`meniscus completion cases` lists all", self.meniscus("run", "nosuch", code=65).stderr)

    def test_a_daemon_that_cannot_be_named_is_wrong_usage(self) -> None:
        for name in ("a/b", "tcp://127.0.0.1"):
            self.meniscus("status", "--daemon", name, code=2)

    def test_set_does_not_disturb_the_files_that_are_written_later(self) -> None:
        self.load("--set", "output.probe_interval=0.002")
        self.meniscus("set", "end_time=3")
        self.assertEqual(self.ask("step", "10")["step"], 10)
        self.assertTrue(Path(self.ask("checkpoint")["path"]).is_file())
        self.assertTrue(Path(self.ask("snapshot")["path"]).is_file())

    def test_probes_points_and_particles_can_be_asked_for(self) -> None:
        self.load()
        self.meniscus("step", "3")
        self.assertEqual(set(self.ask("query", "probes", "P05", "front")["values"]), {"P05", "front"})
        points = self.ask("query", "at", "pressure", "0.5,0.5", "-9,9")
        self.assertEqual(points["unit"], "Pa")
        self.assertEqual(len(points["values"]), 2)
        self.assertIsNone(points["values"][1])
        box = self.ask("query", "box", "0,0", "0.2,0.1", "--fields", "position,phase")
        self.assertEqual(len(box["fields"]["position"]["values"]), box["particles"])
        for x, y in box["fields"]["position"]["values"]:
            self.assertTrue(0 <= x <= 0.2 and 0 <= y <= 0.1)
        self.meniscus("query", "box", "--limit", "5", code=1)

    def test_a_daemon_is_drawn_as_its_snapshot_is(self) -> None:
        self.load()
        snapshot = self.ask("snapshot", "--fields", "pressure,density,phase")["path"]
        pictures = [self.home / "live.png", self.home / "file.png"]
        self.assertEqual(self.ask("render", "--field", "pressure", "--out", str(pictures[0]))["field"], "pressure")
        self.meniscus("render", snapshot, "--field", "pressure", "--out", str(pictures[1]))
        self.assertEqual(pictures[0].read_bytes(), pictures[1].read_bytes())

    def test_a_checkpoint_is_restored_to_the_bit(self) -> None:
        self.load()
        self.meniscus("step", "4")
        before = self.ask("status")["state_hash"]
        name = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("step", "4")
        self.assertNotEqual(self.ask("status")["state_hash"], before)
        self.assertEqual(self.ask("restore", name)["step"], 4)
        self.assertIn(re.sub("[0-9]+", "0000000100", name), self.meniscus("help", "restore").stdout)
        for nothing in ("", "..", "a/b"):
            self.assertIn("a checkpoint is named by its file", self.meniscus("restore", nothing, code=1).stderr)
        self.assertEqual(self.ask("status")["state_hash"], before)

    def test_wait_comes_back_when_the_run_is_done(self) -> None:
        self.load("--set", "end_time=0.1", "--start")
        self.assertEqual(self.ask("wait", "--for", "state=DONE", "--timeout", "60")["state"], "DONE")
        self.meniscus("wait", "--for", "step=1000000000", "--timeout", "5", code=1)

    def test_a_step_that_is_past_need_not_be_waited_for(self) -> None:
        self.load()
        self.assertEqual(self.ask("wait", "--for", "step=0", "--timeout", "5")["step"], 0)
        self.meniscus("step", "3")
        for step in ("0", "3"):
            self.assertEqual(self.ask("wait", "--for", f"step={step}", "--timeout", "5")["step"], 3)

    def test_watch_gives_up_in_time(self) -> None:
        """Even while it waits for an answer, and for as long as the machine's clock says."""
        self.load()
        words = [BUILD / "meniscus", "watch", "--timeout"]
        with subprocess.Popen([*words, "8"], env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as watch:
            assert watch.stdout
            watch.stdout.readline()  # it has begun, and so has its time
            watch.send_signal(signal.SIGSTOP)
            time.sleep(8)
            watch.send_signal(signal.SIGCONT)
            began = time.monotonic()
            self.assertEqual(watch.wait(timeout=60), 124)
            self.assertLess(time.monotonic() - began, 7)  # it would take eight by its own clock, and takes none
        began = time.monotonic()
        with subprocess.Popen([*words, "6"], env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as watch:
            assert watch.stdout
            watch.stdout.readline()
            self.daemon.send_signal(signal.SIGSTOP)
            try:
                self.assertEqual(watch.wait(timeout=60), 124)
                self.assertGreaterEqual(time.monotonic() - began, 6)
            finally:
                self.daemon.send_signal(signal.SIGCONT)

    def test_a_step_that_a_stop_ends_is_not_to_be_repeated_blindly(self) -> None:
        self.load()
        words = [BUILD / "meniscus", "step", "1000000", "-o", "json"]
        with subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=self.environment
        ) as stepping:
            self.meniscus("wait", "--for", "step=3", "--timeout", "60")
            self.meniscus("stop")
            error = json.loads(stepping.communicate(timeout=60)[0])["error"]
        self.assertEqual((stepping.returncode, error["status"]), (75, "interrupted"))
        self.assertIn("if it is still wanted", error["hint"])

    def test_wait_gives_up_in_time(self) -> None:
        self.load()
        began = time.monotonic()
        done = self.meniscus("wait", "--for", "state=DONE", "--timeout", "0.3", code=124)
        self.assertLess(time.monotonic() - began, 10)
        self.assertIn("What to do: allow more time, or see with `meniscus status` how far it is.", done.stderr)

    def test_a_diverged_run_has_an_exit_code_of_its_own(self) -> None:
        self.load("--set", "limits.density_max=1.0000001", "--start")
        done = self.meniscus("wait", "--timeout", "60", code=70)
        self.assertIn("FAULT", done.stderr)
        self.meniscus("watch", code=70)
        self.assertEqual(self.ask("status")["fault_reason"], "diverged")
        self.meniscus("reset")
        self.meniscus("step", "100", code=70)

    def test_a_breakpoint_pauses_the_run(self) -> None:
        self.load()
        self.meniscus("breakpoint", "b", "--step", "7")
        self.meniscus("start")
        self.assertEqual(self.ask("wait", "--for", "state=PAUSED", "--timeout", "60")["step"], 7)
        self.assertIn("--step 0", self.meniscus("breakpoint", "b", "--step", "0", code=2).stderr)
        self.assertEqual(len(self.ask("status")["breakpoints"]), 1)
        self.meniscus("breakpoint", "b", "--remove")
        self.assertEqual(self.ask("status")["breakpoints"], [])

    def test_there_is_one_object_whatever_the_bytes_of_a_name(self) -> None:
        """Names of files are bytes, and JSON is UTF-8."""
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            bad = os.fsencode(scratch) + b"/caf\xe9."
            shown = f"{scratch}/caf\ufffd."

            def said(code: int, *words: "str | bytes") -> Any:
                done = subprocess.run([BUILD / "meniscus", *words, "-o", "json"], env=self.environment, capture_output=True, timeout=60)
                self.assertEqual(done.returncode, code, done.stderr)
                return json.loads(done.stdout)

            self.assertIn("caf\ufffd", said(65, "load", bad + b"yaml")["error"]["message"])
            self.assertIn("caf\ufffd", said(74, "export", bad + b"h5", "--out", bad + b"csv")["error"]["message"])
            self.assertIn("caf\ufffd", said(65, "run", bad + b"yaml")["error"]["message"])
            written = said(0, "init", bad + b"yaml")
            self.assertEqual(written["file"], f"{shown}yaml")
            self.assertEqual(written["next"][0], f"meniscus run {shown}yaml")
            ran = said(0, "run", bad + b"yaml", "--out", bad + b"run", "--set", "end_time=0")
            self.assertEqual((ran["error"], ran["run_directory"]), (None, f"{shown}run"))

    def test_output_that_nobody_gets_is_a_failure(self) -> None:
        self.meniscus("load", *SMALL)
        programs = {"meniscus": ("status", "ls", "top --once", "get", "query", "capabilities", "schemes", "help", "help run", "run --help", "status -o json",
                                 "--version", "--help", "keys list", "keys list -o json", "completion bash", "doctor", "init -", "check dambreak2d",
                                 "check dambreak2d -o json"),
                    "meniscusd": ("--help", "--usage", "--version", "--schemes", "--machine", "--machine -o json", "--check dambreak2d")}  # fmt: skip
        if (BUILD / "meniscus-dashboard").exists():  # which needs more to be built
            programs["meniscus-dashboard"] = ("--help", "--version")
        for program, commands in programs.items():
            for words in commands:
                with self.subTest(program, words=words), open("/dev/full", "w") as full:
                    done = subprocess.run([BUILD / program, *words.split()], env=self.environment, stdout=full,
                                          stderr=subprocess.PIPE, text=True, timeout=60)  # fmt: skip
                    self.assertEqual(done.returncode, 74, done.stderr)
                    self.assertEqual(done.stderr.count("cannot write to standard output"), 1)

    def test_what_goes_on_ends_at_once_when_its_output_cannot_be_written(self) -> None:
        """With the reason, as everywhere."""
        said = "cannot write to standard output: No space left on device; make room and try again"
        self.meniscus("load", *SMALL, "--set", "end_time=1000", "--start")
        for words in ("watch", "watch -o json", "stream probes", "stream probes -o json", "top -o json"):
            with self.subTest(words), open("/dev/full", "w") as full:
                done = subprocess.run([BUILD / "meniscus", *words.split()], env=self.environment, stdout=full,
                                      stderr=subprocess.PIPE, text=True, timeout=20)  # fmt: skip
                self.assertEqual((done.returncode, done.stderr.count(said)), (74, 1), done.stderr)
        self.meniscus("stop")
        for more in ([], ["-o", "json"]):
            for output, reason in ((">/dev/full", "No space left on device; make room"), (">&-", "Bad file descriptor; ")):
                with self.subTest(output, more=more):
                    done = subprocess.run(["bash", "-c", f'"$@" {output}', "bash", BUILD / "meniscus", "run", *SMALL, "--set", "end_time=0", *more,
                                           "--out", self.home / "unheard", "--overwrite"], env=self.environment, capture_output=True, text=True, timeout=60)  # fmt: skip
                    self.assertEqual(done.returncode, 74, done.stderr)
                    self.assertEqual(done.stderr.count(f"cannot write to standard output: {reason}"), 1, done.stderr)

    def test_a_place_that_cannot_be_written_to_is_a_failure_of_the_disk(self) -> None:
        self.meniscus("run", *SMALL, "--out", "/proc/x", code=74)
        here = Path(self.ask("load", *SMALL)["message"])
        away = here.rename(here.with_name("away"))
        for command in ("checkpoint", "reset"):
            self.assertIn(str(here), self.meniscus(command, code=74).stderr)
        away.rename(here)
        self.meniscus("stop")
        done = subprocess.run([BUILD / "meniscusd", "--name", "proc", "--state-dir", "/proc/x"],
                              env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 74, done.stderr)

    def test_a_second_daemon_does_not_take_the_runs_of_the_first(self) -> None:
        self.load()
        for name, code, words in (("second", 75, (f"process {self.daemon.pid} on ", str(self.home / "state"), "--state-dir")), ("default", 1, ("--name",))):
            done = subprocess.run([BUILD / "meniscusd", "--name", name, "--state-dir", self.home / "state"],
                                  env=self.environment, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            for word in words:
                self.assertIn(word, done.stderr)
        self.assertEqual(self.ask("status")["state"], "READY")
        self.meniscus("status", "--daemon", "second", code=69)

    def test_a_run_whose_directory_another_has_is_told_what_helps(self) -> None:
        words = [BUILD / "meniscus", "run", "dambreak2d", "--set", "end_time=1000", "--out", self.home / "taken", "-o", "json"]
        with subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as first:
            try:
                while not (self.home / "taken" / "log").exists():
                    time.sleep(0.05)
                done = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=60)
            finally:
                first.kill()
        self.assertEqual(done.returncode, 75)
        self.assertIn("give another --out", json.loads(done.stdout)["error"]["hint"])
        self.assertNotIn("status", json.loads(done.stdout)["error"]["hint"])

    def test_what_the_system_refuses_is_told_with_its_path_and_what_to_do(self) -> None:
        self.load()
        snapshot = self.ask("snapshot")["path"]
        lost = str(self.home / "nowhere" / "x")
        for code, words in (
            (74, ["render", snapshot, "--field", "pressure", "--out", f"{lost}.png"]), (74, ["export", snapshot, "--out", f"{lost}.csv"]),
            (74, ["init", f"{lost}.yaml"]), (74, ["stream", "snapshots", "--to", f"{lost}/y"]), (74, ["render", f"{lost}.hdf", "--out", "x.png"]),
        ):  # fmt: skip
            error = self.meniscus(*words, code=code).stderr
            self.assertIn("No such file or directory; check the path", error, words)
            self.assertIn(lost, error, words)

    def test_the_same_id_steps_once(self) -> None:
        self.load()
        words = ["step", "3", "--id", "0123456789abcdef0123456789abcdef"]
        self.assertEqual(self.ask(*words)["step"], 3)
        self.assertEqual(self.ask(*words)["step"], 3)
        self.assertEqual(self.ask("status")["step"], 3)

    def test_a_command_for_another_step_is_refused(self) -> None:
        self.load()
        self.assertEqual(self.ask("step", "3", "--if-step", "0")["step"], 3)
        done = self.meniscus("set", "end_time=3", "--if-step", "2", code=1)
        self.assertIn("the run is at step 3, not 2; nothing was done", done.stderr)
        self.assertEqual(self.ask("set", "end_time=3", "--if-step", "3")["effect_step"], 3)
        for words in (["status"], ["get"], ["ls"], ["watch"]):
            self.meniscus(*words, "--if-step", "3", code=2)
        self.meniscus("set", "end_time=3", "--if-step", "-1", code=2)
        done = self.meniscus("load", "dambreak2d", "--if-step", "2", code=1)
        self.assertEqual(done.stderr, "meniscus: if_step: the run is at step 3, not 2; nothing was done\n")

    def test_changes_are_taken_back(self) -> None:
        self.load()
        self.assertEqual(self.ask("set", "end_time=3")["case_version"], 2)
        self.assertEqual(self.ask("set", "end_time=4", "--if-version", "2")["case_version"], 3)
        done = self.meniscus("set", "end_time=5", "--if-version", "2", code=1)
        self.assertIn("if_version: the case is at version 3, not 2; nothing was done", done.stderr)
        self.assertEqual(self.ask("rollback", "2")["case_version"], 4)
        self.assertEqual(self.ask("get", "end_time")["values"]["end_time"]["value"], 3)
        done = self.meniscus("rollback", "9", code=1)
        self.assertIn("there is no version 9 of the case: the present one is 4", done.stderr)
        for words in (["rollback"], ["rollback", "one"], ["set", "end_time=3", "--if-version", "0"]):
            self.meniscus(*words, code=2)

    def test_one_at_a_time_changes_the_run(self) -> None:
        self.load()
        epoch = self.meniscus("lease", "--ttl", "60", "--holder", "anna").stdout.strip()
        done = self.meniscus("set", "end_time=3", code=1)
        self.assertRegex(done.stderr, "lease_epoch: anna holds the lease for another (?s:.*)What to do: .*--lease")
        done = self.meniscus("load", *SMALL, code=1)
        self.assertIn(" lease_epoch: anna holds the lease for another", done.stderr)
        self.assertNotIn("yaml", done.stderr, "the file is not to blame")
        self.assertEqual(self.ask("status")["lease_holder"], "anna")
        self.ask("set", "end_time=3", "--lease", epoch)
        with mock.patch.dict(self.environment, MENISCUS_LEASE=epoch):
            self.assertEqual(str(self.ask("lease", "renew", "--ttl", "50")["lease_epoch"]), epoch)
            self.assertEqual(self.ask("set", "end_time=4")["state"], "READY")
            self.assertIsNone(self.ask("lease", "release")["lease_epoch"])
            done = self.meniscus("set", "end_time=5", code=1)
            self.assertIn(f"the lease of epoch {epoch} is over", done.stderr)
        self.ask("set", "end_time=5")
        self.assertIsNone(self.ask("status")["lease_holder"])
        for words in (["lease", "give"], ["lease", "renew"], ["lease", "--ttl", "soon"], ["lease", "--lease", "x"]):
            self.meniscus(*words, code=2)
        for ttl in ("0.05", "-5", "86401", "1e300"):
            self.assertIn(f"--ttl {ttl}: a lease lives from 0.1 to 86400 s", self.meniscus("lease", "--ttl", ttl, code=2).stderr)

    def test_a_name_that_would_upset_a_terminal_is_refused(self) -> None:
        self.load()
        for name in ("\x1b[2Janna", "anna\udcff"):  # the latter is the byte 0xff
            for words in (["lease", "--holder", name], ["breakpoint", name, "--step", "9"]):
                failure = self.ask(*words, code=1)["error"]
                self.assertEqual(failure["path"], {"lease": "holder", "breakpoint": "name"}[words[0]], failure)
                self.assertIn("control characters", failure["message"])
        status = self.ask("status")
        self.assertEqual((status["lease_holder"], status["breakpoints"]), (None, []))

    def test_the_holder_of_a_lease_is_named_without_half_a_character(self) -> None:
        self.load()
        with mock.patch.dict(self.environment, USER="x" + 20 * "é"):
            epoch = self.meniscus("lease").stdout.strip()
        self.assertRegex(self.ask("status")["lease_holder"], "^x" + 14 * "é" + "@")
        self.meniscus("lease", "release", "--lease", epoch)

    def test_the_holder_of_a_lease_has_a_name_without_the_variable_too(self) -> None:
        self.load()
        mine = pwd.getpwuid(os.geteuid()).pw_name
        for user, name in (({}, mine), ({"USER": ""}, mine), ({"USER": "anna"}, "anna")):
            environment = {key: value for key, value in self.environment.items() if key != "USER"} | user
            with mock.patch.dict(self.environment, environment, clear=True):
                epoch = self.meniscus("lease").stdout.strip()
            self.assertEqual(self.ask("status")["lease_holder"], f"{name}@{gethostname()[:30]}", user)
            self.meniscus("lease", "release", "--lease", epoch)

    def test_a_breakpoint_that_was_passed_is_refused(self) -> None:
        self.load()
        self.ask("step", "3")
        done = self.meniscus("breakpoint", "late", "--step", "3", code=1)
        self.assertIn("never be reached: the run is at step 3", done.stderr)
        done = self.meniscus("breakpoint", "late", "--time", "0", code=1)
        self.assertIn("never be reached", done.stderr)
        self.ask("breakpoint", "ahead", "--step", "4")
        self.assertEqual(len(self.ask("status")["breakpoints"]), 1)

    def test_questions_without_an_answer_are_refused(self) -> None:
        self.load()
        done = self.meniscus("query", "box", "0.2,0.2", "0.1,0.3", code=1)
        self.assertIn("the lower corner of the box, 0.2, is above the upper one, 0.1, along x", done.stderr)
        done = self.meniscus("query", "at", "phase", "0.5,0.5", code=1)
        self.assertIn("phase has no average", done.stderr)

    def test_a_client_killed_in_the_middle_leaves_the_daemon_well(self) -> None:
        self.load()
        for name in ("SIGKILL", "SIGTERM"):
            client = subprocess.Popen([BUILD / "meniscus", "run-until", "7"], env=self.environment)
            self.wait_until(lambda: self.ask("status")["state"] == "RUNNING")
            client.send_signal(getattr(signal, name))
            client.wait(timeout=60)
            self.assertEqual(self.ask("pause")["state"], "PAUSED")

    def test_cancel_ends_a_pending_command(self) -> None:
        self.load()
        request = "00112233445566778899aabbccddeeff"
        client = subprocess.Popen(
            [BUILD / "meniscus", "wait", "--for", "state=DONE", "--id", request], env=self.environment,
            stderr=subprocess.DEVNULL,
        )
        cancel = [BUILD / "meniscus", "cancel", request]  # refused until there is such a command
        self.wait_until(lambda: subprocess.run(cancel, env=self.environment, capture_output=True).returncode == 0)
        self.assertEqual(client.wait(timeout=60), 75)

    def test_a_wrong_state_is_refused_with_what_is_possible(self) -> None:
        done = self.meniscus("pause", code=1)
        self.assertIn("EMPTY", done.stderr)
        self.assertIn("load a case first", done.stderr)
        self.assertNotIn("What to do", done.stderr)

    def test_capabilities_and_schemes_are_listed(self) -> None:
        self.load()
        capabilities = self.ask("capabilities")
        self.assertIn("gravity", [parameter["name"] for parameter in capabilities["parameters"]])
        fields = [field["name"] for field in capabilities["fields"]]
        self.assertIn("pressure", fields)
        refused = self.meniscus("stream", "fields", "nothing", "--count", "1", code=1).stderr
        self.assertTrue(refused.strip().endswith("allowed: " + ", ".join(fields)), "what can be asked for is what is listed: " + refused)
        self.assertEqual(capabilities["topics"], ["event", "log", "progress", "probe"])
        self.assertTrue(all(parameter["takes_effect"] for parameter in capabilities["parameters"]))
        self.assertIn("riemann", [scheme["name"] for scheme in self.ask("schemes")["schemes"]])

    def test_schemes_are_told_alike_with_and_without_a_daemon(self) -> None:
        alone = self.environment | {"MENISCUS_DAEMON": "nobody-of-that-name"}
        for words in (["schemes"], ["schemes", "-o", "json"]):
            done = subprocess.run([BUILD / "meniscus", *words], env=alone, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout, self.meniscus(*words).stdout)

    def test_ls_finds_the_daemon(self) -> None:
        daemons = [d for d in self.ask("ls")["daemons"] if str(self.home) in d["endpoint"]]
        self.assertEqual([(d["name"], d["alive"], d["state"]) for d in daemons], [("default", True, "EMPTY")])


class BadCases(DaemonTest):
    def test_an_unknown_key_is_named_with_its_place(self) -> None:
        case = self.home / "bad.yaml"
        case.write_text("dimensions: 2\nresolutoin: 20\n")
        done = self.meniscus("load", str(case), code=65)
        self.assertTrue(done.stderr.startswith(f"{case}:2:1: "), done.stderr)
        self.assertIn("resolution", done.stderr)

    def test_what_only_the_daemon_can_see_is_named_with_its_place_too(self) -> None:
        shipped = Path(self.environment["MENISCUS_CASES"]) / "dambreak2d.yaml"
        lines = shipped.read_text().splitlines()
        at = next(k for k, line in enumerate(lines) if "axis: x, within" in line)
        lines[at] = lines[at].replace("fluid: water", "fluid: wine")
        case = self.home / "wine.yaml"
        case.write_text("\n".join(lines))
        done = self.meniscus("load", str(case), code=65)
        self.assertTrue(done.stderr.startswith(f"{case}:{at + 1}:"), done.stderr)
        self.assertEqual(self.ask("status")["state"], "EMPTY")

    def test_a_case_that_is_not_there_says_which_are(self) -> None:
        done = self.meniscus("load", "dambrake", code=65)
        self.assertIn("dambreak2d", done.stderr)
        self.assertIn(f"none in {self.environment['MENISCUS_CASES']}", done.stderr)

    def test_a_file_that_is_not_there_can_be_written(self) -> None:
        for command in ("load", "run"):
            done = self.meniscus(command, "no-such.yaml", code=65)
            self.assertIn("no file \"no-such.yaml\"", done.stderr)
            self.assertIn("`meniscus init FILE.yaml`", done.stderr)

    def test_a_bad_name_for_the_run_is_no_fault_of_the_case(self) -> None:
        done = self.meniscus("load", *SMALL, "--name", "../x", code=2)
        self.assertTrue(done.stderr.startswith("meniscus: the name of a case"), done.stderr)

    def test_a_bad_override_is_named(self) -> None:
        done = self.meniscus("load", *SMALL, "--set", "fluids[0].density=-1", code=65)
        self.assertTrue(done.stderr.startswith("--set fluids[0].density=-1: "), done.stderr)


class Watching(DaemonTest):
    def test_what_there_is_not_is_not_shown(self) -> None:
        self.assertRegex(self.meniscus("watch").stdout, r"^EMPTY +no case\n$")

    def start(self, end_time: str = "0.3", *more: str) -> None:
        self.meniscus("load", *SMALL, "--set", f"end_time={end_time}", *more, "--start")

    def test_lines_of_json_are_numbered_without_gaps(self) -> None:
        self.start()
        lines = [json.loads(line) for line in self.meniscus("watch", "-o", "json").stdout.splitlines()]
        self.assertEqual(lines[0]["topic"], "status")
        probes = [line for line in lines if line["topic"] == "probe"]
        self.assertGreater(len(probes), 3)
        self.assertEqual({line["lost"] for line in probes}, {0})
        self.assertIn("P05", probes[-1]["values"])
        self.assertEqual(lines[-1].get("state"), "DONE")

    def test_plain_lines_have_no_escapes(self) -> None:
        self.start()
        text = self.meniscus("watch").stdout
        self.assertNotIn("\033", text)
        self.assertIn("DONE", text.splitlines()[-1])

    def test_a_time_limit_ends_it(self) -> None:
        self.start("1000")
        self.meniscus("watch", "--timeout", "0.3", code=124)

    def test_time_does_not_go_back_right_after_a_start(self) -> None:
        for _ in range(5):
            self.start("1000", "--set", "output.probe_interval=10")
            text = self.meniscus("watch", "--timeout", "0.5", code=124).stdout
            steps = [int(step) for step in re.findall(r" step (\d+) ", text)]
            self.assertGreater(len(steps), 1, text)
            self.assertEqual(steps, sorted(steps), text)
            self.assertTrue(steps[0] == 0 or "started" not in text, text)
            self.meniscus("stop")

    def test_the_first_line_shows_values_of_its_own_step(self) -> None:
        self.start("1000", "--set", "output.probe_interval=1e-9", "--set", "resolution=10")
        first = self.meniscus("watch", "--timeout", "0.3", code=124).stdout.splitlines()[0]
        shown = re.search(r" t = (\S+) s .* front = (\S+) m", first)
        assert shown, first
        directory = self.ask("stop")["path"]
        rows = csv.DictReader(self.meniscus("export", f"{directory}/probes.hdf").stdout.splitlines())
        fronts = {float(f"{float(row['time [s]']):.6g}"): float(f"{float(row['front [m]']):.5g}") for row in rows}
        self.assertEqual(fronts[float(shown[1])], float(shown[2]))

    def test_time_goes_back_where_the_run_does(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("step", "3")
        self.meniscus("checkpoint")
        self.meniscus("step", "3")
        words = [BUILD / "meniscus", "watch", "-o", "json"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=self.environment) as watching:
            assert watching.stdout
            self.assertEqual(json.loads(watching.stdout.readline())["step"], 6)
            self.meniscus("restore")
            while (line := json.loads(watching.stdout.readline()))["topic"] != "event" or line["step"] == 6:
                pass
            self.assertEqual((line["state"], line["step"]), ("READY", 3))
            self.assertEqual(json.loads(watching.stdout.readline())["step"], 3)
            self.meniscus("stop")

    def watch_terminal(self, columns: int, locale: str, rows: int = 24) -> "list[str]":
        """What is shown on a terminal as wide as that when the run is done: lines without what moves the cursor."""
        self.start("0.3", "--set", "output.probe_interval=0.002")
        master, slave = pty.openpty()
        termios.tcsetwinsize(slave, (rows, columns))
        words = [BUILD / "meniscus", "watch"]
        client = subprocess.Popen(words, env=self.environment | {"LC_ALL": locale}, stdout=slave)
        os.close(slave)
        text = read_to_the_end(master)
        self.assertEqual(client.wait(timeout=60), 0)
        self.meniscus("stop")
        last = re.split(rb"\033\[\d+A\r", text)[-1].decode("utf-8")
        return re.sub(r"\033\[[?\d]*[A-Za-z]", "", last).splitlines()

    def test_each_probe_has_a_chart_in_the_columns_that_are_free(self) -> None:
        for columns, chart, has_range in ((80, 20, True), (40, 4, False)):
            lines = self.watch_terminal(columns, "C.UTF-8")
            self.assertLess(max(len(line) for line in lines), columns, lines)
            fronts = [line for line in lines if line.startswith("  front ")]
            drawn = re.findall("[▁-█]+", fronts[0])
            self.assertGreaterEqual(len(drawn[0]), chart, lines)
            self.assertEqual((drawn[0][0], drawn[0][-1]), ("▁", "█"), "the water runs, and so its front rises")
            value = float(fronts[0].split()[1])
            ends = re.findall(r"(\S+)\.\.(\S+)$", fronts[0])
            self.assertEqual(bool(ends), has_range, fronts)
            if has_range:
                self.assertLess(float(ends[0][0]), float(ends[0][1]))
                self.assertAlmostEqual(float(ends[0][1]), value, delta=0.01)

    def test_a_low_terminal_says_how_many_probes_it_has_no_line_for(self) -> None:
        whole = self.watch_terminal(80, "C.UTF-8")
        low = self.watch_terminal(80, "C.UTF-8", rows=10)
        self.assertEqual(len(low), 3 + 5)
        self.assertEqual(low[-1], f"  and {len(whole) - 3 - 4} more probes: no room for them")
        self.assertNotIn(" more probe", "".join(whole))

    def test_a_chart_is_ascii_where_the_locale_has_no_blocks(self) -> None:
        fronts = [line for line in self.watch_terminal(80, "C") if line.startswith("  front ")]
        self.assertTrue(fronts[0].isascii())
        self.assertRegex(fronts[0], r"\.[.:=+*#-]+%")

    def test_a_terminal_is_left_as_it_was_found(self) -> None:
        self.start("1000")
        master, slave = pty.openpty()
        client = subprocess.Popen([BUILD / "meniscus", "watch"], env=self.environment, stdout=slave)
        os.close(slave)
        text = b""
        while b"%" not in text:
            text += os.read(master, 65536)
        client.send_signal(signal.SIGINT)
        text += read_to_the_end(master)
        client.wait(timeout=60)
        self.assertEqual(client.returncode, -signal.SIGINT)
        self.assertIn(b"\033[?25l", text)
        self.assertIn(b"%", text)
        self.assertTrue(text.endswith(b"\033[?25h"), text[-80:])


class WithoutDaemon(unittest.TestCase):
    def run_cli(self, *words: str) -> "subprocess.CompletedProcess[str]":
        environment = os.environ | {
            "XDG_RUNTIME_DIR": "/nonexistent", "MENISCUS_DAEMON": "nobody-of-that-name", "MENISCUS_CASES": str(CASES)
        }
        return subprocess.run([BUILD / "meniscus", *words], env=environment, capture_output=True, text=True, timeout=60)

    def test_an_unreachable_daemon_is_said_quickly_and_with_its_code(self) -> None:
        began = time.monotonic()
        for words in (["status"], ["pause"], ["status", "--daemon", "tcp://127.0.0.1:1"]):
            done = self.run_cli(*words)
            self.assertEqual(done.returncode, 69)
            self.assertIn("meniscusd", done.stderr)
        self.assertLess(time.monotonic() - began, 20)

    def test_misuse_has_its_code_and_a_suggestion(self) -> None:
        for words, hint in {
            "stauts": "status",
            "status --timout 3": "--timeout",
            "step x": "whole",
            "query box 1": "corner",
            "set gravity": "PATH=VALUE",
            "wait --for state=HAPPY": "DONE",
            "load": "CASE",
            "-o xml ls": "json",
        }.items():
            done = self.run_cli(*words.split())
            self.assertEqual(done.returncode, 2, words)
            self.assertIn(hint, done.stderr)

    def assert_fails_as_json(self, code: int, *words: str) -> None:
        """One object on one line, which says what is wrong and what to do; and a sentence for people."""
        done = self.run_cli(*words)
        self.assertEqual(done.returncode, code, done.stderr)
        lines = done.stdout.splitlines()
        self.assertEqual(len(lines), 1, done.stdout)
        error = json.loads(lines[0])["error"]
        self.assertEqual(set(error), {"status", "message", "path", "hint", "exit_code"})
        self.assertEqual(error["exit_code"], code)
        self.assertTrue(error["status"] and error["message"] and error["hint"], error)
        self.assertTrue(done.stderr)

    def test_whatever_fails_is_one_json_object_for_those_who_ask(self) -> None:
        self.assert_fails_as_json(69, "status", "-o", "json")
        self.assert_fails_as_json(69, "render", "--out", "x.png", "-o", "json")
        self.assert_fails_as_json(74, "render", "nothing.hdf", "--out", "x.png", "-o", "json")
        self.assert_fails_as_json(65, "run", "no-such-case", "-o", "json")
        self.assert_fails_as_json(65, "run", "dambreak2d", "--set", "foo=1", "-o", "json")

    def test_misuse_is_one_json_object_too_wherever_json_is_asked_for(self) -> None:
        for words in (
            "-o json", "stauts -o json", "--bogus -o json", "pause --bogus -o json", "-o json pause --timeout",
            "render -o json", "render a.hdf --bogus --output=json", "render a.hdf --out x.jpg -o json", "run -o json",
            "run dambreak2d --bogus -o json", "run dambreak2d --until x -ojson", "run a b -o json",
            "run dambreak2d --threads -1 -o json", "run dambreak2d --resume always --output json", "step x -o json",
            "status -o json -o xml", "-o json schemes --output=xml", "run dambreak2d -o json -o xml",
        ):  # fmt: skip
            with self.subTest(words):
                self.assert_fails_as_json(2, *words.split())

    def test_who_typed_meniscus_is_answered_by_it(self) -> None:
        for words, code in ((["run", "nosuch"], 65), (["log", "/nonexistent"], 74), (["run", *SMALL, "--out", "/dev/null/x"], 74)):
            done = self.run_cli(*words)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertTrue(done.stderr.startswith("meniscus: "), done.stderr)
            self.assertNotIn("meniscusd", done.stderr)

    def test_the_daemon_s_own_command_line_is_as_good(self) -> None:
        for words in (["--batch", "dambreak2d", "--bogus", "-o", "json"], ["--batch", "dambreak2d", "-o", "json", "x"]):
            done = subprocess.run([BUILD / "meniscusd", *words], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(json.loads(done.stdout)["error"]["exit_code"], 2)

    def test_a_run_that_fails_or_is_stopped_says_so_in_its_one_object(self) -> None:
        import tempfile

        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            wild = ["--set", "limits.density_max=1.0000001", "--out", f"{scratch}/wild"]
            self.assert_fails_as_json(70, "run", *SMALL, *wild, "-o", "json")
            self.assert_fails_as_json(74, "run", *SMALL, "--out", "/dev/null/x", "-o", "json")
            words = [BUILD / "meniscus", "run", *SMALL, "--out", f"{scratch}/stopped", "-o", "json"]
            environment = os.environ | {"MENISCUS_CASES": str(CASES)}
            run = subprocess.Popen(
                words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            until = time.monotonic() + 60
            while not list(Path(scratch).glob("stopped/snapshot-*")) and time.monotonic() < until:
                time.sleep(0.02)
            run.terminate()
            done = json.loads(run.communicate(timeout=60)[0])
            self.assertEqual((done["exit_code"], done["error"]["status"], done["state"]), (75, "interrupted", "PAUSED"))

    def test_help_lists_every_command_with_the_request_it_sends(self) -> None:
        commands = {c["name"]: c for c in json.loads(self.run_cli("help", "-o", "json").stdout)["commands"]}
        self.assertEqual(commands["run-until"]["request"], "run_until")
        names = (
            "load start pause resume step run-until stop reset set get query watch snapshot checkpoint restore wait "
            "status ls schemes render run log replay rollback lease init doctor completion top"
        )
        for name in names.split():
            self.assertIn(name, commands)
        overview = self.run_cli("help").stdout
        for name, command in commands.items():
            text = self.run_cli("help", name).stdout
            self.assertEqual(text, self.run_cli(name, "--help").stdout)
            self.assertIn(f"Usage: meniscus {name} [OPTION]...", text)
            self.assertIn(f"  {name} ", overview)
            for option in command["options"]:
                self.assertIn(f"--{option['name']}", text)
            self.assertEqual("69 " in text, name not in ("init", "doctor", "completion", "top", "run", "check", "export", "help", "schemes", "keys", "log", "replay"), "who talks to a daemon says so")

    def test_the_overview_tells_a_beginner_what_to_type(self) -> None:
        overview = self.run_cli("help").stdout
        for word in ("meniscus run dambreak2d", "meniscusd --state-dir", "Exit codes:", "124"):
            self.assertIn(word, overview)
        self.assertLess(max(len(line) for line in overview.splitlines()), 125)

    def test_run_needs_no_daemon(self) -> None:
        import tempfile

        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            done = self.run_cli("run", *SMALL, "--set", "end_time=0.01", "--out", f"{scratch}/out", "-o", "json")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout)["state"], "DONE")


if __name__ == "__main__":
    unittest.main()

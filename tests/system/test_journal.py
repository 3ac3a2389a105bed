#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The journal of a run: it tells who changed what, it can be replayed to the same bits, and no changed byte escapes it."""

import ctypes
import itertools
import json
import os
import random
import secrets
import shutil
import struct
import subprocess
import sys
import time
import unittest
from pathlib import Path
from typing import Any, Callable

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, at_length, old_machine  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import journal_pb2  # noqa: E402
from meniscus import meniscus_pb2 as pb  # noqa: E402

xxh64 = ctypes.CDLL("libxxhash.so.0").XXH64
xxh64.restype, xxh64.argtypes = ctypes.c_uint64, [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_uint64]
CASE = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=30", "--set", "threads=1"]
COMMANDS = 40 if at_length() else 15  # of a random time line
HASH_STEPS = 100


class Journal(DaemonTest):
    def brought(self, giver: str, taker: str, *settings: str) -> "tuple[Path, Path]":
        """A new run directory with the checkpoint of another run, and that checkpoint."""
        self.run_of(giver, *settings)
        self.meniscus("step", "6")
        left = Path(self.ask("checkpoint")["path"])
        self.meniscus("stop")
        run = self.home / "state" / taker
        run.mkdir()
        (run / left.name).write_bytes(left.read_bytes())
        return run, left

    def run_of(self, name: str, *more: str) -> Path:
        self.meniscus("load", *CASE, *more, "--name", name)
        return self.home / "state" / name

    def log(self, run: Path) -> list[dict[str, Any]]:
        records: list[dict[str, Any]] = self.ask("log", str(run))["records"]
        return records

    def replay(self, run: Path, *more: str, code: int = 0) -> dict[str, Any]:
        result: dict[str, Any] = self.ask("replay", str(run), "--verify", *more, code=code)
        return result

    def test_it_tells_who_changed_what_and_when(self) -> None:
        run = self.run_of("who")
        self.meniscus("step", "3")
        self.meniscus("set", "gravity=[0, -2]", "end_time=2", "--id", "0123456789abcdef0123456789abcdef")
        self.meniscus("set", "gravity=[0, 0, 9]", code=1)
        self.meniscus("step", "2")
        self.meniscus("stop")
        records = self.log(run)
        told = [(r["command"], r["kind"], r["step"]) for r in records if r["kind"] != "hash"]
        self.assertEqual(told, [("load", "command", 0), ("step", "begun", 0), ("step", "command", 3), ("set", "command", 3),
                                ("step", "begun", 3), ("step", "command", 5), ("stop", "command", 5)])
        change = next(r for r in records if r["command"] == "set")
        self.assertEqual(change["changes"], [{"path": "gravity", "before": "[0, -1]", "after": "[0, -2]"},
                                             {"path": "end_time", "before": "30", "after": "2"}])
        self.assertEqual(change["id"], "0123456789abcdef0123456789abcdef")
        self.assertEqual(change["reply"]["code"], "OK")
        self.assertEqual(change["who"], "local")
        self.assertIn("gravity = [0, -2] (was [0, -1])", self.meniscus("log", str(run)).stdout)

    def test_it_tells_who_had_files_written_and_what_was_cancelled(self) -> None:
        run = self.run_of("files")
        step, until, file = "00" * 15 + "01", "00" * 15 + "02", "00" * 15 + "03"
        self.meniscus("step", "3", "--id", step)
        written = self.ask("checkpoint", "--id", file)
        self.meniscus("snapshot")
        with subprocess.Popen([BUILD / "meniscus", "run-until", "30", "--id", until], env=self.environment, stderr=subprocess.PIPE) as waits:
            self.meniscus("wait", "--for", "step=10")
            self.meniscus("checkpoint")  # while it runs
            self.meniscus("cancel", until)
            self.assertNotEqual(waits.wait(timeout=60), 0)
        told = [(r["command"], r["kind"]) for r in self.log(run) if r["kind"] != "hash"]
        self.assertEqual(told, [("load", "command"), ("step", "begun"), ("step", "command"), ("checkpoint", "command"), ("snapshot", "command"),
                                ("run_until", "begun"), ("checkpoint", "command"), ("run_until", "command"), ("cancel", "command")])
        self.assertTrue(all(r["who"] == "local" for r in self.log(run) if r["command"]))
        self.assertTrue(self.replay(run)["agrees"])
        before = self.ask("status")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED")
        self.assertEqual(self.ask("status")["step"], before["step"])
        Path(written["path"]).unlink()
        again = self.ask("checkpoint", "--id", file)
        self.assertEqual((again["path"], again["effect_step"]), (written["path"], 3))
        self.assertFalse(Path(written["path"]).exists())  # it was not written a second time

    def test_programs_can_read_it_with_the_messages_of_the_python_package(self) -> None:
        run = self.run_of("read")
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("step", "3")
        data, records = (run / "journal").read_bytes(), []
        self.assertEqual(data[:8], b"MNSJRNL1")
        at = 8
        while at < len(data) and data[at:at + 4] != bytes(4):  # behind the last there may be room
            _, size, number = struct.unpack_from("<IIQ", data, at)
            records.append(journal_pb2.JournalRecord.FromString(data[at + 40:at + 40 + size]))
            self.assertEqual(number, len(records))
            at += 40 + size
        told = self.log(run)
        self.assertEqual([r.step for r in records], [r["step"] for r in told])
        kinds = [journal_pb2.JournalRecord.Kind.Name(r.kind).lower() for r in records]
        self.assertEqual(kinds, [r["kind"] for r in told])
        self.assertEqual([(c.path, c.before, c.after) for r in records for c in r.changes], [("gravity", "[0, -1]", "[0, -2]")])

    def test_what_was_answered_outlives_a_kill(self) -> None:
        run = self.run_of("killed")
        for k in range(20):
            self.meniscus("set", f"end_time={k + 5}")
        self.kill_daemon()
        self.assertEqual([r for r in self.log(run) if r["changes"]][-1]["changes"][0]["after"], "24")

    def test_a_random_time_line_replays_to_the_same_bits_with_any_number_of_threads(self) -> None:
        chance = random.Random(20267709)  # which begins with all that changes a run, and goes back twice
        run = self.run_of("random")
        for _ in range(COMMANDS):
            self.do_something(chance)
        self.meniscus("checkpoint")
        self.meniscus("restore")
        self.whatever("breakpoint", "b", "--remove")
        for _ in range(2):
            self.meniscus("step", str(HASH_STEPS))
        records = self.log(run)
        hashes = sum(r["kind"] == "hash" for r in records)
        self.assertGreater(hashes, 10)
        self.assertTrue(any(r["command"] == "restore" for r in records))
        self.assertTrue(any(r["kind"] == "hash" and r["step"] and r["step"] % HASH_STEPS == 0 for r in records))
        for threads in ("1", "2", "3"):
            result = self.replay(run, "--threads", threads)
            self.assertTrue(result["agrees"])
            self.assertEqual(result["compared"], hashes)

    def test_a_checkpoint_of_another_case_is_refused_and_the_run_comes_back_and_replays(self) -> None:
        other = self.run_of("other", "--set", "fluids[0].density=1.5")
        self.meniscus("step", "3")
        foreign = Path(self.ask("checkpoint")["path"])
        run = self.run_of("own")
        self.meniscus("step", "2")
        (run / "checkpoint-0000000007.hdf").write_bytes(foreign.read_bytes())
        before, records = self.ask("status"), self.log(run)
        refused = self.meniscus("restore", "checkpoint-0000000007.hdf", code=1).stderr
        self.assertIn("is a checkpoint of another case", refused)
        self.assertIn("fluids[0].density", refused)
        self.assertIn("none of the 1 checkpoints", self.meniscus("restore", code=1).stderr)  # the newest of this run
        now = self.ask("status")
        self.assertEqual([now[key] for key in ("state", "step", "state_hash", "case_version")],
                         [before[key] for key in ("state", "step", "state_hash", "case_version")])
        self.assertEqual(self.log(run), records)
        self.assertEqual(list(run.glob("abandoned*")), [])
        (run / "checkpoint-0000000007.hdf").unlink()
        self.meniscus("set", "end_time=20")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED")
        self.assertEqual(self.ask("status")["step"], 2)
        self.assertTrue(self.replay(run)["agrees"])
        self.assertTrue(other.is_dir())

    def assert_refused(self, run: Path, name: str, why: str) -> None:
        """A restore that changes nothing."""
        seen = ("state", "step", "state_hash", "case_version")
        before, records, files = self.ask("status"), self.log(run), sorted(run.rglob("*"))
        self.assertIn(why, self.meniscus("restore", name, code=1).stderr)
        now = self.ask("status")
        self.assertEqual([now[key] for key in seen], [before[key] for key in seen])
        self.assertEqual((self.log(run), sorted(run.rglob("*"))), (records, files))

    def assert_comes_back(self, run: Path) -> None:
        seen = ("state", "step", "state_hash")
        before = self.ask("status")
        self.kill_daemon()
        self.meniscus("wait", "--for", f"state={before['state']}", "--timeout", "60")
        now = self.ask("status")
        self.assertEqual([now[key] for key in seen], [before[key] for key in seen])
        self.assertTrue(self.replay(run)["agrees"])

    def test_a_checkpoint_of_another_run_of_the_case_is_refused(self) -> None:
        """Its gravity and end time are others, and its state is not one that the journal leads to."""
        self.run_of("steered", "--set", "gravity=[0, -2]", "--set", "end_time=0.5")
        self.meniscus("step", "3")
        foreign = Path(self.ask("checkpoint")["path"])
        run = self.run_of("own-state")
        self.meniscus("step", "5")
        for name in ("checkpoint-0000000003.hdf", "checkpoint-0000000007.hdf"):
            (run / name).write_bytes(foreign.read_bytes())
            self.assert_refused(run, name, "is a checkpoint of another run")
            (run / name).unlink()
        self.assert_comes_back(run)

    def foreign(self, name: str) -> Path:
        """A later checkpoint of another run of the case, which is ended."""
        self.run_of(name, "--set", "output.checkpoints_kept=9")
        self.meniscus("step", "30")
        for _ in range(5):  # so that it is the newest wherever it goes
            self.meniscus("step", "1")
            self.meniscus("checkpoint")
        path = Path(self.ask("checkpoint")["path"])
        self.meniscus("stop")
        return path

    def assert_passed_over(self, path: Path, said: str, why: str = "is a checkpoint of another run") -> None:
        """By one warning that names it."""
        told = [line for line in said.splitlines() if str(path) in line and "passed over" in line]
        self.assertEqual(len(told), 1, said)
        self.assertIn(why, told[0])
        self.assertIn("copy it into a new directory", told[0])

    def said(self) -> str:
        """By the daemons of this class."""
        return (self.home / "log").read_text()

    def test_a_run_comes_back_from_a_checkpoint_of_its_own(self) -> None:
        brought = self.foreign("stranger")
        for own in (True, False):  # or from the beginning
            run = self.run_of(f"back-from-its-own-{own}")
            self.meniscus("step", "4")
            if own:
                self.meniscus("checkpoint")
            self.meniscus("set", "gravity=[0, -2]")
            self.meniscus("step", "3")
            (run / brought.name).write_bytes(brought.read_bytes())
            self.assert_comes_back(run)
            self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -2]")
            self.assert_passed_over(run / brought.name, self.said())
            self.assertEqual((run / "abandoned" / brought.name).read_bytes(), brought.read_bytes())  # it was of a later step
            self.meniscus("stop")

    def test_a_resumed_load_goes_on_from_a_checkpoint_of_its_own(self) -> None:
        brought = self.foreign("stranger-too")
        run = self.run_of("resumed-own")
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("step", "4")
        self.meniscus("checkpoint")
        self.meniscus("stop")
        (run / brought.name).write_bytes(brought.read_bytes())
        self.meniscus("load", *CASE, "--name", "resumed-own", "--resume")
        self.assertEqual(self.ask("status")["step"], 4)
        self.assert_passed_over(run / brought.name, self.said())
        self.meniscus("step", "2")
        (run / brought.name).write_bytes(brought.read_bytes())
        self.meniscus("restore")  # the newest
        self.assertEqual(self.ask("status")["step"], 4)
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -2]")
        self.assert_comes_back(run)

    def batch(self, out: Path, *more: str, code: int = 0) -> dict[str, Any]:
        done = self.meniscus("run", *CASE, "--threads", "1", "--out", str(out), *more, "-o", "json", code=code)
        told: dict[str, Any] = json.loads(done.stdout)
        return told | {"said": done.stderr}

    def test_a_resumed_batch_run_goes_on_from_a_checkpoint_of_its_own(self) -> None:
        brought = self.foreign("stranger-three")
        out = self.home / "batch-own"
        first = self.batch(out, "--until", "0.1")
        (out / brought.name).write_bytes(brought.read_bytes())
        again = self.batch(out, "--until", "0.1", "--resume", "auto")
        self.assertEqual((again["steps"], again["state_hash"]), (first["steps"], first["state_hash"]))
        self.assert_passed_over(out / brought.name, again["said"])
        for own in out.glob("checkpoint-*.hdf"):
            own.unlink()
        (out / brought.name).write_bytes(brought.read_bytes())
        again = self.batch(out, "--until", "0.1", "--resume", "auto")  # as without a checkpoint
        self.assertEqual((again["steps"], again["state_hash"]), (first["steps"], first["state_hash"]))
        self.assertEqual([r["command"] for r in self.log(out) if r["kind"] == "command"][-3:], ["load", "run_until", "shutdown"])
        self.assertTrue(self.replay(out)["agrees"])

    def test_a_checkpoint_of_a_time_line_that_was_left_is_passed_over(self) -> None:
        run = self.run_of("left-and-back")
        self.meniscus("step", "5")
        first = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("step", "5")
        left = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("restore", first)
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("step", "8")
        (run / "abandoned" / left).rename(run / left)
        self.assert_comes_back(run)
        self.assert_passed_over(run / left, self.said(), "is of a time line that this run has left: record ")

    def test_a_run_that_began_from_a_checkpoint_alone_comes_back_to_what_was_set_with_it(self) -> None:
        run, left = self.brought("giver", "taker")
        self.meniscus("load", *CASE, "--name", "taker", "--resume", "--set", "gravity=[0, -2]")
        self.meniscus("step", "5")
        self.assert_comes_back(run)
        (run / left.name).unlink()  # from the start it would be another run
        self.kill_daemon()
        self.wait_until(lambda: self.ask("status")["fault"])
        self.assertIn("began from a checkpoint that was brought there", self.ask("status")["fault"])
        (run / left.name).write_bytes(left.read_bytes())
        self.assertEqual(self.ask("status")["state"], "EMPTY")
        self.kill_daemon()
        self.meniscus("wait", "--for", "step=11", "--timeout", "60")

    def test_a_checkpoint_of_an_older_version_is_taken_with_a_warning(self) -> None:
        out = self.home / "older"
        first = self.batch(out, "--until", "0.1")
        for own in out.glob("checkpoint-*.hdf"):
            seal = bytearray(own.read_bytes()[:512])
            seal[40:64] = bytes(24)  # how far the journal had come
            seal[504:] = struct.pack("<Q", xxh64(bytes(seal), 504, 0))
            own.write_bytes(bytes(seal) + own.read_bytes()[512:])
        again = self.batch(out, "--until", "0.1", "--resume", "auto")
        self.assertEqual((again["steps"], again["state_hash"]), (first["steps"], first["state_hash"]))
        self.assertIn("is taken all the same", again["said"])
        self.assertIn("see whether this run wrote it", again["said"])

    def test_what_was_set_before_a_checkpoint_comes_back_with_it(self) -> None:
        run = self.run_of("set-before")
        self.meniscus("step", "4")
        self.meniscus("set", "gravity=[0, -2]", "end_time=2")
        self.meniscus("step", "4")
        kept = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("set", "gravity=[0.5, -1]", "end_time=0.05", "scheme.cfl=0.1")
        self.meniscus("resume")
        self.meniscus("wait", "--for", "state=DONE")
        for _ in range(2):
            self.meniscus("restore", kept)
            values = self.ask("get", "gravity", "end_time")["values"]
            self.assertEqual([values[key]["value"] for key in ("gravity", "end_time")], ["[0, -2]", 2.0])
            self.meniscus("step", str(HASH_STEPS))
            self.assert_comes_back(run)
        self.meniscus("stop")

    def test_a_checkpoint_of_a_time_line_that_was_left_is_refused(self) -> None:
        run = self.run_of("left-line")
        self.meniscus("step", "5")
        first = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("step", "5")
        left = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("restore", first)
        self.meniscus("step", "8")
        (run / "abandoned" / left).rename(run / left)
        self.assert_refused(run, left, "is of a time line that this run has left: record ")
        self.meniscus("restore", first)
        self.meniscus("step", "2")
        self.assert_comes_back(run)

    def test_a_run_that_began_from_a_checkpoint_alone_goes_back_to_it(self) -> None:
        run, left = self.brought("bequest", "heir", "--set", "gravity=[0, -2]")
        self.meniscus("load", *CASE, "--name", "heir", "--resume")
        self.meniscus("step", "5")
        self.meniscus("restore", left.name)
        self.meniscus("step", "2")
        self.assertEqual(self.ask("status")["step"], 8)
        self.assert_comes_back(run)

    def whatever(self, *words: str) -> None:
        """A command that may be refused."""
        subprocess.run([BUILD / "meniscus", *words], env=self.environment, capture_output=True, timeout=60)

    def do_something(self, chance: random.Random) -> None:
        time = self.ask("status")["time"]
        words = chance.choice([
            ["step", str(chance.randint(1, 40))], ["run-until", f"{time + chance.uniform(0.001, 0.03):.5f}"],
            ["run-until", f"{time + 0.01:.5f}", "--whole-steps"], ["set", f"gravity=[{chance.uniform(-1, 1):.3f}, -1]"],
            ["set", f"scheme.cfl={chance.uniform(0.1, 0.3):.3f}"], ["set", f"threads={chance.randint(1, 2)}"],
            ["checkpoint"], ["snapshot"], ["restore"], ["reset"], ["rollback", str(self.ask("status")["case_version"] - 1)], ["breakpoint", "b", "--time", f"{time + 0.004:.5f}"], ["pause"],
        ])
        self.whatever(*words)

    def test_what_was_taken_back_is_told_and_replayed(self) -> None:
        run = self.run_of("back")
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("step", "20")
        self.meniscus("rollback", "1")
        self.meniscus("step", str(HASH_STEPS))
        change = next(r for r in self.log(run) if r["command"] == "rollback")
        self.assertEqual(change["changes"], [{"path": "gravity", "before": "[0, -2]", "after": "[0, -1]"}])
        self.assertTrue(self.replay(run)["agrees"])

    def test_a_run_that_diverged_and_went_on_is_replayed_along_that(self) -> None:
        for back, by_step in itertools.product(("restore", "reset"), (True, False)):
            with self.subTest(back=back, by_step=by_step):
                run = self.run_of(f"fallen-{back}-{by_step}")
                self.meniscus("step", "20")
                self.meniscus("checkpoint")
                self.meniscus("set", "gravity=[0, -1e6]")
                if by_step:
                    self.meniscus("step", "300", code=70)
                else:
                    self.meniscus("resume")
                    self.meniscus("wait", "--for", "state=FAULT")
                fallen = self.ask("status")["step"]
                self.replay(run)
                self.meniscus(back)
                self.meniscus("set", "gravity=[0, -1]")
                self.meniscus("step", "150")
                again = self.replay(run)
                self.assertEqual((again["agrees"], again["steps"]), (True, fallen + 150))
                self.assertGreaterEqual(again["compared"], 4)

    def test_a_run_that_goes_on_from_a_checkpoint_of_its_start_is_replayed(self) -> None:
        """What was set before that is in it, and has changed the state of the start."""
        for end in (self.kill_daemon, self.leave_and_come_back):
            run = self.run_of(f"from-the-start-{end.__name__}")
            self.meniscus("set", "gravity=[0, -4]")
            if end == self.kill_daemon:
                self.meniscus("checkpoint")
            end()
            self.meniscus("wait", "--for", "state=READY", "--timeout", "60")
            self.meniscus("step", "10")
            self.assertTrue(self.replay(run)["agrees"])
            self.meniscus("stop")

    def test_all_of_a_run_is_replayed_whose_crash_led_back_to_the_start(self) -> None:
        run = self.run_of("led-back", "--set", "output.checkpoint_interval=0", "--set", "output.checkpoint_wall_interval=0")
        self.meniscus("step", "350")
        self.meniscus("reset")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=READY", "--timeout", "60")
        self.meniscus("step", "10")
        hashes = sum(r["kind"] == "hash" for r in self.log(run))
        replayed = self.replay(run)
        self.assertEqual((replayed["agrees"], replayed["compared"], replayed["steps"]), (True, hashes, 360))

    def test_what_is_recorded_on_the_way_back_is_replayed(self) -> None:
        """A command that is called off, and one whose deadline passes."""
        run = self.run_of("on-the-way", "--set", "output.checkpoint_interval=0", "--set", "output.checkpoint_wall_interval=0", "--set", "end_time=1000")
        scheduled = f"{0xca11ed0ff:032x}"
        self.meniscus("set", "gravity=[0.1, -1]", "--at-step", "900000", "--no-wait", "--id", scheduled)
        self.meniscus("step", "3000")
        self.kill_daemon()
        while self.ask("status")["state"] != "RECOVERING":
            time.sleep(0.001)
        self.meniscus("cancel", scheduled)
        self.meniscus("set", "gravity=[0.2, -1]", "--timeout", "0.05", code=124)
        self.assertEqual(self.ask("status")["state"], "RECOVERING")
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        self.meniscus("step", "5")
        self.assertTrue(self.replay(run)["agrees"])

    def test_a_replay_that_computes_otherwise_is_found_at_the_first_state(self) -> None:
        run = self.run_of("otherwise")
        self.meniscus("step", str(HASH_STEPS + 5))
        self.meniscus("stop")
        words = [BUILD / "meniscus", "replay", run, "--verify"]
        plain = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(plain.returncode, 0)
        old = subprocess.run(words, env=self.environment | old_machine(), capture_output=True, text=True, timeout=60)
        self.assertEqual(old.returncode, 1)
        self.assertIn("the last that agreed was that of step 0", old.stderr)
        self.assertIn("computed with fused products and sums", old.stderr)

    def test_a_replay_computes_with_the_arithmetic_of_the_run(self) -> None:
        run = self.home / "of-an-old-machine"
        words = [BUILD / "meniscusd", "--batch", *CASE, "--set", "end_time=0.2", "--out", run]
        subprocess.run(words, env=self.environment | old_machine(), check=True, capture_output=True, timeout=60)
        begun = self.log(run)[0]
        self.assertEqual((begun["level"], begun["arithmetic"]), ("x86-64", "separate"))
        self.assertTrue(self.replay(run)["agrees"])

    def test_a_changed_byte_is_found_and_named(self) -> None:
        run = self.run_of("changed")
        self.meniscus("step", "3")
        self.meniscus("stop")
        whole = (run / "journal").read_bytes()
        begins = [r["offset"] for r in self.log(run)]
        for at in range(0, len(whole), 97 if at_length() else 389):
            (run / "journal").write_bytes(whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1:])
            said = self.meniscus("log", str(run), "--verify", code=74).stderr
            record = sum(begin <= at for begin in begins)
            if record:
                self.assertIn(f"record {record}, which begins at byte {begins[record - 1]}", said)
            self.replay(run, code=74)
        (run / "journal").write_bytes(whole)
        self.assertIn("whole", self.meniscus("log", str(run), "--verify").stdout)

    def test_a_journal_that_was_cut_off_before_a_checkpoint_is_found_with_the_place(self) -> None:
        def cut(run: Path, records: int) -> None:
            at = self.log(run)[records]["offset"]
            journal = run / "journal"
            journal.write_bytes(journal.read_bytes()[:at])

        run = self.run_of("commanded")
        for _ in range(4):
            self.meniscus("step", "2")
            self.meniscus("checkpoint")
        self.meniscus("stop")
        self.assertIn("whole", self.meniscus("log", str(run), "--verify").stdout)
        whole, n = (run / "journal").read_bytes(), len(self.log(run))
        cut(run, n // 2)
        said = self.meniscus("log", str(run), "--verify", code=74).stderr
        self.assertRegex(said, rf"ends with record {n // 2}, at byte {(run / 'journal').stat().st_size}, and had \d+ records when "
                               r"checkpoint-0000000008.hdf was written")
        self.assertIn("ends with record", self.meniscus("replay", str(run), "--verify", code=74).stderr)
        (run / "journal").write_bytes(whole[: self.log(run)[-1]["offset"] + 50])  # within a record, as a crash leaves it
        self.assertIn("ends with record", self.meniscus("log", str(run), "--verify", code=74).stderr)

        run = self.home / "by-itself"  # nobody commands anything
        words = [BUILD / "meniscusd", "--batch", *CASE, "--out", run, "--until", "2", "--set", "output.checkpoint_interval=1"]
        subprocess.run(words, env=self.environment, check=True, capture_output=True, timeout=60)
        self.meniscus("log", str(run), "--verify")
        cut(run, len(self.log(run)) // 2)
        self.assertIn("ends with record", self.meniscus("log", str(run), "--verify", code=74).stderr)

    def test_a_journal_that_was_cut_off_before_a_restore_or_reset_is_found_with_the_place(self) -> None:
        """The checkpoint that knows of its end is in abandoned/."""
        for back in ("restore", "reset"):
            run = self.run_of(f"cut-before-{back}")
            self.meniscus("step", "2")
            first = Path(self.ask("checkpoint")["path"]).name
            self.meniscus("step", "2")
            self.meniscus("checkpoint")
            middle = len(self.log(run)) - 3
            self.meniscus(back, *([first] if back == "restore" else []))
            self.meniscus("set", "gravity=[0, -2]")
            self.meniscus("stop")
            self.assertIn("whole", self.meniscus("log", str(run), "--verify").stdout)
            journal = run / "journal"
            journal.write_bytes(journal.read_bytes()[: self.log(run)[middle]["offset"]])
            for words in (("log", str(run), "--verify"), ("replay", str(run), "--verify")):
                said = self.meniscus(*words, code=74).stderr
                self.assertRegex(said, rf"ends with record {middle}, at byte {journal.stat().st_size}, and had \d+ records when "
                                       r"abandoned/checkpoint-0000000004.hdf was written")  # fmt: skip

    def test_a_journal_that_was_cut_off_and_written_on_is_found(self) -> None:
        """By a checkpoint that was left, also when a later one agrees with what was written."""
        out, kept = self.home / "written-on", self.home / "kept"
        self.batch(out, "--until", "0.05")
        self.cut(out, 1)
        kept.mkdir()
        for path in out.glob("checkpoint-*.hdf"):  # while they are not there, nothing tells
            path.rename(kept / path.name)
        self.batch(out, "--until", "0.1")  # anew
        for path in kept.iterdir():
            path.rename(out / "abandoned" / path.name)
        self.assertIn("is another than when abandoned/checkpoint-", self.meniscus("log", str(out), "--verify", code=74).stderr)
        self.assertIn("is another than when abandoned/checkpoint-", self.meniscus("replay", str(out), "--verify", code=74).stderr)

    def cut(self, run: Path, records: int, more: int = 0) -> None:
        """Leave so many records of a journal, and some bytes of the next."""
        journal = run / "journal"
        journal.write_bytes(journal.read_bytes()[: self.log(run)[records]["offset"] + more])

    def files(self, run: Path) -> dict[str, bytes]:
        return {str(path.relative_to(run)): path.read_bytes() for path in run.rglob("*") if path.is_file() and path.name != "lock"}

    def test_a_batch_run_does_not_go_on_with_a_journal_that_was_cut_off(self) -> None:
        out = self.home / "cut-batch"
        done = self.batch(out, "--until", "0.1")
        whole = (out / "journal").read_bytes()
        n = len(self.log(out))
        for records, more in ((n // 2, 0), (n // 2, 30), (1, 0), (0, 0), (0, 20)):
            (out / "journal").write_bytes(whole)
            self.cut(out, records, more)
            before = self.files(out)
            told = self.batch(out, "--until", "0.2", "--resume", "auto", code=74)
            said = told["error"]["message"]
            self.assertIn(f"ends with record {records}, at byte " if records else "it has no record", said)
            self.assertRegex(said, r"had \d+ records when checkpoint-\d{10}\.hdf was written")
            self.assertIn("Copy that checkpoint into a new directory", said)
            self.assertIn("--out", told["error"]["hint"])
            self.assertEqual((told["error"]["status"], self.files(out)), ("corrupt", before))
        new = self.home / "cut-batch-new"  # the ways on
        new.mkdir()
        last = max(out.glob("checkpoint-*.hdf"))
        shutil.copy(last, new)
        went_on = self.batch(new, "--until", "0.2", "--resume", "auto")
        (out / "journal").write_bytes(whole)
        self.assertEqual(self.batch(out, "--until", "0.2", "--resume", "auto")["state_hash"], went_on["state_hash"])
        self.cut(out, 2)
        self.batch(out, "--until", "0.1", "--resume", "auto", code=74)
        anew = self.batch(out, "--until", "0.1", "--overwrite")
        self.assertEqual(anew["state_hash"], done["state_hash"])
        self.batch(out, "--until", "0.2", "--resume", "auto")

    def test_a_run_that_begins_anew_over_a_damaged_journal_can_go_on(self) -> None:
        """It has a journal of its own. The other is kept, with the checkpoints that tell of the damage unless they are overwritten."""
        whole = self.home / "whole-batch"
        self.batch(whole, "--until", "0.05")
        self.batch(whole, "--until", "0.1", "--resume", "auto")
        damages: "dict[str, Callable[[Path], None]]" = {
            "half": lambda path: os.truncate(path, path.stat().st_size // 2),
            "empty": lambda path: os.truncate(path, 0),
            "byte": lambda path: path.write_bytes(path.read_bytes()[:200] + b"\xff" + path.read_bytes()[201:]),
            "noise": lambda path: path.write_bytes(b"noise" * 20),
            "pipe": lambda path: (path.unlink(), os.mkfifo(path))[1],
        }
        for damage, spoil in damages.items():
            for how in ((), ("--overwrite",)):
                with self.subTest(damage, how=how):
                    out = self.home / f"anew-{damage}{len(how)}"
                    shutil.copytree(whole, out)
                    spoil(out / "journal")
                    self.batch(out, "--until", "0.2", "--resume", "auto", code=74)
                    before = self.files(out)
                    said = self.meniscus("run", *CASE, "--threads", "1", "--out", str(out), "--until", "0.02", *how).stderr
                    self.assertIn(f"and is {out}/abandoned/journal: ", said)
                    kept = self.files(out / "abandoned")
                    self.assertEqual(kept.get("journal"), before.get("journal"))
                    checkpoints = {name: data for name, data in before.items() if name.startswith("checkpoint-")}
                    self.assertEqual({name: kept.get(name) for name in checkpoints}, dict.fromkeys(checkpoints) if how else checkpoints)
                    if damage in ("half", "byte", "noise") and not how:
                        self.meniscus("log", f"{out}/abandoned", "--verify", code=74)
                    for until in ("0.03", "0.04"):
                        self.batch(out, "--until", until, "--resume", "auto")
                        self.assertIn("whole", self.meniscus("log", str(out), "--verify").stdout)
                    self.assertTrue(self.replay(out)["agrees"])
                    self.batch(out, "--until", "0.02")  # and the next one adds to the same journal
                    self.assertFalse((out / "abandoned.2" / "journal").exists())

    def test_a_run_that_cannot_begin_leaves_a_damaged_journal_where_it_was(self) -> None:
        out = self.home / "anew-refused"
        self.batch(out, "--until", "0.05")
        os.truncate(out / "journal", (out / "journal").stat().st_size // 2)
        before = self.files(out)
        (out / "case.yaml").unlink()
        (out / "case.yaml").mkdir()
        (out / "case.yaml" / "notes").touch()
        for how in ((), ("--overwrite",)):
            self.batch(out, "--until", "0.1", *how, code=74)
            left = self.files(out)
            self.assertEqual({name: left.get(name) for name in before if name != "case.yaml"}, {k: v for k, v in before.items() if k != "case.yaml"})
            self.assertFalse((out / "abandoned").exists())

    def test_a_daemon_begins_a_run_beside_one_whose_journal_was_cut_off_and_goes_on_with_it(self) -> None:
        run = self.run_of("begun-beside")
        self.meniscus("step", "3")
        self.meniscus("checkpoint")
        self.meniscus("stop")
        self.cut(run, 2)
        before = self.files(run)
        self.meniscus("load", *CASE, "--name", run.name, "--resume", code=74)
        beside = Path(self.ask("load", *CASE, "--name", run.name)["message"])
        self.assertEqual(beside, run.with_name(f"{run.name}.2"))
        self.meniscus("step", "2")
        self.leave_and_come_back()
        self.meniscus("wait", "--for", "step=2", "--timeout", "60")
        self.assertEqual(Path(self.ask("load", *CASE, "--name", run.name, "--resume")["message"]), beside)
        self.assertEqual(self.files(run), before)

    def test_a_record_that_a_crash_has_torn_behind_the_last_checkpoint_holds_nothing_up(self) -> None:
        out = self.home / "torn-batch"
        self.batch(out, "--until", "0.1")  # its last record, of the shutdown, is behind the last checkpoint
        self.cut(out, len(self.log(out)) - 1, 30)
        self.batch(out, "--until", "0.2", "--resume", "auto")
        self.assertIn("whole", self.meniscus("log", str(out), "--verify").stdout)

        run = self.run_of("torn")
        self.meniscus("step", "5")
        self.meniscus("checkpoint")
        self.meniscus("set", "gravity=[0, -2]")
        before = self.ask("status")["state_hash"]
        self.meniscus("set", "gravity=[0, -3]")
        self.daemon.kill()
        self.daemon.wait()
        self.cut(run, max(k for k, r in enumerate(self.log(run)) if r["command"] == "set"), 30)
        type(self).start_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        self.assertEqual(self.ask("status")["state_hash"], before)
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -2]")

    def test_a_daemon_does_not_go_on_with_a_journal_that_was_cut_off(self) -> None:
        run = self.run_of("cut-daemon")
        self.meniscus("step", "3")
        first = Path(self.ask("checkpoint")["path"]).name
        self.meniscus("set", "gravity=[0, -2]")
        self.meniscus("step", "3")
        self.meniscus("checkpoint")
        said = "records when checkpoint-0000000006.hdf was written"
        for more in (0, 30):
            self.daemon.kill()
            self.daemon.wait()
            whole = (run / "journal").read_bytes()
            self.cut(run, 4, more)
            before = self.files(run)
            type(self).start_daemon()
            self.wait_until(lambda: self.ask("status")["fault"])
            status = self.ask("status")
            self.assertEqual((status["state"], status["fault_reason"]), ("EMPTY", "corrupt"))
            self.assertIn("ends with record 4, at byte ", status["fault"])
            self.assertIn(said, status["fault"])
            self.assertIn("start again", status["fault"])
            self.assertIn(said, self.meniscus("load", *CASE, "--name", run.name, "--resume", code=74).stderr)
            self.assertEqual(self.files(run), before)
            if more:
                self.meniscus("load", *CASE, "--name", "beside-cut")
                self.meniscus("step", "1")
                self.assertIsNone(self.ask("status")["fault"])
                self.meniscus("load", *CASE, "--name", run.name, "--resume", code=74)  # and the present run stays
                self.assertEqual(self.ask("status")["step"], 1)
                self.meniscus("stop")
            (run / "journal").write_bytes(whole)
            if not more:
                self.kill_daemon()
                self.meniscus("wait", "--for", "step=6", "--timeout", "60")
                self.assertIn("whole", self.meniscus("log", str(run), "--verify").stdout)

        self.meniscus("load", *CASE, "--name", run.name, "--resume")  # one that was left tells of it too
        self.meniscus("restore", first)
        self.daemon.kill()
        self.daemon.wait()
        for own in run.glob("checkpoint-*.hdf"):
            own.unlink()
        self.cut(run, 4)
        type(self).start_daemon()
        self.wait_until(lambda: self.ask("status")["fault"])
        self.assertIn("records when abandoned/checkpoint-0000000006.hdf was written", self.ask("status")["fault"])
        (self.home / "state" / "current").unlink()
        self.kill_daemon()
        self.assertIsNone(self.ask("status")["fault"])

    def test_a_checkpoint_is_behind_the_record_of_what_was_set_before_it(self) -> None:
        """Also where both are served between the same two steps."""
        run = self.run_of("in-one-round", "--set", "output.checkpoints_kept=99")
        self.meniscus("start")
        with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
            socket.setsockopt(zmq.LINGER, 0)
            socket.connect(f"ipc://{self.home}/run/meniscus/default/control.ipc")
            for k in range(20):
                change = pb.Request(major=1, id=secrets.token_bytes(16))
                change.set.assignments.add(path="gravity", value=f"[0, {-1 - 0.01 * k}]")
                for request in (change, pb.Request(major=1, id=secrets.token_bytes(16), checkpoint=pb.CheckpointNow())):
                    socket.send(request.SerializeToString())
                for _ in range(2):
                    self.assertTrue(socket.poll(20000))
                    socket.recv()
        self.meniscus("pause")
        records = [r for r in self.log(run) if r["kind"] == "command" and r["command"] in ("set", "checkpoint")]
        for change, written in zip(records[::2], records[1::2]):
            self.assertEqual((change["command"], written["command"]), ("set", "checkpoint"))
            seal = Path(written["reply"].get("path") or run / f"checkpoint-{written['reply']['effect_step']:010d}.hdf").read_bytes()[:64]
            self.assertGreaterEqual(struct.unpack_from("<Q", seal, 40)[0], change["number"])

    def test_a_journal_without_a_record_is_not_whole_and_what_is_no_file_is_none(self) -> None:
        run = self.run_of("emptied")
        journal = run / "journal"
        self.meniscus("stop")
        whole = journal.read_bytes()
        for left in (0, 3, 8, 9):
            journal.write_bytes(whole[:left])
            self.assertIn("has no record", self.meniscus("log", str(run), "--verify", code=74).stderr)
        journal.unlink()
        os.mkfifo(journal)
        self.assertIn("is no file", self.meniscus("log", str(run), code=74).stderr)
        self.assertFalse(self.replay(run, code=74)["agrees"])

    def test_a_batch_run_has_a_journal_too(self) -> None:
        out = self.home / "batch"
        words = [BUILD / "meniscusd", "--batch", *CASE, "--out", out, "--set", "end_time=0.3"]
        for more in (["--until", "0.1"], ["--resume", "auto"]):
            subprocess.run([*words, *more], env=self.environment, check=True, capture_output=True, timeout=60)
        told = [r["command"] for r in self.log(out) if r["kind"] == "command"]
        self.assertEqual(told, ["load", "run_until", "shutdown", "load", "start", "shutdown"])
        # When it is shut down there is no simulation any more, and so no time of it.
        self.assertEqual([r["time"] is None for r in self.log(out) if r["kind"] == "command"], [False, False, True] * 2)
        self.assertTrue(self.replay(out)["agrees"])

    def test_a_directory_without_a_journal_is_said_so(self) -> None:
        self.assertIn("no journal", self.meniscus("log", str(self.home), code=74).stderr)
        self.assertIn("--verify", self.meniscus("replay", str(self.home), code=2).stderr)


if __name__ == "__main__":
    unittest.main()

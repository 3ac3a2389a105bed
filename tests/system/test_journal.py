#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The journal of a run: it tells who changed what, it can be replayed to the same bits, and no changed byte escapes it."""

import itertools
import os
import random
import struct
import subprocess
import sys
import time
import unittest
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, at_length, old_machine  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import journal_pb2  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=30", "--set", "threads=1"]
COMMANDS = 40 if at_length() else 15  # of a random time line
HASH_STEPS = 100


class Journal(DaemonTest):
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
        for words in (["checkpoint-0000000007.hdf"], []):  # by its name, and as the newest
            refused = self.meniscus("restore", *words, code=1).stderr
            self.assertIn("is a checkpoint of another case", refused)
            self.assertIn("fluids[0].density", refused)
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
        self.run_of("bequest", "--set", "gravity=[0, -2]")
        self.meniscus("step", "6")
        left = Path(self.ask("checkpoint")["path"])
        self.meniscus("stop")
        run = self.home / "state" / "heir"
        run.mkdir()
        (run / left.name).write_bytes(left.read_bytes())
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
        run = self.run_of("written-on")
        self.meniscus("step", "3")
        self.meniscus("checkpoint")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED")
        self.assertIn("whole", self.meniscus("log", str(run), "--verify").stdout)
        self.daemon.kill()
        self.daemon.wait()
        (run / "journal").write_bytes((run / "journal").read_bytes()[: self.log(run)[1]["offset"]])
        type(self).start_daemon()
        self.meniscus("wait", "--for", "step=3")
        for k in range(6):
            self.meniscus("set", f"end_time={k + 40}")
        self.assertIn("is another than when checkpoint-", self.meniscus("log", str(run), "--verify", code=74).stderr)

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

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A daemon that is killed at random moments comes back to where it was: nothing that was answered is lost, nothing is done twice.

MENISCUS_KILLS says how often it is killed; 5 unless it is set, 12 in `make nightly`.
"""

import fcntl
import json
import os
import random
import re
import secrets
import signal
import subprocess
import sys
import threading
import time
import unittest
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any, Callable

import h5py
import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, at_length, free_ports, of_nightly, start_in  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import Client  # noqa: E402
from meniscus import meniscus_pb2 as pb  # noqa: E402

KILLS = int(os.environ.get("MENISCUS_KILLS", "12" if at_length() else "5"))
CASE = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=1000", "--set", "threads=1",
        "--set", "output.checkpoint_interval=0.1", "--set", "output.snapshot_interval=0.4"]
BACK_S = 20.0  # the longest that anybody has to wait for an answer after a kill
PATIENCE_S = 60.0
FAR_S = 2.0  # of steps since the last checkpoint


class Crash(DaemonTest):
    def supervise(self, kills: int, chance: random.Random, done: threading.Event) -> None:
        """Kill the daemon and start it again, as systemd would."""
        for _ in range(kills):
            time.sleep(chance.uniform(0.02, 0.6))
            self.daemon.kill()
            self.daemon.wait()
            began = time.monotonic()
            type(self).start_daemon()
            self.send(pb.Request(major=1, id=secrets.token_bytes(16), status=pb.GetStatus()))
            self.slowest = max(self.slowest, time.monotonic() - began)
        done.set()

    def send(self, request: "pb.Request") -> bytes:
        """Send until there is a reply, always under the same id: the reply, as it came."""
        endpoint = f"ipc://{self.home}/run/meniscus/default/control.ipc"
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
                socket.setsockopt(zmq.LINGER, 0)
                socket.connect(endpoint)
                socket.send(request.SerializeToString())
                if socket.poll(500):
                    return socket.recv()
        raise AssertionError(f"no reply to {request} in {PATIENCE_S} s")

    def command(self, chance: random.Random, k: int) -> "pb.Request":
        request = pb.Request(major=1, id=secrets.token_bytes(16))
        if chance.random() < 0.5:
            request.step.count = chance.randint(1, 60)
        else:
            request.set.assignments.add(path="gravity", value=f"[{1e-3 * (k % 7):.4f}, -1]")
            request.set.assignments.add(path="end_time", value=str(1001 + k))
        return request

    def test_nothing_is_lost_and_nothing_done_twice(self) -> None:
        chance = random.Random(7)
        self.slowest = 0.0
        self.meniscus("load", *CASE, "--name", "killed")
        run = self.home / "state" / "killed"
        done = threading.Event()
        supervisor = threading.Thread(target=self.supervise, args=(KILLS, random.Random(11), done))
        supervisor.start()
        steps, sent, value = 0, [], "1000"
        while not done.is_set():
            request = self.command(chance, len(sent))
            packed = self.send(request)
            reply = pb.Reply.FromString(packed)
            self.assertEqual(reply.code, pb.OK, reply.message)
            sent.append((request, packed))
            if request.HasField("step"):
                steps += request.step.count
                self.assertEqual(reply.step, steps, "each step is done once")
            else:
                value = request.set.assignments[1].value
            again, answered = chance.choice(sent)
            self.assertEqual(self.send(again), answered, "the first answer, and nothing is done")
        supervisor.join()
        self.meniscus("wait", "--for", f"state={'PAUSED' if steps else 'READY'}", "--timeout", str(PATIENCE_S))  # back from the last kill
        status = self.ask("status")
        self.assertEqual((status["state"] == "READY", status["step"]), (steps == 0, steps))
        self.assertEqual(float(self.ask("get", "end_time")["values"]["end_time"]["value"]), float(value))
        self.check_journal(run, sent)
        self.check_files(run)
        self.assertLess(self.slowest, BACK_S)
        print(f"{KILLS} kills, {len(sent)} commands, {steps} steps, back in {self.slowest:.2f} s at most", file=sys.stderr)

    def check_journal(self, run: Path, sent: "list[tuple[pb.Request, bytes]]") -> None:
        records: list[dict[str, Any]] = self.ask("log", str(run))["records"]
        done = [r["id"] for r in records if r["kind"] == "command" and r["id"]]
        for request, _ in sent:
            self.assertEqual(done.count(request.id.hex()), 1)
        self.assertTrue(self.ask("replay", str(run), "--verify", timeout=300)["agrees"])

    def check_files(self, run: Path) -> None:
        files = sorted(run.glob("*.hdf"))
        self.assertGreater(len(files), 2)
        for file in files:
            with h5py.File(file) as opened:
                self.assertGreater(len(opened), 0)
        index = json.loads((run / "snapshots.hdf.series").read_text())
        self.assertEqual(sorted(entry["name"] for entry in index["files"]), [file.name for file in files if file.name.startswith("snapshot-")])

    def test_what_was_paused_stays_paused_to_the_bit(self) -> None:
        self.meniscus("load", *CASE, "--name", "paused")
        self.meniscus("step", "30")
        self.meniscus("checkpoint")
        self.meniscus("set", "gravity=[0.1, -1]")
        self.meniscus("run-until", "0.2")
        self.meniscus("breakpoint", "later", "--time", "0.9")
        before = self.ask("status")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        after = self.ask("status")
        for key in ("state", "step", "time", "state_hash", "breakpoints"):
            self.assertEqual(after[key], before[key], key)

    def test_breakpoints_that_were_passed_are_listed_and_halt_nothing_again(self) -> None:
        """Set before the checkpoint that is gone back to, and behind it; a condition that is true still, and one that is not yet."""
        self.meniscus("load", *CASE, "--name", "passed")
        self.meniscus("breakpoint", "early", "--when", "step > 20")
        self.meniscus("breakpoint", "fifth", "--step", "5")
        for step in ("5", "21"):
            self.meniscus("resume" if step != "5" else "start")
            self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            self.assertEqual(str(self.ask("status")["step"]), step)
        self.meniscus("checkpoint")
        self.meniscus("breakpoint", "late", "--when", "step > 30")
        self.meniscus("breakpoint", "far", "--when", "step > 400")
        self.meniscus("resume")
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        self.meniscus("step", "5")
        before = self.ask("status")
        self.assertEqual((before["step"], len(before["breakpoints"])), (36, 4))
        self.meniscus("resume")
        self.meniscus("set", "gravity=[0.1, -1]")
        for _ in range(2):
            self.kill_daemon()
            while self.ask("status")["state"] == "RECOVERING":
                time.sleep(0.01)
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        after = self.ask("status")
        self.assertEqual((after["step"], after["breakpoints"]), (401, before["breakpoints"]))

    def test_snapshots_that_somebody_asked_for_are_there_again(self) -> None:
        """After the checkpoint that is gone back to, then from the beginning; at once, scheduled, and one that another command overtook."""
        run = Path(self.ask("load", *CASE, "--set", "output.checkpoint_interval=0", "--name", "shown")["message"])
        asked = [self.ask("snapshot", "--fields", "density,acceleration")["path"]]
        self.meniscus("step", "30")
        self.meniscus("checkpoint")
        self.meniscus("snapshot", "--at-step", "41", "--no-wait")
        self.meniscus("run-until", "0.4")
        asked += [self.ask("snapshot", "--fields", "acceleration")["path"], str(run / "snapshot-0000000041.hdf")]
        self.meniscus("step", "7")
        before, had = self.ask("status"), {path: self.contents(path) for path in asked}
        self.assertTrue(all("acceleration" in had[path] for path in asked[:2]))
        for end in range(3):
            if end == 2:
                (run / "checkpoint-0000000030.hdf").unlink()
            self.kill_daemon()
            self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            self.assertEqual(self.ask("status")["state_hash"], before["state_hash"])
            self.meniscus("snapshot")  # the writer has written all that it had
            self.assertEqual({path: self.contents(path) for path in asked}, had)
        self.assertTrue(self.ask("replay", str(run), "--verify")["agrees"])

    def contents(self, path: str) -> "dict[str, bytes]":
        with h5py.File(path) as file:
            return {name: data[:].tobytes() for name, data in file["VTKHDF/PointData"].items()}

    def test_snapshots_of_a_checkpoints_own_step_outlive_it(self) -> None:
        """A second crash finds the checkpoint damaged, and goes back further."""
        run = Path(self.ask("load", *CASE, "--set", "output.checkpoint_interval=0", "--name", "outlived")["message"])
        for step in ("20", "10"):
            self.meniscus("step", step)
            self.meniscus("checkpoint")
        path = self.ask("snapshot", "--fields", "acceleration")["path"]
        had = self.contents(path)
        self.leave_and_come_back()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        self.meniscus("snapshot")  # of the same step: it has no less
        self.assertEqual(self.contents(path), had)
        self.meniscus("step", "5")
        for _ in range(2):
            self.kill_daemon()
            self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            self.assertEqual(self.contents(path), had)
            (run / "checkpoint-0000000030.hdf").write_bytes(b"no checkpoint")

    def test_what_is_set_before_the_first_step_is_in_the_outputs_of_the_start(self) -> None:
        """Also after a crash, and where somebody has asked for a snapshot before."""
        starts = []
        for name, asks, dies in (("plain", False, False), ("shown-first", True, False), ("died", True, True), ("set-out", False, True)):
            run = Path(self.ask("load", *CASE, "--set", "output.checkpoint_interval=0", "--name", name)["message"])
            if asks:
                self.meniscus("snapshot", "--fields", "acceleration")
            self.meniscus("set", "gravity=[0, -3]")
            self.meniscus("step", "3") if name != "set-out" else self.meniscus("run-until", "0")  # which has outputs, and no step
            if name == "set-out":
                self.meniscus("set", "gravity=[0, -1]")
            if dies:
                self.kill_daemon()
                self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            self.meniscus("stop")
            shown = self.contents(str(run / "snapshot-0000000000.hdf"))
            self.assertEqual("acceleration" in shown, asks)
            with h5py.File(run / "probes.hdf") as file:
                starts.append((shown["pressure"], float(file["probes/potential"][0])))
        self.assertEqual(len(set(starts)), 1)

    def test_what_a_breakpoint_or_the_end_has_halted_stands_there(self) -> None:
        """Whatever ended the daemon, and what is commanded then is commanded there."""
        run = self.home / "state" / "halted"
        self.meniscus("load", *CASE, "--set", "end_time=0.93", "--name", run.name)
        self.meniscus("breakpoint", "early", "--time", "0.53")  # where there is no checkpoint
        self.meniscus("start")
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        for end in (self.kill_daemon, self.leave_and_come_back, self.kill_daemon):
            before = self.ask("status")
            end()
            while self.ask("status")["state"] in ("EMPTY", "RECOVERING"):
                time.sleep(0.01)
            after = self.ask("status")
            for key in ("state", "step", "time", "state_hash", "breakpoints"):
                self.assertEqual(after[key], before[key], key)
            self.assertEqual(self.ask("set", "gravity=[0.1, -1]")["effect_step"], before["step"])
        self.meniscus("resume")
        self.meniscus("wait", "--for", "state=DONE", "--timeout", "60")
        self.meniscus("set", "gravity=[0.4, -1]", "--at-step", "100000", "--no-wait")
        before = self.ask("status")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=DONE", "--timeout", "60")
        after = self.ask("status")
        for key in ("state_hash", "scheduled"):
            self.assertEqual(after[key], before[key], key)
        self.assertEqual(len(after["scheduled"]), 1)
        told = [(r["step"], r["kind"]) for r in self.ask("log", str(run))["records"] if r["kind"] == "halted"]
        self.assertEqual((len(told), told[-1]), (2, (before["step"], "halted")))
        self.meniscus("restore")
        self.assertTrue(self.ask("replay", str(run), "--verify")["agrees"])

    def test_a_condition_that_was_looked_at_without_a_step_halts_nothing_after(self) -> None:
        for checkpoint in (False, True):
            self.meniscus("load", *CASE, "--set", "output.checkpoint_interval=0", "--name", f"looked-at-{checkpoint}")
            self.meniscus("step", "20")
            if checkpoint:
                self.meniscus("checkpoint")
            self.meniscus("breakpoint", "true", "--when", "step > 0")
            self.meniscus("run-until", repr(self.ask("status")["time"]))
            self.meniscus("breakpoint", "later", "--step", "30")
            self.kill_daemon()
            self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            self.meniscus("resume")
            self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            self.assertEqual(self.ask("status")["step"], 30)

    def test_a_restore_to_the_start_begins_the_series_at_its_first_row(self) -> None:
        """Which what was set since has changed: whoever has that row is told."""
        run = Path(self.ask("load", *CASE, "--name", "started-over")["message"])
        self.meniscus("checkpoint")
        self.meniscus("step", "30")
        self.meniscus("restore", "checkpoint-0000000000.hdf")
        self.meniscus("set", "gravity=[0, -3]")
        self.meniscus("step", "30")
        self.meniscus("stop")
        with h5py.File(run / "probes.hdf") as file:
            self.assertEqual((file["step"][0], file["lines/row"][-1]), (0, 0))

    def test_many_crashes_make_no_record_longer(self) -> None:
        run = Path(self.ask("load", *CASE, "--set", "output.checkpoint_interval=0", "--name", "crashed-often")["message"])
        self.meniscus("step", "10")
        self.meniscus("checkpoint")
        self.meniscus("set", "gravity=[0.1, -1]")
        self.meniscus("step", "5")
        sizes = [(run / "journal").stat().st_size]
        for _ in range(5):
            self.kill_daemon()
            self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
            sizes.append((run / "journal").stat().st_size)
        grown = [b - a for a, b in zip(sizes[1:], sizes[2:])]
        self.assertLess(max(grown) - min(grown), 16, sizes)  # numbers may have a digit more

    def test_what_has_diverged_in_a_step_is_in_fault_again(self) -> None:
        """Else somebody could have a checkpoint of that, from which nobody could go on."""
        run = Path(self.ask("load", *CASE, "--name", "diverged")["message"])
        self.meniscus("step", "30")
        self.meniscus("checkpoint")
        self.meniscus("set", "gravity=[0, 1e9]")
        self.meniscus("step", "1000", code=70)
        before = self.ask("status")
        self.assertEqual(before["state"], "FAULT")
        self.assertIn("diverged", self.meniscus("set", "gravity=[0, 0]", code=1).stderr)
        for end in (self.kill_daemon, self.leave_and_come_back, self.kill_daemon):
            end()
            self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
            after = self.ask("status")
            for key in ("step", "time", "state_hash", "fault_reason"):
                self.assertEqual(after[key], before[key], key)
            self.meniscus("checkpoint", code=1)
        self.assertEqual(max(path.name for path in run.glob("checkpoint-*")), "checkpoint-0000000030.hdf")
        self.assertTrue(self.ask("replay", str(run), "--verify")["agrees"])
        self.meniscus("restore")
        self.assertEqual(self.ask("status")["step"], 30)
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=READY", "--timeout", "60")

    def test_a_formula_that_fails_at_the_end_of_a_shortened_step_fails_there_again(self) -> None:
        """It has no value at one time alone, which no other step meets."""
        run = Path(self.ask("load", *CASE, "--name", "formula")["message"])
        self.meniscus("step", "30")
        self.meniscus("checkpoint")
        self.meniscus("set", "gravity=[0, log(abs(t - 0.3))]")
        self.meniscus("run-until", "0.3", code=1)
        before = self.ask("status")
        self.assertIn("gravity", before["fault"])
        for _ in range(2):
            self.kill_daemon()
            self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
            after = self.ask("status")
            for key in ("step", "time", "state_hash", "fault_reason"):
                self.assertEqual(after[key], before[key], key)
        self.assertTrue(self.ask("replay", str(run), "--verify")["agrees"])

    def test_a_pipe_in_the_place_of_current_holds_nobody_up(self) -> None:
        run = Path(self.ask("load", *CASE, "--name", "piped")["message"])
        current = run.parent / "current"
        noted = current.read_bytes()
        for back in (False, True):
            self.daemon.kill()
            self.daemon.wait()
            current.unlink()
            if back:
                current.write_bytes(noted)
            else:
                os.mkfifo(current)
            type(self).start_daemon()
            self.meniscus("wait", "--for", "state=READY" if back else "state=EMPTY", "--timeout", "60")
            self.assertEqual("current" in str(self.ask("status")), not back)

    def test_what_was_running_goes_on(self) -> None:
        self.meniscus("load", *CASE, "--name", "running", "--start")
        self.meniscus("wait", "--for", "step=50")
        self.kill_daemon()
        self.meniscus("wait", "--for", "step=100", "--timeout", "60")
        self.assertEqual(self.ask("status")["state"], "RUNNING")

    def test_a_step_under_way_ends_where_it_was_to_end(self) -> None:
        request = pb.Request(major=1, id=secrets.token_bytes(16), step=pb.Step(count=3000))
        self.meniscus("load", *CASE, "--name", "under-way")
        asking = threading.Thread(target=lambda: setattr(self, "late", pb.Reply.FromString(self.send(request))))
        asking.start()
        self.meniscus("wait", "--for", "step=200")
        self.kill_daemon()
        asking.join()
        reply: Any = getattr(self, "late")
        self.assertEqual((reply.code, reply.state, reply.step), (pb.OK, pb.PAUSED, 3000))

    def step_by_command(self, count: int) -> None:
        reply = self.ask("step", str(count))
        self.late = reply["state"], reply["step"]

    def step_by_python(self, count: int) -> None:
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            reply = client.step(count)
        self.late = reply.state, reply.step

    def test_clients_hear_of_their_step_over_a_crash(self) -> None:
        self.meniscus("load", *CASE, "--name", "over")
        steps = 0
        for step in (self.step_by_command, self.step_by_python):
            self.late: Any = None
            asking = threading.Thread(target=step, args=(3000,))
            asking.start()
            self.meniscus("wait", "--for", f"step={steps + 200}")
            self.kill_daemon()
            asking.join()
            steps += 3000
            self.assertEqual(self.late, ("PAUSED", steps))

    def come_back_slowly(self, name: str, under_way: bool = False) -> int:
        """A run that has far to go after a crash, as it has no checkpoint but the first; the step it was at. Under way: to more of them."""
        self.meniscus("load", *CASE, "--set", "output.checkpoint_interval=1000", "--name", name)
        began, steps = time.monotonic(), 0
        while time.monotonic() < began + FAR_S:
            self.meniscus("step", "4000")
            steps += 4000
        if under_way:
            stepping = subprocess.Popen([BUILD / "meniscus", "step", "1000000"], env=self.environment, stderr=subprocess.DEVNULL)
            self.addCleanup(stepping.wait)
            self.meniscus("wait", "--for", f"step={steps + 1}")
        self.kill_daemon()
        until = time.monotonic() + 20
        while not (status := self.ask("status")).get("step") and time.monotonic() < until:
            pass  # there is no run yet, or its particles are placed
        self.assertEqual(status["state"], "RECOVERING")
        if not under_way:
            self.assertEqual(status["recovery_step"], steps)
        return steps

    @of_nightly
    def test_whoever_asks_meanwhile_is_answered_and_who_changes_something_waits(self) -> None:
        steps = self.come_back_slowly("meanwhile")
        setting = subprocess.Popen([BUILD / "meniscus", "set", "gravity=[0, -2]"], env=self.environment,
                                   stdout=subprocess.DEVNULL)
        late = self.meniscus("--timeout", "0.05", "set", "gravity=[0, -3]", code=124).stderr
        self.assertIn("before the run was back", late)
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -1]")
        self.assertEqual(self.ask("status")["state"], "RECOVERING")
        self.assertEqual(setting.wait(PATIENCE_S), 0)
        status = self.ask("status")
        self.assertEqual((status["state"], status["step"], status["recovery_step"]), ("PAUSED", steps, None))
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -2]")

    @of_nightly
    def test_who_watches_on_the_way_back_is_told_and_can_leave(self) -> None:
        steps = self.come_back_slowly("watched")
        self.assertIn(f"\ncoming back to step {steps}, ", self.meniscus("status").stdout)
        with subprocess.Popen([BUILD / "meniscus", "watch"], env=self.environment, stdout=subprocess.PIPE, text=True) as watch:
            assert watch.stdout
            self.assertRegex(watch.stdout.readline(), rf"^RECOVERING t = .* step \d+ of {steps} ")
            watch.send_signal(signal.SIGINT)
            self.assertEqual(watch.wait(PATIENCE_S), -signal.SIGINT)
        before, shown = self.ask("top", "--once")["daemons"][0], self.meniscus("top", "--once").stdout
        after = self.ask("status")
        self.assertEqual((after["state"], before["recovery_step"]), ("RECOVERING", steps))
        share = re.search(r"(?m)^default +RECOVERING +\S+ +([\d.]+)%", shown)
        assert share, shown
        # From 10 % on it is shown in whole ones.
        self.assertTrue(before["step"] / steps - 6e-3 <= float(share[1]) / 100 <= after["step"] / steps + 1e-2, (before, shown, after))
        self.assertLess(after["time"] / after["end_time"], before["step"] / steps - 1e-3, "which is not the share of the run")

    @of_nightly
    def test_a_stop_on_the_way_back_is_done_at_once_and_for_good(self) -> None:
        steps = self.come_back_slowly("stopped-on-the-way")
        before = self.ask("status")["step"]
        reply = self.ask("stop")
        self.assertEqual(reply["state"], "EMPTY")
        self.assertLess(before, steps)
        self.assertTrue(0 < before <= reply["effect_step"] < steps, "where it was stopped, not where it was to be")
        self.assertIn(f"to step {steps}, which it had not reached", reply["message"])
        self.kill_daemon()
        self.assertEqual(self.ask("status")["state"], "EMPTY")

    @of_nightly
    def test_what_a_stop_on_the_way_back_calls_off_is_replayed(self) -> None:
        self.come_back_slowly("called-off", under_way=True)
        self.meniscus("stop")
        run = next((self.home / "state").glob("called-off*"))
        self.assertEqual([r["command"] for r in self.ask("log", str(run))["records"] if r["command"]][-2:], ["step", "stop"])
        self.assertTrue(self.ask("replay", str(run), "--verify")["agrees"])

    @of_nightly
    def test_who_leaves_on_the_way_back_comes_back_the_next_time(self) -> None:
        steps = self.come_back_slowly("left-on-the-way")
        self.daemon.terminate()
        self.assertEqual(self.daemon.wait(60), 0)
        type(self).start_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", str(PATIENCE_S))
        self.assertEqual(self.ask("status")["step"], steps)

    def test_what_a_signal_has_called_off_does_not_go_on(self) -> None:
        self.meniscus("load", *CASE, "--name", "called-off")
        stepping = subprocess.Popen([BUILD / "meniscus", "step", "100000"], env=self.environment, stderr=subprocess.PIPE)
        self.meniscus("wait", "--for", "step=50", "--timeout", "60")
        self.leave_and_come_back()
        stepping.communicate(timeout=60)
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        step = self.ask("status")["step"]
        time.sleep(0.3)
        self.assertEqual((self.ask("status")["state"], self.ask("status")["step"]), ("PAUSED", step))
        self.assertGreaterEqual(step, 50)

    def test_a_signal_ends_no_run(self) -> None:
        """As systemd gives, when the machine or the service is started again."""
        self.meniscus("load", *CASE, "--name", "signalled", "--start")
        self.meniscus("wait", "--for", "step=50")
        self.leave_and_come_back()
        self.meniscus("wait", "--for", "step=100", "--timeout", "60")
        self.assertEqual(self.ask("status")["state"], "RUNNING")
        self.meniscus("pause")
        self.meniscus("set", "gravity=[0.1, -1]")
        before = self.ask("status")
        self.leave_and_come_back()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        after = self.ask("status")
        for key in ("step", "time", "state_hash", "case_version"):
            self.assertEqual(after[key], before[key], key)
        self.meniscus("step", "10")
        self.meniscus("shutdown")
        self.daemon.wait(60)
        type(self).start_daemon()
        self.assertEqual(self.ask("status")["state"], "EMPTY", "whoever asks for the end gets it")
        self.assertTrue(self.ask("replay", str(self.home / "state" / "signalled"), "--verify")["agrees"])

    def test_what_was_answered_in_a_run_before_the_last_is_not_done_again(self) -> None:
        step = pb.Request(major=1, id=secrets.token_bytes(16), step=pb.Step(count=10))
        gravity = pb.Request(major=1, id=secrets.token_bytes(16))
        gravity.set.assignments.add(path="gravity", value="[0, -2]")
        self.meniscus("load", *CASE, "--name", "before")
        answers = [self.send(request) for request in (step, gravity)]
        self.meniscus("load", *CASE, "--name", "last")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=READY", "--timeout", "60")
        self.assertEqual([self.send(request) for request in (step, gravity)], answers)
        status = self.ask("status")
        self.assertEqual((status["state"], status["step"]), ("READY", 0))
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -1]")

    def test_samples_that_are_damaged_keep_no_run_from_coming_back(self) -> None:
        self.meniscus("load", *CASE, "--name", "samples")
        self.meniscus("step", "30")
        self.meniscus("checkpoint")
        self.meniscus("step", "20")
        before = self.ask("status")
        samples = self.home / "state" / "samples" / "probes.hdf"
        self.daemon.kill()
        self.daemon.wait()
        whole = samples.read_bytes()
        damaged = whole[: len(whole) // 2] + bytes([whole[len(whole) // 2] ^ 1]) + whole[len(whole) // 2 + 1 :]
        samples.write_bytes(damaged)
        type(self).start_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        after = self.ask("status")
        self.assertEqual((after["step"], after["state_hash"]), (before["step"], before["state_hash"]))
        self.assertEqual(samples.with_name("probes.hdf.damaged").read_bytes(), damaged)
        self.assertIn("probes.hdf was damaged", (samples.parent / "log").read_text())

    def test_a_journal_that_is_gone_is_told(self) -> None:
        self.meniscus("load", *CASE, "--name", "untold")
        self.meniscus("step", "10")
        journal = self.home / "state" / "untold" / "journal"
        whole = journal.read_bytes()
        for spoil in (journal.unlink, lambda: journal.write_bytes(b""), lambda: journal.write_bytes(whole[:8])):
            self.daemon.kill()
            self.daemon.wait()
            spoil()
            type(self).start_daemon()
            self.wait_until(lambda: self.ask("status")["fault"])
            status = self.ask("status")
            self.assertEqual(status["state"], "EMPTY")
            self.assertIn(str(journal.parent), status["fault"])
            self.assertIn("start the daemon again", self.meniscus("resume", code=1).stderr)
            journal.write_bytes(whole)
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        self.assertEqual(self.ask("status")["step"], 10)

    def test_a_run_directory_that_is_gone_is_told_and_the_daemon_goes_on(self) -> None:
        self.meniscus("load", *CASE, "--name", "moved")
        self.meniscus("step", "10")
        run, away = self.home / "state" / "moved", self.home / "away"
        self.daemon.kill()
        self.daemon.wait()
        run.rename(away)
        type(self).start_daemon()
        self.wait_until(lambda: self.ask("status")["fault"])
        status = self.ask("status")
        self.assertIn(str(run), status["fault"])
        self.assertIn("directory is not there", status["fault"])
        self.assertIn("status` says why", self.meniscus("resume", code=1).stderr)
        self.kill_daemon()  # it is told again
        self.wait_until(lambda: self.ask("status")["fault"])
        self.meniscus("load", *CASE, "--name", "beside")  # and the daemon takes commands
        self.assertIsNone(self.ask("status")["fault"])
        self.meniscus("stop")

        self.meniscus("load", *CASE, "--name", "moved-back")
        self.meniscus("step", "10")
        run = self.home / "state" / "moved-back"
        self.daemon.kill()
        self.daemon.wait()
        run.rename(self.home / "away-too")
        type(self).start_daemon()
        self.wait_until(lambda: self.ask("status")["fault"])
        (self.home / "away-too").rename(run)
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        self.assertEqual(self.ask("status")["step"], 10)

    def test_a_run_that_was_ended_may_be_taken_away(self) -> None:
        self.meniscus("load", *CASE, "--name", "ended")
        ident = "0123456789abcdef0123456789abcd13"
        self.meniscus("stop", "--id", ident)
        (self.home / "state" / "ended").rename(self.home / "put-away")
        self.kill_daemon()
        time.sleep(0.3)
        status = self.ask("status")
        self.assertEqual((status["state"], status["fault"]), ("EMPTY", None))

    def test_what_was_stopped_stays_stopped(self) -> None:
        self.meniscus("load", *CASE, "--name", "stopped")
        self.meniscus("stop")
        self.kill_daemon()
        self.assertEqual(self.ask("status")["state"], "EMPTY")


class Current(DaemonTest):
    """What stands in the way of the run that was loaded last, or of a new one, is named, with what to do."""

    def again(self, put: "Callable[[Path], object]") -> str:
        """The fault of a daemon that begins with something else in place of `current`, which it leaves alone."""
        self.daemon.kill()
        self.daemon.wait()
        current = self.home / "state" / "current"
        if current.is_dir() and not current.is_symlink():
            current.rmdir()
        else:
            current.unlink(missing_ok=True)
        put(current)
        type(self).daemon = start_in(self.home, self.environment, self.options)
        self.wait_until(lambda: self.ask("status")["fault"])
        self.assertTrue(current.is_symlink() or current.exists())
        return str(self.ask("status")["fault"])

    def test_what_is_in_place_of_the_name_of_the_last_run(self) -> None:
        current = self.home / "state" / "current"
        for put, found in (
            (lambda path: path.write_bytes(b"gar\tbage \x80\xff/\nx"), 'begins with "gar\\tbage \ufffd\ufffd/", where the name of its directory belongs'),
            (lambda path: path.write_bytes(b""), "is empty, where the name of its directory belongs"),
            (lambda path: path.mkdir(), "is a directory, where a file with the name of its directory belongs"),
            (lambda path: path.symlink_to("dambreak2d"), "is a link to 'dambreak2d', which is not there, where"),
            (lambda path: path.symlink_to("/"), "is a link to '/', which is a directory, where"),
            (lambda path: path.symlink_to("current"), "is a link to 'current', which is not there, where"),
            (os.mkfifo, "is a pipe, where"),
        ):
            with self.subTest(found):
                fault = self.again(put)
                self.assertIn(f"the last run of {self.home}/state, which was not ended, cannot be gone on with: '{current}' {found}", fault)
                self.assertIn(f"mend that and start again, or remove '{current}' to begin without that run", fault)

    def test_a_file_in_place_of_the_directory_of_the_last_run(self) -> None:
        (self.home / "state" / "mine").write_text("notes")
        fault = self.again(lambda path: path.write_text("mine\n"))
        self.assertIn("its directory is not there, in its place is a file; put it back", fault)

    def test_a_file_in_place_of_a_directory(self) -> None:
        (self.home / "file").write_text("notes")
        (self.home / "link").symlink_to("nowhere")
        run = ["run", *CASE, "--set", "end_time=0", "--out"]
        for out, found in (("file", "file' is a file"), ("file/below", "file' is a file"), ("link", "link' is a link to 'nowhere', which is not there")):
            said = self.meniscus(*run, str(self.home / out), code=74).stderr
            self.assertIn(f"{found}, where a directory is to be; move it away, or choose another place", said)
        self.meniscus("log", str(self.home / "file"), code=74)
        done = subprocess.run([BUILD / "meniscusd", "--name", "other", "--state-dir", self.home / "file"], env=self.environment,
                              capture_output=True, text=True, timeout=60)  # fmt: skip
        self.assertEqual(done.returncode, 74)
        self.assertIn("file' is a file, where a directory is to be", done.stderr)
        self.assertEqual((self.home / "file").read_text(), "notes")


class WithACase(DaemonTest):
    """A daemon whose command line has a case, started again by the same one."""

    options = ["--load", "dambreak2d", "--set", "resolution=8", "--set", "end_time=1000", "--set", "threads=1", "--start"]

    def runs(self) -> "list[str]":
        return sorted(run.name for run in (self.home / "state").iterdir() if run.is_dir())

    def test_the_same_command_line_goes_on_with_the_run_it_had(self) -> None:
        self.meniscus("wait", "--for", "step=50")
        self.kill_daemon()
        self.meniscus("wait", "--for", "step=100", "--timeout", "60")
        self.assertEqual((self.ask("status")["state"], self.runs()), ("RUNNING", ["dambreak2d"]))
        self.meniscus("pause")
        self.meniscus("set", "gravity=[0.1, -1]")
        before = self.ask("status")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=PAUSED", "--timeout", "60")
        after = self.ask("status")
        for key in ("step", "state_hash"):
            self.assertEqual(after[key], before[key], key)
        self.assertEqual(self.runs(), ["dambreak2d"])
        self.meniscus("stop")
        self.meniscus("load", *CASE, "--name", "another")
        self.kill_daemon()
        self.meniscus("wait", "--for", "state=READY", "--timeout", "60")
        self.assertEqual(self.runs(), ["another", "dambreak2d"])

        type(self).options = [*self.options, "--set", "gravity=[0, -2]"]
        self.addCleanup(setattr, type(self), "options", self.options[:-2])
        self.kill_daemon()
        self.meniscus("wait", "--for", "step=10", "--timeout", "60")
        self.assertEqual(self.runs(), ["another", "dambreak2d", "dambreak2d.2"])

    def hold(self, run: str) -> None:
        """Have the directory of a run, as another program would; to the end of the test."""
        lock = open(Path(run) / "lock", "rb")
        self.addCleanup(lock.close)
        fcntl.flock(lock, fcntl.LOCK_EX)

    def test_when_the_run_directory_is_gone_all_tell_it_and_nothing_is_begun_anew(self) -> None:
        self.kill_daemon()  # it has no run, and loads another one
        self.meniscus("wait", "--for", "step=50", "--timeout", "60")
        run, port = Path(self.ask("status")["run_directory"]), free_ports()
        self.daemon.kill()
        self.daemon.wait()
        run.rename(self.home / "elsewhere")
        runs = self.runs()
        type(self).daemon = start_in(self.home, self.environment, [*self.options, "--http", str(port)])
        self.wait_until(lambda: self.ask("status")["fault"])
        status, listed = self.ask("status"), self.ask("ls")["daemons"][0]
        for told in (status, listed):
            self.assertEqual(told["state"], "EMPTY")
            self.assertIn(f"the run of {run}, which was not ended, cannot be gone on with: its directory is not there", told["fault"])
        self.assertEqual(status["fault_reason"], "not found")
        self.assertIn("its directory is not there", self.meniscus("ls").stdout)
        self.assertIn("its directory is not there", subprocess.run([BUILD / "meniscus", "doctor"], env=self.environment, capture_output=True, text=True).stdout)
        for page, code in (("readyz", 200), ("readyz?run=loaded", 503)):
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{port}/{page}", timeout=20) as answer:
                    found, text = answer.status, answer.read()
            except urllib.error.HTTPError as refused:
                found, text = refused.code, refused.read()
            self.assertEqual((found, json.loads(text)["fault_reason"]), (code, "not found"))
            self.assertEqual(json.loads(text)["reason"], status["fault"])
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=20) as answer:
            self.assertIn("\nmeniscus_run_missing 1\n", answer.read().decode())
        self.assertEqual(self.runs(), runs)
        (self.home / "elsewhere").rename(run)
        self.kill_daemon()
        self.meniscus("wait", "--for", "step=51", "--timeout", "60")
        with self.assertRaises(urllib.error.URLError):  # that was another daemon
            urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=20)
        self.assertIsNone(self.ask("ls")["daemons"][0]["fault"])
        self.assertEqual(self.runs(), sorted([*runs, run.name]))

    def test_when_the_run_directory_is_empty_it_is_one_that_is_gone(self) -> None:
        """As the place where a file system is to be mounted."""
        self.kill_daemon()  # it has no run, and loads another one
        self.meniscus("wait", "--for", "step=50", "--timeout", "60")
        run = Path(self.ask("status")["run_directory"])
        self.daemon.kill()
        self.daemon.wait()
        run.rename(self.home / "unmounted")
        run.mkdir()
        runs = self.runs()
        for options in (self.options, []):
            type(self).daemon = start_in(self.home, self.environment, options)
            self.wait_until(lambda: self.ask("status")["fault"])
            status = self.ask("status")
            self.assertEqual((status["state"], status["fault_reason"]), ("EMPTY", "not found"))
            self.assertIn(f"the run of {run}, which was not ended, cannot be gone on with: its directory is empty; put its files back", status["fault"])
            self.assertEqual((self.runs(), list(run.iterdir())), (runs, []))
            self.end_daemon()
        run.rmdir()
        (self.home / "unmounted").rename(run)
        type(self).start_daemon()
        self.meniscus("wait", "--for", "step=51", "--timeout", "60")
        self.assertEqual(self.runs(), runs)

    def test_what_cannot_be_gone_on_with_is_not_begun_anew(self) -> None:
        self.kill_daemon()  # it has no run, and loads another one
        self.meniscus("wait", "--for", "step=50", "--timeout", "60")
        self.meniscus("set", "gravity=[0.1, -1]")
        runs, run = self.runs(), self.ask("status")["run_directory"]
        self.daemon.kill()
        self.daemon.wait()
        command = [BUILD / "meniscusd", "--name", "default", "--state-dir", self.home / "state"]
        self.hold(run)
        done = subprocess.run([*command, *self.options], env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 75, done.stderr)
        type(self).daemon = start_in(self.home, self.environment, [])  # a service
        self.wait_until(lambda: self.ask("status")["fault"])
        for _ in range(2):
            status = self.ask("status")
            self.assertEqual(status["state"], "EMPTY")
            self.assertIn("no run is gone on with", status["fault"])
            self.meniscus("load", *CASE, "--name", Path(run).name, "--resume", code=1)  # which is refused, and changes nothing
        self.doCleanups()
        self.assertEqual(self.runs(), runs)
        self.kill_daemon()
        self.meniscus("wait", "--for", "step=51", "--timeout", "60")
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0.1, -1]")

    def test_who_came_for_one_case_is_told_by_an_exit_code_that_its_journal_is_damaged(self) -> None:
        self.kill_daemon()  # it has no run, and loads another one
        self.meniscus("wait", "--for", "step=50", "--timeout", "60")
        self.meniscus("checkpoint")
        journal = Path(self.ask("status")["run_directory"]) / "journal"
        self.daemon.kill()
        self.daemon.wait()
        whole = journal.read_bytes()
        journal.write_bytes(whole[:60] + bytes([whole[60] ^ 1]) + whole[61:])
        done = subprocess.run([BUILD / "meniscusd", "--name", "default", "--state-dir", self.home / "state", *self.options],
                              env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn(f"'{journal}' is damaged: record 1", done.stderr)
        journal.write_bytes(whole)
        self.assertTrue(list(journal.parent.glob("checkpoint-*.hdf")))
        journal.write_bytes(whole[: self.ask("log", str(journal.parent))["records"][1]["offset"]])  # its end is cut off
        cut = journal.read_bytes()
        done = subprocess.run([BUILD / "meniscusd", "--name", "default", "--state-dir", self.home / "state", *self.options],
                              env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn(f"'{journal}' is damaged: it ends with record 1", done.stderr)
        self.assertEqual(journal.read_bytes(), cut)
        journal.write_bytes(whole)
        type(self).start_daemon()
        self.meniscus("wait", "--for", "step=50", "--timeout", "60")


if __name__ == "__main__":
    unittest.main()

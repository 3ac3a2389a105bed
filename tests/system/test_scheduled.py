#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Commands that wait for a step or a time: they take effect there and nowhere else, also when the daemon is killed in between.

MENISCUS_KILLS says how often it is killed; 4 unless it is set, 8 in `make nightly`.
"""

import asyncio
import os
import random
import secrets
import subprocess
import sys
import time
import unittest
from pathlib import Path
from typing import Any

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, at_length  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import AsyncClient, Client, OutputFile  # noqa: E402
from meniscus import meniscus_pb2 as pb  # noqa: E402

KILLS = int(os.environ.get("MENISCUS_KILLS", "8" if at_length() else "4"))
CASE = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=1000", "--set", "threads=1",
        "--set", "output.checkpoint_interval=0.1"]
LIMIT = 64
PATIENCE_MS = 20000


def set_gravity(value: str) -> "pb.Set":
    return pb.Set(assignments=[pb.Assignment(path="gravity", value=value)])


class Scheduled(DaemonTest):
    def setUp(self) -> None:
        self.context = zmq.Context()
        self.addCleanup(self.context.term)
        self.socket = self.connect()
        self.meniscus("load", *CASE, "--name", self.id().split(".")[-1][:60])
        self.run_directory = Path(self.ask("status")["run_directory"])

    def connect(self) -> "zmq.Socket[bytes]":
        socket = self.context.socket(zmq.DEALER)
        self.addCleanup(socket.close, 0)
        socket.connect(f"ipc://{self.home}/run/meniscus/default/control.ipc")
        return socket

    def say(self, socket: "zmq.Socket[bytes]", **words: Any) -> "pb.Request":
        request = pb.Request(major=1, **{"id": secrets.token_bytes(16), **words})
        socket.send(request.SerializeToString())
        return request

    def hear(self, socket: "zmq.Socket[bytes]", code: int = 0) -> "pb.Reply":
        self.assertTrue(socket.poll(PATIENCE_MS), "no reply")
        reply = pb.Reply.FromString(socket.recv())
        self.assertEqual(reply.code, code, reply.message)
        return reply

    def give(self, code: int = 0, **words: Any) -> "pb.Reply":
        self.say(self.socket, **words)
        return self.hear(self.socket, code)

    def give_apart(self, **words: Any) -> "pb.Reply":
        """Over a connection of its own, which no other reply comes by."""
        socket = self.connect()
        self.say(socket, **words)
        return self.hear(socket)

    def silent(self, socket: "zmq.Socket[bytes]") -> None:
        self.assertFalse(socket.poll(100), "nothing is answered before its effect")

    def pending(self) -> "list[pb.Scheduled]":
        return list(self.give(status=pb.GetStatus()).status.scheduled)

    def accepted(self, n: int) -> "list[pb.Scheduled]":
        """What waits, once so many do: who is silent has been heard at some time only."""
        until = time.monotonic() + PATIENCE_MS / 1000
        while len(self.pending()) < n and time.monotonic() < until:
            time.sleep(0.01)
        return self.pending()

    def gravity(self) -> str:
        return str(self.ask("get", "gravity")["values"]["gravity"]["value"])

    def back(self) -> None:
        self.kill_daemon()
        self.socket = self.connect()
        until = time.monotonic() + PATIENCE_MS / 1000
        while self.give(status=pb.GetStatus()).state not in (pb.READY, pb.PAUSED) and time.monotonic() < until:
            time.sleep(0.02)

    def replays(self) -> None:
        for threads in ("1", "2"):
            self.assertTrue(self.ask("replay", str(self.run_directory), "--verify", "--threads", threads)["agrees"])

    # --- when -------------------------------------------------------------------------------------------------------------

    def test_it_takes_effect_at_exactly_that_step_and_is_answered_then(self) -> None:
        waiting = self.connect()
        self.say(waiting, set=set_gravity("[0, -2]"), at_step=30)
        self.silent(waiting)
        self.assertEqual([(s.at_step, s.who, s.what) for s in self.accepted(1)],
                         [(30, "local", "set gravity = [0, -2], at step 30")])
        self.assertEqual(self.give(step=pb.Step(count=29)).case_version, 1)
        self.silent(waiting)
        self.assertEqual(self.give(step=pb.Step(count=11)).case_version, 2)
        reply = self.hear(waiting)
        self.assertEqual((reply.effect_step, reply.values.values[0].text), (30, "[0, -2]"))
        self.assertEqual(self.pending(), [])
        self.replays()

    def test_at_a_time_a_step_ends_exactly_there(self) -> None:
        waiting = self.connect()
        self.say(waiting, pause=pb.Pause(), at_time=0.123)
        self.silent(waiting)
        self.accepted(1)
        self.assertEqual(self.give(pb.ABORTED, step=pb.Step(count=5000)).time, 0.123)
        self.assertEqual(self.hear(waiting).time, 0.123)
        self.assertEqual(self.give(status=pb.GetStatus()).state, pb.PAUSED)
        self.give(step=pb.Step(count=120))
        self.replays()

    def test_two_for_one_step_come_in_the_order_in_which_they_were_accepted(self) -> None:
        sockets = [self.connect() for _ in range(3)]
        for socket, value in zip(sockets, ("-4", "-2", "-3")):
            self.say(socket, set=set_gravity(f"[0, {value}]"), at_step=20, no_wait=True)
            self.hear(socket)
        self.give(step=pb.Step(count=20))
        self.assertEqual(self.gravity(), "[0, -3]")
        changes = [r["changes"][0]["after"] for r in self.ask("log", str(self.run_directory))["records"] if r["changes"]]
        self.assertEqual(changes, ["[0, -4]", "[0, -2]", "[0, -3]"])

    def test_whoever_waits_for_a_step_finds_done_what_was_scheduled_for_it(self) -> None:
        for k in range(1, 21):
            self.give(set=set_gravity(f"[0, -{k + 1}]"), at_step=3 * k, no_wait=True)
            waiting = self.connect()
            self.say(waiting, wait=pb.Wait(step=3 * k))
            self.say(self.socket, step=pb.Step(count=3))
            self.hear(waiting)
            self.assertEqual(self.give_apart(status=pb.GetStatus()).status.case_version, k + 1)
            self.hear(self.socket)

    def test_files_are_of_that_step(self) -> None:
        sockets = [self.connect() for _ in range(3)]
        self.say(sockets[0], checkpoint=pb.CheckpointNow(), at_step=12)
        self.say(sockets[1], snapshot=pb.SnapshotNow(fields=["velocity"]), at_step=13)
        self.say(sockets[2], rollback=pb.Rollback(version=1), at_step=14)
        self.silent(sockets[0])
        self.accepted(3)
        self.give(step=pb.Step(count=40))
        for socket, step in zip(sockets, (12, 13)):
            reply = self.hear(socket)
            self.assertEqual((reply.effect_step, reply.output.step), (step, step))
            self.assertTrue(Path(reply.output.path).exists())
        self.assertEqual(self.hear(sockets[2]).effect_step, 14)

    # --- what is refused ---------------------------------------------------------------------------------------------------

    def refused(self, code: int, path: str, part: str, **words: Any) -> None:
        reply = self.give(code, **words)
        self.assertEqual(reply.path, path)
        self.assertIn(part, reply.message)

    def test_what_cannot_be_is_refused_at_once(self) -> None:
        self.give(step=pb.Step(count=5))
        invalid = pb.INVALID_ARGUMENT
        self.refused(invalid, "at_step", "step 4 is past: the run is at step 5", pause=pb.Pause(), at_step=4)
        self.refused(invalid, "at_time", "between the present time", pause=pb.Pause(), at_time=0.001)
        self.refused(invalid, "at_time", "the end time, 1000 s", pause=pb.Pause(), at_time=1001)
        self.refused(invalid, "at_time", "finite", pause=pb.Pause(), at_time=float("nan"))
        self.refused(invalid, "at_step", "which of the two", pause=pb.Pause(), at_step=9, at_time=1)
        self.refused(invalid, "if_step", "takes no if_step", pause=pb.Pause(), at_step=9, if_step=9)
        self.refused(invalid, "no_wait", "for what is scheduled", pause=pb.Pause(), no_wait=True)
        for command in (dict(step=pb.Step()), dict(status=pb.GetStatus()), dict(breakpoint=pb.SetBreakpoint())):
            self.refused(invalid, "at_step", "cannot be scheduled", at_step=9, **command)
        self.refused(invalid, "gravity", "a list of 3", set=set_gravity("[0, 0, 1]"), at_step=9)
        self.refused(invalid, "resolution", "", set=pb.Set(assignments=[pb.Assignment(path="resolution", value="20")]), at_step=9)
        self.refused(invalid, "gravity[1]", "no finite number", set=set_gravity("[0, 1/(t - t)]"), at_step=9)
        self.refused(pb.NOT_FOUND, "version", "no version 7", rollback=pb.Rollback(version=7), at_step=9)
        self.refused(pb.NOT_FOUND, "fields", "no field", snapshot=pb.SnapshotNow(fields=["x"]), at_step=9)
        self.assertEqual(self.pending(), [])

    def test_without_a_run_nothing_is_scheduled(self) -> None:
        self.give(stop=pb.Stop())
        reply = self.give(pb.FAILED_PRECONDITION, pause=pb.Pause(), at_step=4)
        self.assertEqual(list(reply.allowed), [pb.READY, pb.RUNNING, pb.PAUSED, pb.DONE])

    def test_there_is_an_end_to_how_many_wait(self) -> None:
        for k in range(LIMIT):
            self.give(pause=pb.Pause(), at_step=1000 + k, no_wait=True)
        self.assertEqual(len(self.pending()), LIMIT)
        self.refused(pb.RESOURCE_EXHAUSTED, "", "64 commands scheduled", pause=pb.Pause(), at_step=9)

    def test_it_is_checked_again_when_it_takes_effect(self) -> None:
        epoch = self.give(lease=pb.Lease(ttl_ms=3000, holder="anna")).lease.epoch
        late, other = self.connect(), self.connect()
        self.say(late, set=set_gravity("[0, -2]"), at_step=10, lease_epoch=epoch)
        self.say(other, set=set_gravity("[0, -3]"), at_step=10, if_version=1, lease_epoch=epoch)
        self.silent(late)
        self.accepted(2)
        time.sleep(3)
        self.give(set=set_gravity("[0, -9]"))
        self.give(step=pb.Step(count=20))
        self.assertEqual(self.hear(late, pb.ABORTED).path, "lease_epoch")
        self.hear(other, pb.ABORTED)
        self.say(other, set=set_gravity("[0, -3]"), at_step=30, if_version=2)
        self.silent(other)
        self.accepted(1)
        self.give(set=set_gravity("[0, -8]"))
        self.give(step=pb.Step(count=20))
        self.assertEqual(self.hear(other, pb.FAILED_PRECONDITION).path, "if_version")
        self.assertEqual(self.gravity(), "[0, -8]")
        self.replays()

    # --- what takes it away ------------------------------------------------------------------------------------------------

    def test_it_can_be_cancelled_and_its_deadline_holds(self) -> None:
        waiting, late = self.connect(), self.connect()
        request = self.say(waiting, set=set_gravity("[0, -2]"), at_step=10)
        self.say(late, set=set_gravity("[0, -3]"), at_step=10, deadline_ms=200)
        self.silent(waiting)
        self.accepted(1)
        self.give(cancel=pb.Cancel(id=request.id))
        self.assertEqual(self.hear(waiting, pb.ABORTED).message, "cancelled")
        self.hear(late, pb.DEADLINE_EXCEEDED)
        self.give(pb.NOT_FOUND, cancel=pb.Cancel(id=request.id))
        self.back()
        self.assertEqual(self.pending(), [])
        self.give(step=pb.Step(count=20))
        self.assertEqual(self.gravity(), "[0, -1]")

    def test_a_reset_restore_load_and_stop_take_all_away(self) -> None:
        self.give(checkpoint=pb.CheckpointNow())
        for command in (dict(reset=pb.Reset()), dict(checkpoint=pb.CheckpointNow()), dict(restore=pb.Restore()), dict(stop=pb.Stop())):
            waiting = self.connect()
            self.say(waiting, pause=pb.Pause(), at_step=10)
            self.silent(waiting)
            self.accepted(1)
            self.give(**command)
            if "checkpoint" in command:
                self.assertEqual(len(self.pending()), 1)
                continue
            self.hear(waiting, pb.ABORTED)
            self.assertEqual(self.pending(), [])
        self.assertIn("stopped on request", self.ask("log", str(self.run_directory))["records"][-2]["reply"]["message"])

    # --- who does not wait, and who asks twice ------------------------------------------------------------------------------

    def test_who_does_not_wait_hears_that_it_is_scheduled_and_can_ask_again(self) -> None:
        words: dict[str, Any] = dict(id=secrets.token_bytes(16), set=set_gravity("[0, -2]"), at_step=10)
        for _ in range(2):
            reply = self.give(no_wait=True, **words)
            self.assertFalse(reply.HasField("effect_step"))
            self.assertIn("scheduled: set gravity = [0, -2], at step 10", reply.message)
        waiting = self.connect()
        self.say(waiting, **words)
        self.silent(waiting)
        self.accepted(1)
        self.give(step=pb.Step(count=12))
        self.assertEqual(self.hear(waiting).effect_step, 10)
        self.assertEqual(self.give(no_wait=True, **words).effect_step, 10)
        self.assertEqual(self.give(status=pb.GetStatus()).case_version, 2)

    # --- clients -----------------------------------------------------------------------------------------------------------

    def test_from_the_command_line(self) -> None:
        said = self.meniscus("set", "gravity=[0, -2]", "--at-step", "8", "--no-wait", "--id", "ab" * 16).stdout
        self.assertEqual(said, "scheduled: set gravity = [0, -2], at step 8\n")
        self.assertIn("checkpoint, at t = 0.05 s", self.meniscus("checkpoint", "--at-time", "0.05", "--no-wait").stdout)
        listed = self.ask("status")["scheduled"]
        self.assertEqual([(s["at_step"], s["at_time"]) for s in listed], [(8, None), (None, 0.05)])
        self.assertIn(f"(local, id {listed[0]['id']})", self.meniscus("status").stdout)
        self.assertEqual(listed[0]["id"], "ab" * 16)
        self.meniscus("cancel", listed[1]["id"])
        again = subprocess.Popen([BUILD / "meniscus", "set", "gravity=[0, -2]", "--at-step", "8", "--id", "ab" * 16],
                                 env=self.environment, stdout=subprocess.PIPE, text=True)
        time.sleep(0.2)
        self.assertIsNone(again.poll())
        self.meniscus("step", "10")
        self.assertIn("in effect from step 8", again.communicate(timeout=60)[0])
        for words in (["--at-step", "9", "--at-time", "1"], ["--no-wait"], ["--at-step", "-1"]):
            self.meniscus("pause", *words, code=2)
        self.assertIn("is past", self.meniscus("pause", "--at-step", "1", code=1).stderr)

    def test_from_python(self) -> None:
        with Client(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            reply = client.set({"gravity": "[0, -2]"}, at_step=8, wait=False)
            self.assertIsNone(reply.effect_step)
            self.assertIsNone(client.pause(at_time=0.05, wait=False).effect_step)
            scheduled = client.status().scheduled
            self.assertEqual([(s.at_step, s.at_time, s.who) for s in scheduled], [(8, None, "local"), (None, 0.05, "local")])
            with self.assertRaisesRegex(ValueError, "32 hexadecimal digits"):
                client.cancel(scheduled[1].id.hex()[1:])
            client.cancel(scheduled[1].id.hex())
            self.assertEqual(asyncio.run(self.snapshot_while_stepping()).step, 9)
            self.assertEqual(client.status().case_version, 2)
            self.assertEqual(client.status().scheduled, ())

    async def snapshot_while_stepping(self) -> "OutputFile":
        async with AsyncClient(f"ipc://{self.home}/run/meniscus/default/control.ipc") as client:
            file, _ = await asyncio.gather(client.snapshot(at_step=9), client.step(12))
            return file

    # --- crashes -----------------------------------------------------------------------------------------------------------

    def test_a_kill_between_acceptance_and_effect_loses_nothing(self) -> None:
        chance = random.Random(20261123)
        step, done, value = 0, 0, "[0, -1]"
        wanted: list[tuple[int, "pb.Request"]] = []
        for k in range(KILLS):
            for _ in range(2):
                at = step + chance.randint(1, 240)  # so that some wait over two crashes
                words: dict[str, Any] = dict(set=set_gravity(f"[{1e-3 * (len(wanted) + 1):.3f}, -1]"))
                words |= dict(at_step=at) if chance.random() < 0.6 else dict(at_time=self.time_now() + chance.uniform(0.001, 0.15))
                request = self.say(self.socket, no_wait=True, **words)
                self.hear(self.socket)
                wanted.append((at if request.HasField("at_step") else -1, request))
            self.say(self.socket, step=pb.Step(count=60), id=(again := secrets.token_bytes(16)))
            time.sleep(chance.uniform(0, 0.05))
            self.back()
            self.say(self.socket, step=pb.Step(count=60), id=again)
            step = self.hear(self.socket).step
            self.assertEqual(step, 60 * (k + 1))
        self.give(step=pb.Step(count=200))
        effects = []
        for at, request in wanted:
            self.socket.send(request.SerializeToString())
            reply = self.hear(self.socket)
            self.assertTrue(reply.HasField("effect_step"))
            if at >= 0:
                self.assertEqual(reply.effect_step, at)
            else:
                self.assertEqual(self.time_of(reply.effect_step), request.at_time)
            effects.append(reply.case_version)
        self.assertEqual(sorted(effects), list(range(2, len(wanted) + 2)), "each once")
        self.assertEqual(self.pending(), [])
        self.replays()

    def test_a_pause_is_pending_still_after_a_kill(self) -> None:
        for k in range(4):
            self.say(self.socket, set=set_gravity(f"[0, {-2 - k}]"), at_step=100 * (k + 1), no_wait=True)
            self.hear(self.socket)
            self.say(self.socket, pause=pb.Pause(), at_step=100 * (k + 1), no_wait=True)
            self.hear(self.socket)
            pending = self.pending()
            self.assertEqual(len(pending), 2)
            self.back()
            until = time.monotonic() + PATIENCE_MS / 1000
            while self.pending() != pending and time.monotonic() < until:
                time.sleep(0.02)
            self.assertEqual(self.pending(), pending, "all of it, in the order of acceptance")
            self.give(**{"resume" if k else "start": pb.Resume() if k else pb.Start()})
            self.say(self.socket, wait=pb.Wait(states=[pb.PAUSED]))
            self.assertEqual(self.hear(self.socket).step, 100 * (k + 1))
            self.assertEqual(self.gravity(), f"[0, {-2 - k}]")
        self.replays()

    def time_now(self) -> float:
        return float(self.give(status=pb.GetStatus()).time)

    def time_of(self, step: int) -> float:
        records = self.ask("log", str(self.run_directory))["records"]
        return float(next(r["time"] for r in records if r["command"] == "set" and r["kind"] == "command" and r["step"] == step))


if __name__ == "__main__":
    unittest.main()

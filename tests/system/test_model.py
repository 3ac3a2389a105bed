#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Random sequences of commands, good and bad, of several clients: every reply is that of the reference model (tests/support/reference.py).

MENISCUS_SEQUENCES says how many; 500 unless it is set, 10^5 with `make torture ROW=model SIZE=full`. They are the same every time unless
MENISCUS_SEED is set; sequence k of a seed can be had alone (MENISCUS_FIRST=k). What fails is made shorter while it fails, and printed.
"""

import os
import random
import secrets
import shutil
import sys
import time
import unittest
from pathlib import Path
from typing import Callable

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, IN_MEMORY, ROOT, DaemonTest, control_socket  # noqa: E402
from reference import SCHEDULABLE, Answer, Model  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
from meniscus import meniscus_pb2 as pb  # noqa: E402
from meniscus.case import CaseText  # noqa: E402

SEQUENCES = int(os.environ.get("MENISCUS_SEQUENCES", "500"))
SEED = int(os.environ.get("MENISCUS_SEED", "20261123"))
FIRST = int(os.environ.get("MENISCUS_FIRST", "0"))
LONGEST = 25  # commands of a sequence, besides those it begins and ends with; twelve in the mean
SETTINGS = {"resolution": 6, "threads": 1, "end_time": 1000, "output.checkpoints_kept": 50, "output.checkpoint_wall_interval": 0}
CLIENTS = 3
FAR = 10**9  # a step that no run comes to
PATIENCE_MS = 10000
GRAVITIES = ("[0, -1]", "[0, -2]", "[0.5, -3]")
BAD = (("gravity", "[0, 0, 1]"), ("nonsense", "1"), ("end_time", "-1"))

# Each command is a name and a number, from which the driver makes a request that fits the moment, or does not.
NAMES = ("load start resume step run_until pause stop reset restore checkpoint set set_bad end_here end_far rollback breakpoint "
         "lease release get status cancel again").split()
LIKELY = ["step"] * 5 + ["set"] * 4 + ["run_until"] * 2 + ["rollback", "pause", "checkpoint", "cancel", "again", "load", "load"]
WHEN = ["now"] * 3 + ["at_step", "at_time", "past", "both", "no_wait"]
LEASES = [""] * 4 + ["mine", "wrong"]
CONDITIONS = [""] * 4 + ["version", "next version", "old version", "step", "other step"]
Command = tuple[str, int, int, str, str, str]

FOUND: "list[list[Command]]" = [  # what has failed once
    # The end comes at the step of a checkpoint that was written with another end, and somebody goes back to that step.
    [("step", 9, 0, "now", "", ""), ("checkpoint", 8, 2, "now", "", ""), ("end_here", 11, 0, "now", "", ""), ("step", 3, 0, "now", "", ""),
     ("restore", 9, 1, "now", "", "")],
]


def sequence(number: int) -> list[Command]:
    """The commands of one sequence, the same whatever was done before."""
    chance = random.Random(f"{SEED} {number}")
    pick = chance.choice
    return [(pick(LIKELY + NAMES), chance.randrange(12), chance.randrange(CLIENTS), pick(WHEN), pick(LEASES), pick(CONDITIONS))
            for _ in range(chance.randrange(LONGEST + 1))]


def shortened(commands: list[Command], fails: Callable[[list[Command]], bool]) -> list[Command]:
    """What is left of those that fail when all that can be spared is: all of them at first, single ones at last."""
    n = len(commands)
    while n > 0:
        k = 0
        while k < len(commands):
            less = commands[:k] + commands[k + n:]
            if fails(less):
                commands = less
            else:
                k += n
        n = (n + 1) // 2 if n > 1 else 0
    return commands


class Misfit(AssertionError):
    """A reply that is not as the model has it."""


class Driver:
    """Gives commands to a daemon and to the model, and compares what comes of them."""

    def __init__(self, endpoint: str, load: "pb.Load") -> None:
        self.context = zmq.Context()
        self.sockets = [self.context.socket(zmq.DEALER) for _ in range(CLIENTS)]
        self.poller = zmq.Poller()
        for socket in self.sockets:
            socket.connect(endpoint)
            self.poller.register(socket, zmq.POLLIN)
        self.load = load
        self.commands = 0
        self.begin()

    def begin(self) -> None:
        """A sequence, with a daemon that is EMPTY."""
        self.model = Model({"gravity": "[0, -1]", "end_time": "1000"})
        self.heard: dict[bytes, bytes] = {}  # replies that nobody has asked for yet, by id
        self.answered: list[tuple["pb.Request", bytes]] = []

    def close(self) -> None:
        self.context.destroy(0)

    # --- what goes out and comes in -----------------------------------------------------------------------------------------

    def send(self, request: "pb.Request", client: int) -> None:
        self.sockets[client].send(request.SerializeToString())

    def listen(self, milliseconds: int) -> None:
        for socket, _ in self.poller.poll(milliseconds):
            packed = socket.recv()
            self.heard[pb.Reply.FromString(packed).id] = packed

    def hear(self, wanted: bytes) -> bytes:
        until = time.monotonic() + 1e-3 * PATIENCE_MS
        while wanted not in self.heard and time.monotonic() < until:
            self.listen(200)
        if wanted not in self.heard:
            raise Misfit(f"no reply to {wanted.hex()}")
        return self.heard.pop(wanted)

    def compare(self, request: "pb.Request", packed: bytes, answer: Answer) -> None:
        reply = pb.Reply.FromString(packed)
        found = {"code": pb.Code.Name(reply.code), "state": pb.State.Name(reply.state), "version": reply.case_version,
                 "effect": reply.effect_step if reply.HasField("effect_step") else None, "path": reply.path,
                 "allowed": frozenset(pb.State.Name(state) for state in reply.allowed)}
        wanted = {"code": answer.code, "state": answer.state, "version": answer.version, "effect": answer.effect,
                  "path": answer.path, "allowed": answer.allowed}
        if answer.state == "?":
            found = {"code": found["code"]}
        if answer.at_desk:
            del found["version"]
        if answer.path == "?" or reply.code == pb.OK:
            found.pop("path", None)
        if request.WhichOneof("command") in ("status", "get"):
            found.pop("effect", None)
        wrong = {key: (value, wanted[key]) for key, value in found.items() if value != wanted[key]}
        if wrong:
            raise Misfit(f"{wrong} (found, wanted) of {request}: {reply}")
        if not answer.at_desk and request.WhichOneof("command") not in ("status", "get"):
            self.answered.append((request, packed))

    # --- one command --------------------------------------------------------------------------------------------------------

    def give(self, request: "pb.Request", client: int = 0) -> "pb.Reply":
        request.major = 1
        request.id = request.id or secrets.token_bytes(16)
        before = {r.id: r for r in self.model.pending}
        moving = self.model.state == "RUNNING"
        self.commands += 1
        self.send(request, client)
        if moving:  # only the daemon knows where it is
            packed = self.hear(request.id)
            reply = pb.Reply.FromString(packed)
            if reply.HasField("step") and reply.state != pb.EMPTY and reply.step < self.model.step:
                raise Misfit(f"it went back from {self.model.step}: {reply}")
            if reply.HasField("effect_step"):
                self.model.step, self.model.time = reply.effect_step, reply.time
            answer = self.model.take(request)
        else:
            answer = self.model.take(request)
            if answer.waits:
                if not request.no_wait:
                    self.see_scheduled(request.id)
                    return pb.Reply()
                answer.waits = False
            packed = self.hear(request.id)
            reply = pb.Reply.FromString(packed)
        if answer.goal:
            at = {}
            for r in self.model.pending:
                if self.model.is_due(r, reply.step, reply.time):
                    told = pb.Reply.FromString(self.outcome(r))
                    at[r.id] = told.step, told.time
            answer = self.model.arrive(request, reply, at)
        self.compare(request, packed, answer)
        if request.no_wait and request.id in {r.id for r in self.model.pending}:
            self.answered.pop()  # the same id is answered otherwise when it is done
        for id, late in self.model.answers.items():
            if id in before:
                self.compare(before[id], self.outcome(before[id]), late)
                self.heard.pop(id, None)
        return reply

    def see_scheduled(self, wanted: bytes) -> None:
        until = time.monotonic() + 1e-3 * PATIENCE_MS
        while time.monotonic() < until and wanted not in self.heard:
            ask = pb.Request(major=1, id=secrets.token_bytes(16), status=pb.GetStatus())
            self.send(ask, 0)
            status = pb.Reply.FromString(self.hear(ask.id)).status
            if wanted in [s.id for s in status.scheduled]:
                return
        raise Misfit(f"{wanted.hex()} is not scheduled")

    def outcome(self, request: "pb.Request") -> bytes:
        """What came of a scheduled command: who did not wait asks again, and waits now."""
        if request.no_wait and request.id not in self.heard:
            again = pb.Request.FromString(request.SerializeToString())
            again.no_wait = False
            self.send(again, 0)
        packed = self.hear(request.id)
        self.heard[request.id] = packed
        return packed

    def repeat(self, number: int) -> None:
        if not self.answered:
            return
        request, packed = self.answered[-1 - number % len(self.answered)]
        self.commands += 1
        self.send(request, number % CLIENTS)
        if self.hear(request.id) != packed:
            raise Misfit(f"another reply to the same request {request}")

    # --- from a name and a number to a request --------------------------------------------------------------------------------

    def request(self, name: str, number: int) -> "pb.Request":
        model, request = self.model, pb.Request()
        if name == "load":
            request.load.CopyFrom(self.load)
        elif name == "step":
            request.step.count = number
        elif name == "run_until":
            request.run_until.time = model.time + 0.004 * (number - 1)
        elif name == "set":
            request.set.assignments.add(path="gravity", value=GRAVITIES[number % 3])
        elif name == "set_bad":
            request.set.assignments.add(path="gravity", value="[7, 7]")
            if number:
                request.set.assignments.add(path=BAD[number % 3][0], value=BAD[number % 3][1])
            else:
                del request.set.assignments[:]
        elif name in ("end_here", "end_far"):
            here = name == "end_here" and model.time > 0 and model.state != "RUNNING"
            request.set.assignments.add(path="end_time", value=repr(model.time) if here else str(1000 + number))
        elif name == "rollback":
            request.rollback.version = max(0, model.version + 1 - number % 5)
        elif name == "breakpoint":
            request.breakpoint.name = "ab"[number % 2]
            if number < 3:
                request.breakpoint.remove = True
            else:
                request.breakpoint.step = max(0, model.step + number - 5) or FAR
        elif name == "lease":
            request.lease.ttl_ms, request.lease.holder = 50 if number == 0 else 3600000, "anna"
        elif name == "release":
            request.lease.release = True
        elif name == "get":
            request.get.paths.append("gravity")
        elif name == "cancel":
            ids = [r.id for r in model.pending] + [bytes(16), b"x", secrets.token_bytes(16)]
            request.cancel.id = ids[number % len(ids)]
        else:
            getattr(request, name).SetInParent()
        return request

    def moment(self, request: "pb.Request", when: str, number: int) -> None:
        model = self.model
        if when in ("at_step", "both", "no_wait"):
            request.at_step = FAR + number if model.state == "RUNNING" else model.step + number
        if when in ("at_time", "both"):
            request.at_time = model.end() * 2 if model.state == "RUNNING" else model.time + 0.003 * number if model.document else 1.0
        if when == "past":
            request.at_step = max(0, model.step - 1) if model.state != "RUNNING" else 0
        if when == "no_wait":
            request.no_wait = True

    def suits(self, request: "pb.Request", when: str) -> bool:
        """Can the model know what comes of it? While the run moves, not what depends on where it is."""
        model, kind = self.model, request.WhichOneof("command")
        if kind in ("start", "resume"):
            still = all(step <= model.step or step >= FAR for step in model.breakpoints.values())
            ends = bool(model.document) and model.time >= model.end()
            return still and all(r.at_step >= FAR for r in model.pending) and not ends
        if model.state != "RUNNING":
            return True
        if kind == "rollback" and model.versions.get(request.rollback.version, {"end_time": "1000"})["end_time"] < "1000":
            return False
        return when in ("now", "both", "no_wait") and (kind != "breakpoint" or request.breakpoint.remove)

    def command(self, name: str, number: int, client: int, when: str, lease: str, condition: str) -> None:
        model = self.model
        if name == "again":
            self.repeat(number)
            return
        request = self.request(name, number)
        often = request.WhichOneof("command") in SCHEDULABLE or number % 4 == 0  # most others are refused for it
        when = when if often and name not in ("end_here", "end_far") else "now"
        self.moment(request, when, number)
        if lease:
            request.lease_epoch = model.epoch if lease == "mine" and model.epoch else 77
        elif name in ("lease", "release") and model.held and number % 2:
            request.lease_epoch = model.epoch
        if "version" in condition:
            request.if_version = max(1, model.version + {"v": 0, "n": 1, "o": -1}[condition[0]])
        elif condition:
            request.if_step = model.step if condition == "step" and model.state != "RUNNING" else FAR
        if not self.suits(request, when):
            return
        reply = self.give(request, client)
        if name == "lease" and reply.code == pb.OK:
            model.epoch = reply.lease.epoch

    # --- a sequence -----------------------------------------------------------------------------------------------------------

    def finish(self) -> None:
        """Compare what can be seen, and leave the daemon EMPTY."""
        model = self.model
        if model.state == "RUNNING":
            self.give(pb.Request(pause=pb.Pause()))
        status = self.give(pb.Request(status=pb.GetStatus())).status
        pending = [(s.id, s.at_step, s.at_time) for s in status.scheduled]
        if pending != [(r.id, r.at_step, r.at_time) for r in model.pending]:
            raise Misfit(f"scheduled are {status.scheduled}, not {model.pending}")
        if model.state != "EMPTY":
            values = self.give(pb.Request(get=pb.Get(paths=["gravity", "end_time"]))).values.values
            seen = (status.step, {b.name: b.step for b in status.breakpoints}, values[0].text, values[1].number)
            wanted = (model.step, model.breakpoints, model.document["gravity"], model.end())
            if seen != wanted:
                raise Misfit(f"{seen}, not {wanted}")
            self.give(pb.Request(stop=pb.Stop()))
        if model.held:
            self.give(pb.Request(lease=pb.Lease(release=True), lease_epoch=model.epoch))
        self.listen(0)
        if self.heard:
            raise Misfit(f"answered twice, or unasked: {[pb.Reply.FromString(r) for r in self.heard.values()]}")


class Sequences(DaemonTest):
    parent = IN_MEMORY  # what a daemon waits for is its disk; that nothing is lost is tried elsewhere
    done = 0  # of sequences: those that came to their end
    commands = 0

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        text = CaseText(str(ROOT / "server" / "cases" / "dambreak2d.yaml"))
        for path, value in SETTINGS.items():
            text.set(path, value)
        cls.load = pb.Load(case=text.message(), name="model")
        cls.begin()
        cls.addClassCleanup(lambda: cls.driver.close())

    @classmethod
    def begin(cls) -> None:
        cls.driver = Driver(f"ipc://{control_socket(cls.home)}", cls.load)

    def recover(self) -> None:
        """After a sequence that failed, for the next one."""
        type(self).commands += self.driver.commands
        self.driver.close()
        self.daemon.kill()
        self.daemon.wait()
        shutil.rmtree(self.home / "state", ignore_errors=True)
        type(self).start_daemon()
        type(self).begin()

    def run_sequence(self, commands: list[Command]) -> None:
        self.driver.begin()
        try:
            self.driver.give(pb.Request(load=self.load))
            for command in commands:
                self.driver.command(*command)
            self.driver.finish()
        except BaseException:
            self.recover()
            raise
        for run in (self.home / "state").glob("model*"):
            shutil.rmtree(run, ignore_errors=True)

    def fails(self, commands: list[Command]) -> bool:
        try:
            self.run_sequence(commands)
        except Exception:
            return True
        return False

    def test_what_has_failed_once_does_not(self) -> None:
        for commands in FOUND:
            self.run_sequence(commands)

    def test_every_reply_is_that_of_the_model(self) -> None:
        began = time.monotonic()
        for number in range(FIRST, FIRST + SEQUENCES):
            commands = sequence(number)
            try:
                self.run_sequence(commands)
            except Exception:
                least = "\n".join(map(str, shortened(commands, self.fails)))
                print(f"with MENISCUS_SEED={SEED} MENISCUS_FIRST={number} MENISCUS_SEQUENCES=1; what is left of it:\n{least}", file=sys.stderr)
                raise
            type(self).done += 1
        seconds = time.monotonic() - began
        commands = self.commands + self.driver.commands
        print(f"{self.done} sequences, {commands} commands, seed {SEED}: {seconds:.1f} s", file=sys.stderr)


class Shortening(unittest.TestCase):
    def test_what_can_be_spared_is(self) -> None:
        chance = random.Random(1)
        for n in range(1, 26):
            commands = [("step", k, 0, "now", "", "") for k in range(n)]
            needed = chance.sample(commands, chance.randrange(min(4, n) + 1))
            self.assertEqual(shortened(commands, lambda tried: set(needed) <= set(tried)), sorted(needed))


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: BSD-3-Clause
"""What a daemon must answer to one command after the other: states, versions, leases, breakpoints, files and what is scheduled.

It is told of a request and says what the reply must be. Where only the solver can know, as at which step a time is reached, it takes that
from the reply and checks that all else fits. Nothing here is taken from the daemon's sources; proto/README.md is what it was written from.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

STILL = frozenset({"READY", "PAUSED", "DONE", "FAULT"})
LOADED = STILL | {"RUNNING"}
POSSIBLE = {
    "load": STILL | {"EMPTY"}, "start": {"READY"}, "resume": {"PAUSED", "FAULT"}, "step": {"READY", "PAUSED"},
    "run_until": {"READY", "PAUSED"}, "pause": {"RUNNING", "READY", "PAUSED"}, "stop": LOADED | {"RECOVERING"}, "reset": STILL,
    "restore": STILL, "checkpoint": LOADED, "set": LOADED, "rollback": LOADED, "breakpoint": LOADED,
}
LEASED = {"load", "start", "resume", "step", "run_until", "reset", "restore", "set", "rollback", "breakpoint"}
SCHEDULABLE = {"set", "rollback", "pause", "checkpoint", "snapshot"}
A_MOMENT_MAY_COME = frozenset({"READY", "RUNNING", "PAUSED", "DONE"})
SCHEDULED = 64
Document = dict[str, str]


@dataclass
class Answer:
    """What a reply must say. waits: it comes later; goal: it comes when the run has moved, see arrive()."""

    code: str = "OK"
    path: str = ""
    state: str = ""
    version: int = 0
    effect: Optional[int] = None
    allowed: frozenset[str] = frozenset()
    waits: bool = False
    goal: bool = False
    at_desk: bool = False  # before it gets to the run: nothing is said of that, and the same again is another request


class Refused(Exception):
    """With the answer's code, its path and the states in which it would be possible."""

    def __init__(self, code: str, path: str = "", allowed: frozenset[str] = frozenset()) -> None:
        super().__init__(code)
        self.code, self.path, self.allowed = code, path, allowed


@dataclass
class Model:
    original: Document
    state: str = "EMPTY"
    version: int = 0
    step: int = 0
    time: float = 0.0
    document: Document = field(default_factory=dict)
    versions: dict[int, Document] = field(default_factory=dict)
    breakpoints: dict[str, int] = field(default_factory=dict)
    checkpoints: dict[int, tuple[float, Document]] = field(default_factory=dict)
    epoch: int = 0
    held: bool = False
    pending: list[Any] = field(default_factory=list)  # requests, as they were accepted
    answers: dict[bytes, Answer] = field(default_factory=dict)  # due now to who waited: by id

    def answer(self, **what: Any) -> Answer:
        return Answer(**{"state": self.state, "version": self.version, **what})

    def refusal(self, why: Refused) -> Answer:
        return self.answer(code=why.code, path=why.path, allowed=why.allowed)

    # --- one request -------------------------------------------------------------------------------------------------------

    def take(self, request: Any) -> Answer:
        """Do it, and say what is to be answered; and in self.answers, to whom else."""
        kind = request.WhichOneof("command")
        self.answers = {}
        try:
            self.check_manner(request, kind)
        except Refused as why:
            return self.answer(code=why.code, path=why.path, at_desk=True)
        try:
            self.check_moment(request, kind)
            if request.HasField("at_step") or request.HasField("at_time"):
                return self.schedule(request, kind)
            return self.do(request, kind)
        except Refused as why:
            return self.refusal(why)

    def check_manner(self, request: Any, kind: str) -> None:
        which = "at_step" if request.HasField("at_step") else "at_time" if request.HasField("at_time") else ""
        if kind in ("status", "get"):
            for condition in ("if_step", "if_version"):
                if request.HasField(condition):
                    raise Refused("INVALID_ARGUMENT", condition)
        if which and kind not in SCHEDULABLE:
            raise Refused("INVALID_ARGUMENT", which)
        if which and request.HasField("at_step") and request.HasField("at_time"):
            raise Refused("INVALID_ARGUMENT", which)
        if which and request.HasField("if_step"):
            raise Refused("INVALID_ARGUMENT", "if_step")
        if not which and request.no_wait:
            raise Refused("INVALID_ARGUMENT", "no_wait")

    def check_lease(self, epoch: int) -> None:
        if self.held and not epoch:
            raise Refused("FAILED_PRECONDITION", "lease_epoch")
        if epoch and not (self.held and epoch == self.epoch):
            raise Refused("ABORTED", "lease_epoch")

    def check_moment(self, request: Any, kind: str, effect: bool = False) -> None:
        if kind in LEASED:
            self.check_lease(request.lease_epoch)
        early = not effect and (request.HasField("at_step") or request.HasField("at_time"))
        wanted = request.if_version
        if wanted and wanted != self.version and not (early and wanted > self.version):
            raise Refused("FAILED_PRECONDITION", "if_version")
        if request.HasField("if_step") and (self.state == "EMPTY" or request.if_step != self.step):
            raise Refused("FAILED_PRECONDITION", "if_step")

    def do(self, request: Any, kind: str) -> Answer:
        possible = frozenset(POSSIBLE.get(kind, ()))
        if possible and self.state not in possible:
            raise Refused("FAILED_PRECONDITION", "", possible)
        answer: Optional[Answer] = getattr(self, "do_" + kind)(getattr(request, kind), request)
        return answer or self.answer(effect=self.step)

    # --- commands ----------------------------------------------------------------------------------------------------------

    def do_status(self, _: Any, __: Any) -> Answer:
        return self.answer()

    def do_get(self, _: Any, __: Any) -> Answer:
        if self.state == "EMPTY":
            raise Refused("FAILED_PRECONDITION")
        return self.answer()

    def do_load(self, _: Any, __: Any) -> None:
        self.drop_all()
        self.state, self.version, self.document = "READY", 1, dict(self.original)
        self.begin(0, 0.0)
        self.checkpoints = {}

    def begin(self, step: int, time: float) -> None:
        self.step, self.time, self.breakpoints = step, time, {}
        self.versions = {self.version: self.document}

    def do_start(self, _: Any, __: Any) -> None:
        self.state = "RUNNING"

    do_resume = do_start

    def do_step(self, step: Any, _: Any) -> Answer:
        if step.count == 0:
            raise Refused("INVALID_ARGUMENT", "count")
        return self.answer(goal=True)

    def do_run_until(self, until: Any, _: Any) -> Answer:
        if not self.time <= until.time <= self.end():
            raise Refused("INVALID_ARGUMENT", "time")
        return self.answer(goal=True)

    def do_pause(self, _: Any, __: Any) -> None:
        self.state = "PAUSED" if self.state == "RUNNING" else self.state

    def do_stop(self, _: Any, __: Any) -> Answer:
        self.drop_all()
        effect = self.step
        self.state, self.version, self.document, self.breakpoints, self.versions = "EMPTY", 0, {}, {}, {}
        self.step, self.time = 0, 0.0
        return self.answer(effect=effect)

    def do_cancel(self, cancel: Any, _: Any) -> None:
        if len(cancel.id) != 16 or not any(cancel.id):
            raise Refused("INVALID_ARGUMENT", "id")
        for k, request in enumerate(self.pending):
            if request.id == cancel.id:
                del self.pending[k]
                self.answers[request.id] = self.answer(code="ABORTED")
                return
        raise Refused("NOT_FOUND")

    def do_reset(self, _: Any, __: Any) -> None:
        self.drop_all()
        self.state, self.version, self.document = "READY", self.version + 1, dict(self.original)
        self.begin(0, 0.0)
        self.checkpoints = {}

    def do_restore(self, _: Any, __: Any) -> None:
        if not self.checkpoints:
            raise Refused("NOT_FOUND")
        self.drop_all()
        step = max(self.checkpoints)
        time, document = self.checkpoints[step]
        self.state, self.version, self.document = "READY", self.version + 1, document
        self.begin(step, time)

    def do_checkpoint(self, _: Any, __: Any) -> None:
        self.checkpoints[self.step] = self.time, self.document

    def end(self, document: Optional[Document] = None) -> float:
        return float((document or self.document)["end_time"])

    def changed(self, made: Any) -> Document:
        """The case with these entries set; the daemon's list of what is wrong with them is shorter than the schema's."""
        document = dict(self.document)
        if not made.assignments:
            raise Refused("INVALID_ARGUMENT")
        for item in made.assignments:
            if item.path not in document:
                raise Refused("NOT_FOUND", "?")
            if item.value.count(",") > 1 or item.value.startswith("-"):
                raise Refused("INVALID_ARGUMENT", "?")
            document[item.path] = item.value
        self.check_end(document)
        return document

    def check_end(self, document: Document) -> None:
        if self.end(document) < self.time:
            raise Refused("INVALID_ARGUMENT", "end_time")

    def adopt(self, document: Document) -> None:
        self.document = document
        self.version += 1
        self.versions[self.version] = document
        if self.state == "DONE" and self.time < self.end():
            self.state = "PAUSED"

    def do_set(self, made: Any, _: Any) -> None:
        self.adopt(self.changed(made))

    def do_rollback(self, back: Any, _: Any) -> None:
        document = self.version_of(back)
        self.check_end(document)
        self.adopt(document)

    def version_of(self, back: Any) -> Document:
        if back.version not in self.versions:
            raise Refused("NOT_FOUND", "version")
        return self.versions[back.version]

    def do_breakpoint(self, point: Any, _: Any) -> None:
        if point.remove:
            if point.name not in self.breakpoints:
                raise Refused("NOT_FOUND")
            del self.breakpoints[point.name]
        elif point.step <= self.step:
            raise Refused("INVALID_ARGUMENT", "step")
        else:
            self.breakpoints[point.name] = point.step

    def do_lease(self, lease: Any, request: Any) -> None:
        epoch = request.lease_epoch
        if not lease.release and not 100 <= lease.ttl_ms <= 86400000:
            raise Refused("INVALID_ARGUMENT", "ttl_ms")
        self.check_lease(epoch)
        if lease.release and not epoch:
            raise Refused("INVALID_ARGUMENT", "lease_epoch")
        self.held = not lease.release

    # --- what is scheduled --------------------------------------------------------------------------------------------------

    def schedule(self, request: Any, kind: str) -> Answer:
        if self.state not in A_MOMENT_MAY_COME:
            raise Refused("FAILED_PRECONDITION", "", A_MOMENT_MAY_COME)
        if kind == "set":
            self.changed(request.set)
        if kind == "rollback":
            self.version_of(request.rollback)
        if request.HasField("at_step") and request.at_step < self.step:
            raise Refused("INVALID_ARGUMENT", "at_step")
        if request.HasField("at_time") and not self.time <= request.at_time <= self.end():
            raise Refused("INVALID_ARGUMENT", "at_time")
        if len(self.pending) == SCHEDULED:
            raise Refused("RESOURCE_EXHAUSTED")
        if self.is_due(request, self.step, self.time):
            return self.fire(request)
        self.pending.append(request)
        return self.answer(waits=True)

    def is_due(self, request: Any, step: int, time: float) -> bool:
        return request.at_step <= step if request.HasField("at_step") else request.at_time <= time

    def fire(self, request: Any) -> Answer:
        kind = request.WhichOneof("command")
        try:
            self.check_moment(request, kind, effect=True)
            return self.do(request, kind)
        except Refused as why:
            return self.refusal(why)

    def drop_all(self) -> None:
        for request in self.pending:
            self.answers[request.id] = Answer(code="ABORTED", state="?")
        self.pending = []

    # --- the run in motion --------------------------------------------------------------------------------------------------

    def arrive(self, request: Any, reply: Any, at: dict[bytes, tuple[int, float]]) -> Answer:
        """A step or run_until has come to its end. at: step and time at which what was scheduled took effect, by id."""
        begun, self.answers = self.step, {}
        target = begun + request.step.count if request.HasField("step") else None
        due = sorted((r for r in self.pending if self.is_due(r, reply.step, reply.time)), key=lambda r: at[r.id][0])
        self.pending = [r for r in self.pending if r not in due]
        if self.time >= self.end():
            assert not due and reply.step == begun
            self.state = "DONE"
            self.checkpoints[self.step] = self.time, self.document
            return self.answer(effect=begun)
        stop = min((step for step in self.breakpoints.values() if step > begun), default=None)
        reached = reply.step == target if target else reply.time == request.run_until.time
        ended = reached or stop == reply.step
        result: Optional[Answer] = None
        self.state = "RUNNING"
        for r in due:
            self.step, self.time = at[r.id]
            assert self.time == r.at_time if r.HasField("at_time") else self.step == r.at_step, "not at its moment"
            here = self.step == reply.step
            if here and ended and result is None:
                result = self.come_to_rest(reached, reply)
            before = self.state
            self.answers[r.id] = self.fire(r)
            if before == "RUNNING" and self.state == "PAUSED":
                assert here, "the run went on after a pause"
                result = self.answer(code="ABORTED")
        assert result or ended, "it ended for no reason"
        self.step, self.time = reply.step, reply.time
        assert stop is None or stop >= self.step, "it has passed a breakpoint"
        return result or self.come_to_rest(reached, reply)

    def come_to_rest(self, reached: bool, reply: Any) -> Answer:
        self.state = "PAUSED"
        return self.answer(effect=reply.step) if reached else self.answer(code="ABORTED")

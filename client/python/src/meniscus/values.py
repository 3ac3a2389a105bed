# SPDX-License-Identifier: BSD-3-Clause
"""What a daemon answers and publishes, as plain values. Everything is in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np

from . import display
from . import meniscus_pb2 as pb
from .errors import CorruptError


Frame = Union[bytes, memoryview]


@dataclass(frozen=True)
class Value:
    """A number or a text with its unit; None where there is nothing to measure."""

    value: Any  # float, str or None: whoever names a probe knows that it is a number
    unit: str = ""


@dataclass(frozen=True)
class Reply:
    """The answer to a command: the state after its effect, and the step boundary at which it took effect."""

    state: str
    step: int  # at the time of the answer
    time: float  # simulated, at the time of the answer [s]
    effect_step: Optional[int]  # at which the command took effect; None: nothing did
    daemon_epoch: int  # another number after every start of the daemon
    message: str = ""
    path: Optional[str] = None  # of load, reset, restore, stop and shutdown: the run directory
    case_version: Optional[int] = None  # 1 when a case is loaded, one more with every change of it


@dataclass(frozen=True)
class OutputFile:
    """A file the daemon has written."""

    path: str
    step: int
    time: float  # simulated [s]


@dataclass(frozen=True)
class Timer:
    """Where the solver spends its time."""

    name: str
    seconds: float  # of the wall clock
    calls: int


@dataclass(frozen=True)
class Breakpoint:
    """Where a run will pause; one of time [s], step and condition is not None."""

    name: str
    time: Optional[float] = None
    step: Optional[int] = None
    condition: Optional[str] = None


@dataclass(frozen=True)
class Scheduled:
    """A command that waits for a step or a time [s]; the other is None. id: for cancel()."""

    id: bytes
    at_step: Optional[int]
    at_time: Optional[float]
    who: str
    what: str


@dataclass(frozen=True)
class StreamsNow:
    """Streams that are subscribed to, of all clients together."""

    latest: int  # of the newest: probes, fields, events
    lossless: int  # of everything: series, snapshots
    memory_bytes: int  # that they hold
    skipped: int  # items that gave way to newer ones, since the daemon began


@dataclass(frozen=True)
class Status:
    """What a daemon is doing. None: not known, or not in this state."""

    state: str
    case_name: Optional[str] = None
    title: Optional[str] = None
    run_directory: Optional[str] = None
    time: Optional[float] = None  # simulated [s]
    end_time: Optional[float] = None  # [s]
    step: Optional[int] = None
    time_step: Optional[float] = None  # the last one [s]
    particles: Optional[int] = None  # of fluids and walls
    fluid_particles: Optional[int] = None
    steps_per_second: Optional[float] = None  # of the wall clock
    ns_per_particle_step: Optional[float] = None  # [ns]
    eta_s: Optional[float] = None  # wall-clock time to the end [s]
    guarded: Optional[int] = None  # times that a particle was kept from a wall
    uncorrected: Optional[int] = None  # steps after which a number density was off by more than the case allows
    energy_excess: Optional[float] = None  # made of nothing, over the largest of kinetic energy and change of potential energy
    samples_dropped: Optional[int] = None  # live samples that nobody fetched in time; files have them all
    fault: Optional[str] = None  # the sentence, in FAULT
    fault_reason: Optional[str] = None  # as MeniscusError.status
    threads: Optional[int] = None
    wall_s: Optional[float] = None  # wall-clock time of the run [s]
    memory_bytes: Optional[int] = None
    version: Optional[str] = None
    state_hash: Optional[int] = None  # only when not RUNNING
    case_version: Optional[int] = None  # 1 when the case was loaded, one more with every change
    recovery_step: Optional[int] = None  # in RECOVERING: the step at which it is back where it was
    lease_holder: Optional[str] = None  # who alone may change the run
    lease_s: Optional[float] = None  # for how long yet [s]
    timers: Tuple[Timer, ...] = ()
    breakpoints: Tuple[Breakpoint, ...] = ()
    scheduled: Tuple[Scheduled, ...] = ()  # in the order in which they were accepted
    streams: Optional[StreamsNow] = None

    def _repr_html_(self) -> str:
        rows: List[Tuple[str, Any]] = [("state", self.state), ("case", self.title or self.case_name)]
        if self.time is not None:
            end = f" of {self.end_time:g}" if self.end_time is not None else ""
            rows.append(("time", f"{self.time:g}{end} s"))
        rows += [("step", self.step), ("particles", self.particles), ("fault", self.fault), ("lease", self.lease_holder)]
        if self.eta_s is not None:
            rows.append(("to the end", f"{self.eta_s:.0f} s"))
        shown = display.table([row for row in rows if row[1] is not None])
        return shown + (display.bar(self.time / self.end_time) if self.time is not None and self.end_time else "")


@dataclass(frozen=True)
class Telemetry:
    """One message of a topic. lost: messages of the topic that did not arrive before this one."""

    topic: str
    sequence: int
    lost: int
    step: int
    time: float  # simulated [s]
    state: Optional[str] = None  # event, progress
    what: str = ""  # event
    text: str = ""  # event, log
    level: Optional[int] = None  # log
    fraction: Optional[float] = None  # progress, 0 to 1
    eta_s: Optional[float] = None  # progress: wall-clock time to the end [s]
    steps_per_second: Optional[float] = None  # progress
    time_step: Optional[float] = None  # progress [s]
    end_time: Optional[float] = None  # progress [s]
    values: Dict[str, Value] = field(default_factory=dict)  # probe


def _given(message: Any, name: str) -> Any:
    return getattr(message, name) if message.HasField(name) else None


def read_reply(reply: pb.Reply) -> Reply:
    """The part that every reply has."""
    return Reply(
        pb.State.Name(reply.state), reply.step, reply.time, _given(reply, "effect_step"), reply.daemon_epoch,
        reply.message, _given(reply.output, "path") if reply.HasField("output") else None,
        _given(reply, "case_version")
    )


def read_status(message: pb.Status) -> Status:
    """A status, field by field."""
    now = message.streams
    names = [name for name in Status.__dataclass_fields__ if name not in ("state", "timers", "breakpoints", "scheduled", "streams")]
    return Status(
        state=pb.State.Name(message.state),
        timers=tuple(Timer(timer.name, timer.seconds, timer.calls) for timer in message.timers),
        breakpoints=tuple(
            Breakpoint(b.name, _given(b, "time"), _given(b, "step"), _given(b, "condition")) for b in message.breakpoints
        ),
        scheduled=tuple(
            Scheduled(s.id, _given(s, "at_step"), _given(s, "at_time"), s.who, s.what) for s in message.scheduled
        ),
        streams=StreamsNow(now.latest, now.lossless, now.memory_bytes, now.skipped) if message.HasField("streams") else None,
        **{name: _given(message, name) for name in names},
    )


def read_values(message: pb.Values) -> Dict[str, Value]:
    """Named values; text where it is text."""
    return {v.name: Value(_value(v), v.unit) for v in message.values}


def _value(message: pb.Value) -> Union[float, str, None]:
    number: Optional[float] = message.number if message.HasField("number") else None
    if number is not None and math.isfinite(number):
        return number
    text: Optional[str] = _given(message, "text")
    return text


def read_array(array: pb.Array, frame: Frame) -> np.ndarray:
    """A raw frame as an array that nobody else changes: the memory into which it was received, where that can be."""
    try:
        received = np.frombuffer(frame, dtype=np.dtype(array.type)).reshape(tuple(array.shape))
        return received if received.flags.writeable and received.flags.aligned else received.copy()
    except (TypeError, ValueError):
        text = f'array "{array.name}" has {len(frame)} bytes, which do not fit {array.type} {list(array.shape)}'
        raise CorruptError("DATA_LOSS", text) from None


def code_of(message: Any) -> str:
    """Of a reply or an end. A code of a later version of the protocol is a failure, though protobuf reads it as absent, and that as OK."""
    return str(pb.Code.Name(message.code)) if message.HasField("code") else "UNKNOWN"


def read_telemetry(topic: str, message: pb.Telemetry, lost: int) -> Telemetry:
    """A message of a topic."""
    common = (topic, message.sequence, lost, message.step, message.time)
    kind = message.WhichOneof("item")
    if kind == "event":
        event = message.event
        return Telemetry(*common, state=pb.State.Name(event.state), what=event.what, text=event.text)
    if kind == "log":
        return Telemetry(*common, level=message.log.level, text=message.log.text)
    if kind == "progress":
        names: List[str] = ["fraction", "eta_s", "steps_per_second", "time_step", "end_time"]
        progress = message.progress
        return Telemetry(
            *common, state=pb.State.Name(progress.state), **{name: _given(progress, name) for name in names}
        )
    return Telemetry(*common, values=read_values(message.probes))

# SPDX-License-Identifier: BSD-3-Clause
"""The commands of a daemon: what is sent, and how the answer is read. Nothing here knows a socket.

Each function makes a Command; method() and async_method() turn it into a method of Client and of AsyncClient, with the same
arguments and the same words of explanation. A new command is a function here and a row in each of the two classes.
"""

from __future__ import annotations

import functools
import inspect
import operator
import os
import pwd
import re
from dataclasses import dataclass
from socket import gethostname
from typing import TYPE_CHECKING, Any, Callable, Coroutine, Dict, Generic, List, Mapping, Optional, Sequence, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import meniscus_pb2 as pb
from .case import CaseSource, CaseText, as_yaml, placed
from .errors import CaseError, MeniscusError, RefusedError
from .escapes import shown
from .texts import texts_only
from .values import Frame, OutputFile, Reply, Status, Value, read_array, read_reply, read_status, read_values

if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    P = ParamSpec("P")

T = TypeVar("T")


@dataclass(frozen=True)
class Command(Generic[T]):
    """A request and what makes a result of its reply."""

    request: pb.Request
    read: Callable[[pb.Reply, List[Frame]], T]
    timeout: Optional[float] = None  # [s]; None: that of the client
    request_id: Optional[bytes] = None
    explain: Optional[Callable[[MeniscusError], MeniscusError]] = None  # what a failure is, where more is known about it here


def method(build: Callable[P, Command[T]]) -> Callable[Concatenate[Any, P], T]:
    """The method of Client that does a command and returns its result."""

    checked = texts_only(build)

    @functools.wraps(build)
    def call(self: Any, /, *args: P.args, **words: P.kwargs) -> T:
        result: T = self._do(checked(*args, **words))
        return result

    _show_arguments(call, build)
    return call


def async_method(build: Callable[P, Command[T]]) -> Callable[Concatenate[Any, P], Coroutine[Any, Any, T]]:
    """The method of AsyncClient that does it while others go on."""

    checked = texts_only(build)

    @functools.wraps(build)
    async def call(self: Any, /, *args: P.args, **words: P.kwargs) -> T:
        result: T = await self._do(checked(*args, **words))
        return result

    _show_arguments(call, build)
    return call


def _show_arguments(call: Any, build: Callable[..., Any]) -> None:
    """Help and editors show the arguments of the command."""
    signature = inspect.signature(build)
    me = inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    result = str(signature.return_annotation)[len("Command["):-1]
    call.__annotations__ = {**build.__annotations__, "return": result}
    call.__signature__ = signature.replace(parameters=[me, *signature.parameters.values()], return_annotation=result)


# --- how answers are read ------------------------------------------------------------------------------------------------


def _reply(reply: pb.Reply, _: List[Frame]) -> Reply:
    return read_reply(reply)


def _output(reply: pb.Reply, _: List[Frame]) -> OutputFile:
    return OutputFile(reply.output.path, reply.output.step, reply.output.time)


def _values(reply: pb.Reply, _: List[Frame]) -> Dict[str, Value]:
    return read_values(reply.values)


def _status(reply: pb.Reply, _: List[Frame]) -> Status:
    return read_status(reply.status)


def _capabilities(reply: pb.Reply, _: List[Frame]) -> pb.Capabilities:
    return reply.capabilities


def _first_array(reply: pb.Reply, frames: List[Frame]) -> np.ndarray:
    return read_array(reply.arrays[0], frames[0])


def _arrays(reply: pb.Reply, frames: List[Frame]) -> Dict[str, np.ndarray]:
    return {array.name: read_array(array, frame) for array, frame in zip(reply.arrays, frames)}


def _epoch(reply: pb.Reply, _: List[Frame]) -> int:
    return int(reply.lease.epoch)


# --- the run -------------------------------------------------------------------------------------------------------------


@texts_only
def load(
    case: CaseSource,
    overrides: Optional[Mapping[str, Any]] = None,
    name: Optional[str] = None,
    resume: bool = False,
) -> Command[Reply]:
    """Load a case; a failure names line and column of the entry to blame."""
    text = CaseText(case)
    for path, value in (overrides or {}).items():
        text.set(path, value)
    settings = [pb.Assignment(path=path, value=value) for path, value in text.settings.items()]
    request = pb.Request(load=pb.Load(case=text.message(), name=name or text.name, resume=resume, settings=settings))

    def explain(error: MeniscusError) -> MeniscusError:
        if not text.has(error.path):
            return error  # name, conditions and lease come with the request
        return CaseError(error.code, placed(text.locate(error.path), error.path, error.message), error.path, error.status)

    return Command(request, _reply, explain=explain)


def start(if_step: Optional[int] = None) -> Command[Reply]:
    """Start the run. if_step: as for set()."""
    return Command(pb.Request(start=pb.Start(), if_step=if_step), _reply)


def _no_wait(wait: bool) -> Dict[str, Any]:
    return {} if wait else {"no_wait": True}


def pause(
    if_step: Optional[int] = None, at_step: Optional[int] = None, at_time: Optional[float] = None, wait: bool = True
) -> Command[Reply]:
    """Pause at the next step boundary. if_step, at_step, at_time, wait: as for set()."""
    request = pb.Request(pause=pb.Pause(), if_step=if_step, at_step=at_step, at_time=at_time, **_no_wait(wait))
    return Command(request, _reply)


def resume(if_step: Optional[int] = None) -> Command[Reply]:
    """Go on after a pause. if_step: as for set()."""
    return Command(pb.Request(resume=pb.Resume(), if_step=if_step), _reply)


def step(count: int = 1, request_id: Optional[bytes] = None, if_step: Optional[int] = None) -> Command[Reply]:
    """Do some time steps; returns when they are done, PAUSED. request_id: as for wait(), if_step: as for set(). ValueError: count is below 0."""
    try:
        count = operator.index(count)
    except TypeError:
        raise TypeError(f"step() takes a whole number of steps; found {repr(count)[:60]}") from None
    if count < 0:
        raise ValueError(f"{count} steps: give how many are to be done, 0 or more")
    return Command(pb.Request(step=pb.Step(count=count), if_step=if_step), _reply, None, request_id)


def run_until(
    time: float, exact: bool = True, request_id: Optional[bytes] = None, if_step: Optional[int] = None
) -> Command[Reply]:
    """Run until a simulated time [s]; exact: shorten the last step to end there.

    request_id, if_step  as for wait() and set()
    """
    request = pb.Request(run_until=pb.RunUntil(time=time, exact=exact), if_step=if_step)
    return Command(request, _reply, None, request_id)


def cancel(request_id: Union[bytes, str]) -> Command[Reply]:
    """End a pending step, run_until or wait: it raises CancelledError where it was called. request_id: 16 bytes, or as 32 hexadecimal digits, as
    `meniscus status` prints what is scheduled. ValueError: it is neither."""
    if isinstance(request_id, str):
        if not re.fullmatch("[0-9a-fA-F]{32}", request_id):
            raise ValueError(f'"{shown(request_id)}" is no id of a request: it has 16 bytes, or 32 hexadecimal digits')
        request_id = bytes.fromhex(request_id)
    return Command(pb.Request(cancel=pb.Cancel(id=request_id)), _reply)


def stop(checkpoint: bool = False, if_step: Optional[int] = None) -> Command[Reply]:
    """End the run; its files stay. if_step: as for set()."""
    return Command(pb.Request(stop=pb.Stop(checkpoint=checkpoint), if_step=if_step), _reply)


def reset() -> Command[Reply]:
    """Back to the beginning of the case."""
    return Command(pb.Request(reset=pb.Reset()), _reply)


def restore(checkpoint: Optional[str] = None) -> Command[Reply]:
    """Put a checkpoint of the run back: a file name in the run directory; None: the newest whole one. One of another case is refused."""
    return Command(pb.Request(restore=pb.Restore(checkpoint=checkpoint)), _reply)


def checkpoint(at_step: Optional[int] = None, at_time: Optional[float] = None) -> Command[OutputFile]:
    """Write a checkpoint now, or at a step or time, as for set(); returns when it is whole."""
    return Command(pb.Request(checkpoint=pb.CheckpointNow(), at_step=at_step, at_time=at_time), _output)


def _names(names: Union[str, Sequence[str]]) -> Sequence[str]:
    """A name alone is a list of one, not of letters."""
    return [names] if isinstance(names, str) else names


def _state(name: str) -> pb.State:
    if name not in pb.State.keys():
        raise RefusedError("INVALID_ARGUMENT", f'there is no state "{name}"; there are {", ".join(pb.State.keys())}', "states")
    state: pb.State = pb.State.Value(name)
    return state


def snapshot(
    fields: Union[str, Sequence[str]] = (), at_step: Optional[int] = None, at_time: Optional[float] = None
) -> Command[OutputFile]:
    """Write a snapshot now, with these fields or those of the case. at_step, at_time: as for checkpoint()."""
    request = pb.Request(snapshot=pb.SnapshotNow(fields=_names(fields)), at_step=at_step, at_time=at_time)
    return Command(request, _output)


def wait(
    states: Union[str, Sequence[str]] = ("DONE", "FAULT"),
    time: Optional[float] = None,
    step: Optional[int] = None,
    timeout: Optional[float] = None,
    request_id: Optional[bytes] = None,
) -> Command[Reply]:
    """Return at the first of: one of the states, a simulated time [s], a step. TimedOutError after timeout [s].

    states      of "EMPTY", "LOADING", "READY", "RUNNING", "PAUSED", "DONE", "FAULT", "STOPPING", "RECOVERING", or one of them; the
                reply says in which state it is, so a run that went wrong is seen by reply.state == "FAULT" and status().fault
    request_id  16 bytes by which cancel() can name this request
    """
    message = pb.Wait(states=[_state(name) for name in _names(states)], time=time, step=step)
    return Command(pb.Request(wait=message), _reply, timeout, request_id)


def breakpoint(
    name: str, time: Optional[float] = None, step: Optional[int] = None, condition: Optional[str] = None
) -> Command[Reply]:
    """Pause at a time, a step, or when a formula is true, as in "P1 > 2e3". With none of them: take it away."""
    remove = time is None and step is None and condition is None
    message = pb.SetBreakpoint(name=name, time=time, step=step, condition=condition, remove=remove)
    return Command(pb.Request(breakpoint=message), _reply)


def shutdown(checkpoint: bool = False) -> Command[Reply]:
    """End the daemon."""
    return Command(pb.Request(shutdown=pb.Shutdown(checkpoint=checkpoint)), _reply)


# --- one writer at a time --------------------------------------------------------------------------------------------------


def _short(name: str) -> str:
    """Its first 30 bytes, and no half of a character."""
    return name.encode(errors="ignore")[:30].decode(errors="ignore")


def _user() -> str:
    """$USER, which cron and services have not, or whose the process is; by number where no name is known for it."""
    try:
        return os.environ.get("USER") or pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())


@texts_only
def take_lease(seconds: float, holder: Optional[str]) -> Command[int]:
    """A new lease, with its epoch. holder: what others are told; None: user@host."""
    name = holder or f"{_short(_user())}@{_short(gethostname())}"
    return Command(pb.Request(lease=pb.Lease(ttl_ms=round(1000 * seconds), holder=name)), _epoch)


def renew_lease(seconds: float) -> Command[int]:
    """The lease lives for so long from now on."""
    return Command(pb.Request(lease=pb.Lease(ttl_ms=round(1000 * seconds))), _epoch)


def release_lease() -> Command[int]:
    """The lease is over."""
    return Command(pb.Request(lease=pb.Lease(release=True)), _epoch)


# --- values --------------------------------------------------------------------------------------------------------------


def set(
    assignments: Mapping[str, Any], if_step: Optional[int] = None, if_version: Optional[int] = None,
    at_step: Optional[int] = None, at_time: Optional[float] = None, wait: bool = True,
) -> Command[Reply]:
    """Change entries of the running case, all or none: {"end_time": 3, "gravity": [0, -1]}.

    if_step     only if the run is at this step when the command would begin; else StateError, whose path is "if_step"
    if_version  the same for the version of the case, as replies and status() have it
    at_step     schedule it: it is checked now, and takes effect when the run is at this step
    at_time     or at this simulated time [s], at which a step ends exactly
    wait        return when it has taken effect; False: when it is scheduled, with an effect_step of None. A timeout is for the effect
    """
    if not isinstance(assignments, Mapping):
        raise TypeError(f'set() takes entries with their values, as in set({{"gravity": [0, -1]}}); found {repr(assignments)[:60]}')
    items = [pb.Assignment(path=path, value=as_yaml(value)) for path, value in assignments.items()]
    return Command(
        pb.Request(
            set=pb.Set(assignments=items), if_step=if_step, if_version=if_version,
            at_step=at_step, at_time=at_time, **_no_wait(wait),
        ),
        _reply,
    )


def rollback(
    version: int, if_version: Optional[int] = None,
    at_step: Optional[int] = None, at_time: Optional[float] = None, wait: bool = True,
) -> Command[Reply]:
    """Change the case back to what it was at a version, which makes one more. RefusedError if it is not kept.

    if_version, at_step, at_time, wait  as for set()
    """
    return Command(
        pb.Request(
            rollback=pb.Rollback(version=version), if_version=if_version,
            at_step=at_step, at_time=at_time, **_no_wait(wait),
        ),
        _reply,
    )


def get(*paths: str) -> Command[Dict[str, Value]]:
    """Entries of the case by path, as in "end_time" or "fluids[1].density", with their units; none: all that can be set."""
    return Command(pb.Request(get=pb.Get(paths=paths)), _values)


def status() -> Command[Status]:
    """What the daemon is doing."""
    return Command(pb.Request(status=pb.GetStatus()), _status)


def capabilities() -> Command[pb.Capabilities]:
    """What the daemon can do: parameters, fields, probes, schemes."""
    return Command(pb.Request(capabilities=pb.GetCapabilities()), _capabilities)


def query(*probes: str) -> Command[Dict[str, Value]]:
    """Probes, now, with their units; all of them if none is named."""
    return Command(pb.Request(query=pb.Query(probes=pb.ProbeQuery(names=probes))), _values)


def points(field: str, points: npt.ArrayLike) -> Command[np.ndarray]:
    """A field at points [n][dim], m: kernel average over the fluid; nan where no fluid is near. At most 57,000 in the plane, 38,000 in space."""
    flat = np.atleast_2d(np.asarray(points, dtype=float)).ravel()
    return Command(pb.Request(query=pb.Query(points=pb.PointQuery(field=field, points=flat.tolist()))), _first_array)


def particles(
    fields: Union[str, Sequence[str]] = (),
    min: Optional[Sequence[float]] = None,
    max: Optional[Sequence[float]] = None,
    walls: bool = False,
    limit: Optional[int] = None,
    every: int = 1,
) -> Command[Dict[str, np.ndarray]]:
    """Particles of a box, or all: one array per field in SI units, the first index counts particles.

    fields    names as in capabilities().fields, or one of them; none: position, id and phase
    min, max  lower and upper corner of the box [m], as many coordinates as the case has dimensions
    limit     MeniscusError, whose status is "limit reached", if there are more; None: 100000
    every     about one in so many, by chance but always the same
    """
    message = pb.ParticleQuery(min=min or (), max=max or (), fields=_names(fields), walls=walls, limit=limit, every=every)
    return Command(pb.Request(query=pb.Query(particles=message)), _arrays)

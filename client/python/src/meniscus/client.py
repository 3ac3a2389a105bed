# SPDX-License-Identifier: BSD-3-Clause
"""The client: every command of the daemon as a method, telemetry as an iterator."""

from __future__ import annotations

import getpass
import time as clock
from contextlib import contextmanager
from dataclasses import replace
from socket import gethostname
from types import TracebackType
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Type

import numpy as np
import zmq

from . import meniscus_pb2 as pb
from .case import CaseSource, CaseText
from .connection import Connection
from .endpoint import control_endpoint, telemetry_endpoint
from .errors import CaseError, LeaseError, MeniscusError
from .keys import choose_keys
from .values import (OutputFile, Reply, Status, Telemetry, Value, read_array, read_reply, read_status, read_telemetry,
                     read_values)

TOPICS = ("event", "log", "progress", "probe")


class Client:
    """A connection to a daemon. Not thread-safe: one per thread. Usable as a context manager.

    daemon      a name, ipc://PATH or tcp://HOST:PORT; None: $MENISCUS_DAEMON, or "default"
    timeout     limit of each command [s]; None: none. A daemon that dies is noticed without it.
    key         file of our key, as `meniscus keys new` wrote it, for tcp://; None: $MENISCUS_KEY. Of neither: plain text, on this
                machine only
    server_key  public key of the daemon; None: $MENISCUS_SERVER_KEY, or that in the file of the key

    Every command returns after its effect, and raises a MeniscusError if it fails. A command cut off by a lost
    connection is sent again under the same id, so it happens once.
    """

    def __init__(
        self,
        daemon: Optional[str] = None,
        timeout: Optional[float] = None,
        key: Optional[str] = None,
        server_key: Optional[str] = None,
    ) -> None:
        self.timeout = timeout
        self._lease = 0  # epoch
        endpoint = control_endpoint(daemon)
        self._connection = Connection(endpoint, choose_keys(endpoint, key, server_key))

    def close(self) -> None:
        """Disconnect; what the daemon is doing goes on."""
        self._connection.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    # --- the run ----------------------------------------------------------------------------------------------------

    def load(
        self,
        case: CaseSource,
        overrides: Optional[Mapping[str, Any]] = None,
        name: Optional[str] = None,
        resume: bool = False,
        start: bool = False,
    ) -> Reply:
        """Load a case: a file, the name of a case, or a mapping of its shape.

        overrides  entries to change: {"resolution": 40, "fluids[1].density": 2}
        name       of the run directory; default: that of the file
        resume     go on from the newest checkpoint of the run, if there is one: as it was steered then, but for overrides
        """
        text = CaseText(case)
        for path, value in (overrides or {}).items():
            text.set(path, value)
        settings = [pb.Assignment(path=path, value=value) for path, value in text.settings.items()]
        request = pb.Request(
            load=pb.Load(case=text.message(), name=name or text.name, resume=resume, settings=settings)
        )
        try:
            reply = self._simple(request)
        except MeniscusError as error:
            if not error.path:
                raise
            where = text.locate(error.path)
            raise CaseError(error.code, f"{where}: {error.path}: {error.message}", error.path, error.status) from None
        return replace(self.start(), path=reply.path) if start else reply

    def start(self, if_step: Optional[int] = None) -> Reply:
        """Start the run. if_step: as for set()."""
        return self._simple(pb.Request(start=pb.Start(), if_step=if_step))

    def pause(self, if_step: Optional[int] = None) -> Reply:
        """Pause at the next step boundary. if_step: as for set()."""
        return self._simple(pb.Request(pause=pb.Pause(), if_step=if_step))

    def resume(self, if_step: Optional[int] = None) -> Reply:
        """Go on after a pause. if_step: as for set()."""
        return self._simple(pb.Request(resume=pb.Resume(), if_step=if_step))

    def step(self, count: int = 1, request_id: Optional[bytes] = None, if_step: Optional[int] = None) -> Reply:
        """Do some time steps; returns when they are done, PAUSED. request_id: as for wait(), if_step: as for set()."""
        return self._simple(pb.Request(step=pb.Step(count=count), if_step=if_step), None, request_id)

    def run_until(
        self, time: float, exact: bool = True, request_id: Optional[bytes] = None, if_step: Optional[int] = None
    ) -> Reply:
        """Run until a simulated time [s]; exact: shorten the last step to end there.

        request_id, if_step  as for wait() and set()
        """
        return self._simple(pb.Request(run_until=pb.RunUntil(time=time, exact=exact), if_step=if_step), None, request_id)

    def cancel(self, request_id: bytes) -> Reply:
        """End a pending step, run_until or wait: it raises CancelledError where it was called."""
        return self._simple(pb.Request(cancel=pb.Cancel(id=request_id)))

    def stop(self, checkpoint: bool = False, if_step: Optional[int] = None) -> Reply:
        """End the run; its files stay. if_step: as for set()."""
        return self._simple(pb.Request(stop=pb.Stop(checkpoint=checkpoint), if_step=if_step))

    def reset(self) -> Reply:
        """Back to the beginning of the case."""
        return self._simple(pb.Request(reset=pb.Reset()))

    def restore(self, checkpoint: Optional[str] = None) -> Reply:
        """Put a checkpoint of the run back: a file name in the run directory; None: the newest whole one."""
        return self._simple(pb.Request(restore=pb.Restore(checkpoint=checkpoint)))

    def checkpoint(self) -> OutputFile:
        """Write a checkpoint now."""
        return self._output(pb.Request(checkpoint=pb.CheckpointNow()))

    def snapshot(self, fields: Sequence[str] = ()) -> OutputFile:
        """Write a snapshot now, with these fields or those of the case."""
        return self._output(pb.Request(snapshot=pb.SnapshotNow(fields=fields)))

    def wait(
        self,
        states: Sequence[str] = ("DONE", "FAULT"),
        time: Optional[float] = None,
        step: Optional[int] = None,
        timeout: Optional[float] = None,
        request_id: Optional[bytes] = None,
    ) -> Reply:
        """Return at the first of: one of the states, a simulated time [s], a step. TimedOutError after timeout [s].

        states      of "EMPTY", "LOADING", "READY", "RUNNING", "PAUSED", "DONE", "FAULT", "STOPPING", "RECOVERING"; the
                    reply says in which state it is, so a run that went wrong is seen by reply.state == "FAULT" and status().fault
        request_id  16 bytes by which cancel() can name this request
        """
        message = pb.Wait(states=[pb.State.Value(state) for state in states], time=time, step=step)
        return self._simple(pb.Request(wait=message), timeout, request_id)

    def breakpoint(
        self, name: str, time: Optional[float] = None, step: Optional[int] = None, condition: Optional[str] = None
    ) -> Reply:
        """Pause at a time, a step, or when a formula is true, as in "P1 > 2e3". With none of them: take it away."""
        remove = time is None and step is None and condition is None
        message = pb.SetBreakpoint(name=name, time=time, step=step, condition=condition, remove=remove)
        return self._simple(pb.Request(breakpoint=message))

    def shutdown(self, checkpoint: bool = False) -> Reply:
        """End the daemon."""
        return self._simple(pb.Request(shutdown=pb.Shutdown(checkpoint=checkpoint)))

    # --- values -----------------------------------------------------------------------------------------------------

    def set(
        self, assignments: Mapping[str, Any], if_step: Optional[int] = None, if_version: Optional[int] = None
    ) -> Reply:
        """Change entries of the running case, all or none: {"end_time": 3, "gravity": [0, -1]}.

        if_step     only if the run is at this step when the command would begin; else StateError, whose path is "if_step"
        if_version  the same for the version of the case, as replies and status() have it
        """
        items = [pb.Assignment(path=path, value=_as_yaml(value)) for path, value in assignments.items()]
        return self._simple(pb.Request(set=pb.Set(assignments=items), if_step=if_step, if_version=if_version))

    def rollback(self, version: int, if_version: Optional[int] = None) -> Reply:
        """Change the case back to what it was at a version, which makes one more. RefusedError if it is not kept."""
        return self._simple(pb.Request(rollback=pb.Rollback(version=version), if_version=if_version))

    # --- the only one to change the run -------------------------------------------------------------------------------

    @contextmanager
    def lease(self, seconds: float = 30, holder: Optional[str] = None) -> Iterator[int]:
        """Be the only one to change the run while the block lasts, but for pause, stop and shutdown: `with client.lease(60):`.

        seconds  for which it lives, unless it is renewed with renew()
        holder   what others are told; None: user@host
        Yields the epoch. LeaseError: somebody else holds it; within the block, from any command that changes the run: it is over.
        """
        name = holder or f"{getpass.getuser()[:30]}@{gethostname()[:30]}"
        self._take_lease(pb.Lease(ttl_ms=round(1000 * seconds), holder=name))
        try:
            yield self._lease
        finally:
            self._give_back()

    def renew(self, seconds: float = 30) -> None:
        """Let the lease live for so long from now on."""
        self._take_lease(pb.Lease(ttl_ms=round(1000 * seconds)))

    def _take_lease(self, lease: pb.Lease) -> None:
        self._lease = self._call(pb.Request(lease=lease))[0].lease.epoch

    def _give_back(self) -> None:
        try:
            self._call(pb.Request(lease=pb.Lease(release=True)))
        except LeaseError:
            pass  # it was over
        finally:
            self._lease = 0

    def get(self, *paths: str) -> Dict[str, Value]:
        """Entries of the case by path, as in "end_time" or "fluids[1].density", with their units; none: all that can be set."""
        return read_values(self._call(pb.Request(get=pb.Get(paths=paths)))[0].values)

    def status(self) -> Status:
        """What the daemon is doing."""
        return read_status(self._call(pb.Request(status=pb.GetStatus()))[0].status)

    def capabilities(self) -> pb.Capabilities:
        """What the daemon can do: parameters, fields, probes, schemes."""
        return self._call(pb.Request(capabilities=pb.GetCapabilities()))[0].capabilities

    def query(self, *probes: str) -> Dict[str, Value]:
        """Probes, now, with their units; all of them if none is named."""
        query = pb.Query(probes=pb.ProbeQuery(names=probes))
        return read_values(self._call(pb.Request(query=query))[0].values)

    def points(self, field: str, points: Any) -> np.ndarray:
        """A field at points [n][dim], m: kernel average over the fluid; nan where no fluid is near."""
        flat = np.atleast_2d(np.asarray(points, dtype=float)).ravel()
        query = pb.Query(points=pb.PointQuery(field=field, points=flat.tolist()))
        reply, frames = self._call(pb.Request(query=query))
        return read_array(reply.arrays[0], frames[0])

    def particles(
        self,
        fields: Sequence[str] = (),
        min: Optional[Sequence[float]] = None,
        max: Optional[Sequence[float]] = None,
        walls: bool = False,
        limit: Optional[int] = None,
        every: int = 1,
    ) -> Dict[str, np.ndarray]:
        """Particles of a box, or all: one array per field in SI units, the first index counts particles.

        fields    names as in capabilities().fields; none: position
        min, max  lower and upper corner of the box [m], as many coordinates as the case has dimensions
        limit     RESOURCE_EXHAUSTED if there are more; None: 100000
        every     about one in so many, by chance but always the same
        """
        message = pb.ParticleQuery(min=min or (), max=max or (), fields=fields, walls=walls, limit=limit, every=every)
        reply, frames = self._call(pb.Request(query=pb.Query(particles=message)))
        return {array.name: read_array(array, frame) for array, frame in zip(reply.arrays, frames)}

    # --- telemetry --------------------------------------------------------------------------------------------------

    def subscribe(self, *topics: str, timeout: Optional[float] = None) -> Iterator[Telemetry]:
        """Messages as they come, from the moment of this call on; ends after timeout [s] without any.

        topics  of "event", "log", "progress", "probe"; none: all
        """
        for topic in topics:
            if topic not in TOPICS:
                raise ValueError(f'there is no topic "{topic}"; there are {", ".join(TOPICS)}')
        socket = self._connection.context.socket(zmq.SUB)
        socket.setsockopt(zmq.LINGER, 0)
        socket.setsockopt(zmq.RCVHWM, 10000)
        for topic in topics or TOPICS:
            socket.setsockopt(zmq.SUBSCRIBE, topic.encode())
        self._connection.secure(socket)
        socket.connect(telemetry_endpoint(self._connection.endpoint))
        return _messages(socket, timeout)

    # --- under the hood ---------------------------------------------------------------------------------------------

    def _call(
        self, request: pb.Request, timeout: Optional[float] = None, request_id: Optional[bytes] = None
    ) -> Tuple[pb.Reply, List[bytes]]:
        if self._lease:
            request.lease_epoch = self._lease
        return self._connection.call(request, self.timeout if timeout is None else timeout, request_id)

    def _simple(
        self, request: pb.Request, timeout: Optional[float] = None, request_id: Optional[bytes] = None
    ) -> Reply:
        return read_reply(self._call(request, timeout, request_id)[0])

    def _output(self, request: pb.Request) -> OutputFile:
        output = self._call(request)[0].output
        return OutputFile(output.path, output.step, output.time)


def _as_yaml(value: Any) -> str:
    """A value as after --set on the command line; text is taken to be that already."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_as_yaml(item) for item in value) + "]"
    return value if isinstance(value, str) else repr(value)


def _messages(socket: zmq.Socket, timeout: Optional[float]) -> Iterator[Telemetry]:
    """The numbers of a topic rise by one, and begin anew when the daemon is restarted: a gap is a loss."""
    heard: Dict[str, Tuple[int, int]] = {}
    with socket:
        while True:
            deadline = None if timeout is None else clock.monotonic() + timeout
            if not socket.poll(None if deadline is None else int(1000 * (deadline - clock.monotonic()))):
                return
            frames = socket.recv_multipart()
            topic, message = frames[0].decode(), pb.Telemetry.FromString(frames[1])
            epoch, last = heard.get(topic, (0, 0))
            known = epoch == message.daemon_epoch and message.sequence > last
            heard[topic] = (message.daemon_epoch, message.sequence)
            yield read_telemetry(topic, message, message.sequence - last - 1 if known else 0)

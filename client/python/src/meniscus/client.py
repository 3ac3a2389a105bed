# SPDX-License-Identifier: BSD-3-Clause
"""The client: every command of the daemon as a method, telemetry as an iterator. What they say is in commands.py."""

from __future__ import annotations

import time as clock
from contextlib import contextmanager
from dataclasses import replace
from types import TracebackType
from typing import Any, Iterable, Iterator, Mapping, Optional, Type, TypeVar

import zmq

from . import commands
from .case import CaseSource
from .commands import Command, method
from .connection import Connection
from .dialogue import Listening
from .endpoint import await_endpoint, telemetry_endpoint
from .errors import LeaseError, MeniscusError, UnavailableError
from .flow import MEMORY
from .keys import choose_keys
from .streams import Stream
from .values import Reply, Telemetry
from .wishes import Box, Cursor, Exactness, Sphere, subscription

T = TypeVar("T")
Itself = TypeVar("Itself", bound="Client")
TOPICS = Listening.TOPICS


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
        endpoint = await_endpoint(daemon)
        self._connection = Connection(endpoint, choose_keys(endpoint, key, server_key))

    def close(self) -> None:
        """Disconnect; what the daemon is doing goes on."""
        self._connection.close()

    def __enter__(self: Itself) -> Itself:
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
        reply = self._do(commands.load(case, overrides, name, resume))
        return replace(self.start(), path=reply.path) if start else reply

    start = method(commands.start)
    pause = method(commands.pause)
    resume = method(commands.resume)
    step = method(commands.step)
    run_until = method(commands.run_until)
    cancel = method(commands.cancel)
    stop = method(commands.stop)
    reset = method(commands.reset)
    restore = method(commands.restore)
    checkpoint = method(commands.checkpoint)
    snapshot = method(commands.snapshot)
    wait = method(commands.wait)
    breakpoint = method(commands.breakpoint)
    shutdown = method(commands.shutdown)

    # --- values -----------------------------------------------------------------------------------------------------

    set = method(commands.set)
    rollback = method(commands.rollback)
    get = method(commands.get)
    status = method(commands.status)
    capabilities = method(commands.capabilities)
    query = method(commands.query)
    points = method(commands.points)
    particles = method(commands.particles)

    # --- the only one to change the run -------------------------------------------------------------------------------

    @contextmanager
    def lease(self, seconds: float = 30, holder: Optional[str] = None) -> Iterator[int]:
        """Be the only one to change the run while the block lasts, but for pause, stop and shutdown: `with client.lease(60):`.

        seconds  for which it lives, unless it is renewed with renew()
        holder   what others are told; None: user@host
        Yields the epoch. LeaseError: somebody else holds it; within the block, from any command that changes the run: it is over.
        """
        self._lease = self._do(commands.take_lease(seconds, holder))
        try:
            yield self._lease
        finally:
            self._give_back()

    def renew(self, seconds: float = 30) -> None:
        """Let the lease live for so long from now on."""
        self._lease = self._do(commands.renew_lease(seconds))

    def _give_back(self) -> None:
        try:
            self._do(commands.release_lease())
        except (LeaseError, UnavailableError):
            pass  # it was over, or will be; what went wrong within the block shall be seen
        finally:
            self._lease = 0

    # --- telemetry --------------------------------------------------------------------------------------------------

    def subscribe(self, *topics: str, timeout: Optional[float] = None) -> Iterator[Telemetry]:
        """Messages as they come, from the moment of this call on; ends after timeout [s] without any.

        topics  of "event", "log", "progress", "probe"; none: all
        """
        listening = Listening(topics)
        self._connection.check_process()
        socket = self._connection.context.socket(zmq.SUB)
        listening.prepare(socket, self._connection.endpoint, self._connection.keys)
        socket.connect(telemetry_endpoint(self._connection.endpoint))
        return _messages(self._connection, socket, listening, timeout)

    def samples(self, timeout: Optional[float] = None) -> Iterator[Telemetry]:
        """Probe samples as they are taken, as subscribe() has them."""
        return self.subscribe("probe", timeout=timeout)

    def events(self, timeout: Optional[float] = None) -> Iterator[Telemetry]:
        """Events as they happen, as subscribe() has them."""
        return self.subscribe("event", timeout=timeout)

    # --- streams ----------------------------------------------------------------------------------------------------

    def stream(
        self,
        what: str = "probes",
        *names: str,
        since: Optional[Cursor] = None,
        timeout: Optional[float] = None,
        memory: int = MEMORY,
        exact: Exactness = None,
        pack: str = "none",
        every_steps: Optional[int] = None,
        interval: Optional[float] = None,
        max_hz: Optional[float] = None,
        first: bool = False,
        box: Optional[Box] = None,
        sphere: Optional[Sphere] = None,
        phases: Iterable[int] = (),
        walls: bool = False,
        every: Optional[int] = None,
    ) -> Stream:
        """Data at your own pace: `with client.stream("fields", "position", "pressure", max_hz=10) as stream: for item in stream`.

        what    "probes", "fields" or "events": the newest; what was due while you were busy is skipped, and counted in item.skipped.
                "series" or "snapshots": the rows of the probes' series, or the snapshot files byte for byte, once they are on the disk:
                all of them, in order, also over lost connections and new starts of the daemon
        names   of probes (none: all), or of fields (1 to 16)
        since   a Cursor, to go on behind what was taken before: of "series" and "snapshots"; None: from the beginning
        timeout the iteration ends after so long without an item [s]; None: never
        memory  bytes that an item may have, packed or unpacked
        exact   "f64", "f32", or a bound: no value is off by as much, in its own unit; of fields also {name: any of these}
        pack    "none", "lz4" or "zstd"
        every_steps, interval [s, simulated], max_hz     when: at multiples of these, at most so often
        first   one item at once, of this moment; without it the first comes with the next step, for which a run that stands still keeps you waiting
        box=(min, max), sphere=(centre, radius) [m], phases, walls, every     which particles; `every`: about one in so many

        item["pressure"] is an array of numpy: [particles] or [particles][components] of fields, a number of probes, [rows] of series.
        RefusedError: a name or bound is wrong, error.path says which. While it is iterated: CorruptError if an item came damaged,
        UnavailableError if the daemon is away for more than five seconds; the stream may be asked again after both, and goes on.
        """
        wish = subscription(
            what, names, exact, pack, every_steps, interval, max_hz, first, box, sphere, phases, walls, every
        )
        return Stream(self._connection.endpoint, self._connection.keys, what, wish, since, timeout, memory)

    # --- under the hood ---------------------------------------------------------------------------------------------

    def _do(self, command: Command[T]) -> T:
        if self._lease:
            command.request.lease_epoch = self._lease
        timeout = self.timeout if command.timeout is None else command.timeout
        try:
            return command.read(*self._connection.call(command.request, timeout, command.request_id))
        except MeniscusError as error:
            if not command.explain:
                raise
            raise command.explain(error) from None


def _messages(
    connection: Connection, socket: zmq.Socket, listening: Listening, timeout: Optional[float]
) -> Iterator[Telemetry]:
    with socket:
        while True:
            connection.check_process()
            deadline = None if timeout is None else clock.monotonic() + timeout
            if not socket.poll(None if deadline is None else int(1000 * (deadline - clock.monotonic()))):
                return
            yield listening.read(socket.recv_multipart())

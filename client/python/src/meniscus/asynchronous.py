# SPDX-License-Identifier: BSD-3-Clause
"""The client for asyncio: the methods of Client, to be awaited. Several may be under way at once, over one connection."""

from __future__ import annotations

import asyncio
import os
from contextlib import asynccontextmanager
from dataclasses import replace
from types import TracebackType
from typing import Any, AsyncIterator, Generator, Iterable, List, Mapping, Optional, Tuple, Type, TypeVar, Union

import zmq
import zmq.asyncio
from zmq.utils.monitor import parse_monitor_message

from . import commands
from . import meniscus_pb2 as pb
from .case import CaseSource
from .commands import Command, async_method
from .dialogue import EVENTS, TRY_S, Answer, Dialogue, Listening, Send, Wait, prepare_control
from .endpoint import async_await_endpoint, data_endpoint, telemetry_endpoint
from .errors import LeaseError, MeniscusError, UnavailableError
from .flow import MEMORY, Flow, StreamFacts
from .keys import Keys, choose_keys
from .process import OfOneProcess
from .stream_pb2 import Subscribe
from .values import Reply, Telemetry
from .wishes import Box, Cursor, Exactness, Sphere, StreamItem, subscription

T = TypeVar("T")
CANCELLED = ("load", "step", "run_until", "wait")  # what lasts: nobody wants it any more when its task is cancelled
LINGER_MS = 500  # for the last word, which may be a cancel


class AsyncConnection(OfOneProcess):
    """The dialogue over a socket of the running loop. One task takes in messages, one the events of the connection."""

    def __init__(self, endpoint: str, keys: Optional[Keys] = None, dialogue: Optional[Dialogue] = None) -> None:
        super().__init__()
        self.endpoint = endpoint
        self.keys = keys
        self._dialogue = dialogue or Dialogue(endpoint, keys)
        self._news: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.context = zmq.asyncio.Context()
        self._socket = self.context.socket(zmq.DEALER)
        self._monitor = self._socket.get_monitor_socket(EVENTS)
        prepare_control(self._socket, endpoint, keys)
        self._closed = False
        self._tasks = [asyncio.ensure_future(self._take_in()), asyncio.ensure_future(self._watch())]

    async def open(self) -> None:
        """Connect, and ask whether somebody is there."""
        try:
            self._socket.connect(self.endpoint)
            await self.do(self._dialogue.connect())
        except BaseException:
            await self.close()
            raise

    @property
    def epoch(self) -> int:
        """Of the daemon: another number after every start of it."""
        return self._dialogue.epoch

    async def close(self) -> None:
        """Disconnect. Commands that were accepted go on without us; who awaits one is told. In a forked process the sockets are the
        parent's."""
        if self._closed or self.is_inherited:
            return
        self._closed = True
        self._tell()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close(LINGER_MS)
        self.context.destroy(LINGER_MS)

    async def call(self, request: pb.Request, timeout: Optional[float], request_id: Optional[bytes]) -> Answer:
        """Dialogue.call(). When its task is cancelled, the daemon is told that nobody waits for it any more."""
        self.check_process()
        try:
            return await self.do(self._dialogue.call(request, timeout, request_id))
        except asyncio.CancelledError:
            if request.WhichOneof("command") in CANCELLED:
                self._call_off(request.id)
            raise

    def _call_off(self, request_id: bytes) -> None:
        """Its answer interests nobody: what has ended by itself cannot be cancelled."""
        request = pb.Request(major=pb.PROTOCOL_MAJOR, id=os.urandom(16), cancel=pb.Cancel(id=request_id))
        sent: "asyncio.Future[Any]" = self._socket.send(request.SerializeToString(), zmq.DONTWAIT)  # type: ignore[assignment]
        sent.add_done_callback(lambda done: done.cancelled() or done.exception())

    async def do(self, steps: Generator[Union[Send, Wait], bool, T]) -> T:
        """What the dialogue says is to be done, to its end."""
        self.check_process()
        try:
            step = next(steps)
            while True:
                if self._closed:
                    raise UnavailableError("UNAVAILABLE", "the connection was closed meanwhile; what was accepted goes on")
                if isinstance(step, Send):
                    step = steps.send(await self._send(step.frame))
                else:
                    step = steps.send(await self._wait(step.seconds))
        except StopIteration as end:
            result: T = end.value
            return result
        finally:
            steps.close()

    async def _send(self, frame: bytes) -> bool:
        try:
            await self._socket.send(frame, zmq.DONTWAIT)
            return True
        except zmq.Again:
            await self._socket.poll(int(1000 * TRY_S), zmq.POLLOUT)
            return False

    async def _wait(self, seconds: float) -> bool:
        await asyncio.wait([self._news], timeout=seconds)
        return False

    def _tell(self) -> None:
        """All calls under way look whether it concerns them."""
        news, self._news = self._news, asyncio.get_running_loop().create_future()
        news.set_result(None)

    async def _take_in(self) -> None:
        while True:
            frames = await self._socket.recv_multipart(copy=False)
            self._dialogue.deliver([frame.buffer for frame in frames])
            self._tell()

    async def _watch(self) -> None:
        while True:
            self._dialogue.note(parse_monitor_message(await self._monitor.recv_multipart())["event"])
            self._tell()


class AsyncClient:
    """A connection to a daemon for asyncio; arguments, results and failures are those of Client.

        async with meniscus.AsyncClient("lab") as client:
            await client.load("dambreak2d", start=True)
            async for sample in client.samples():
                print(sample.time, sample.values["front"].value)

    Without `async with`: `client = await AsyncClient("lab").connect()`, and `await client.close()` at the end.

    Commands may be awaited side by side, as in `asyncio.gather(client.wait(), client.status())`. When a task is cancelled that awaits a
    load, step, run_until or wait, as by `asyncio.wait_for`, the daemon ends the command at the next step boundary; other
    commands have their effect. A command cut off by a lost connection is sent again under the same id, so it happens once.
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
        self._daemon, self._key, self._server_key = daemon, key, server_key
        self._connection: Optional[AsyncConnection] = None

    async def connect(self) -> AsyncClient:
        """Connect, with the loop that is running. UnavailableError if there is no such daemon."""
        if not self._connection:
            endpoint = await async_await_endpoint(self._daemon)
            connection = AsyncConnection(endpoint, choose_keys(endpoint, self._key, self._server_key))
            await connection.open()
            self._connection = connection
        return self

    async def close(self) -> None:
        """Disconnect; what the daemon is doing goes on."""
        connection, self._connection = self._connection, None
        if connection:
            await connection.close()

    async def __aenter__(self) -> AsyncClient:
        return await self.connect()

    async def __aexit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        await self.close()

    # --- the run ----------------------------------------------------------------------------------------------------

    async def load(
        self,
        case: CaseSource,
        overrides: Optional[Mapping[str, Any]] = None,
        name: Optional[str] = None,
        resume: bool = False,
        start: bool = False,
    ) -> Reply:
        """Load a case, as Client.load()."""
        reply = await self._do(commands.load(case, overrides, name, resume))
        return replace(await self.start(), path=reply.path) if start else reply

    start = async_method(commands.start)
    pause = async_method(commands.pause)
    resume = async_method(commands.resume)
    step = async_method(commands.step)
    run_until = async_method(commands.run_until)
    cancel = async_method(commands.cancel)
    stop = async_method(commands.stop)
    reset = async_method(commands.reset)
    restore = async_method(commands.restore)
    checkpoint = async_method(commands.checkpoint)
    snapshot = async_method(commands.snapshot)
    wait = async_method(commands.wait)
    breakpoint = async_method(commands.breakpoint)
    shutdown = async_method(commands.shutdown)

    # --- values -----------------------------------------------------------------------------------------------------

    set = async_method(commands.set)
    rollback = async_method(commands.rollback)
    get = async_method(commands.get)
    status = async_method(commands.status)
    capabilities = async_method(commands.capabilities)
    query = async_method(commands.query)
    points = async_method(commands.points)
    particles = async_method(commands.particles)

    # --- the only one to change the run -------------------------------------------------------------------------------

    @asynccontextmanager
    async def lease(self, seconds: float = 30, holder: Optional[str] = None) -> AsyncIterator[int]:
        """Be the only one to change the run while the block lasts: `async with client.lease(60):`, as Client.lease()."""
        self._lease = await self._do(commands.take_lease(seconds, holder))
        try:
            yield self._lease
        finally:
            await self._give_back()

    async def renew(self, seconds: float = 30) -> None:
        """Let the lease live for so long from now on."""
        self._lease = await self._do(commands.renew_lease(seconds))

    async def _give_back(self) -> None:
        try:
            await self._do(commands.release_lease())
        except (LeaseError, UnavailableError):
            pass  # it was over, or will be; what went wrong within the block shall be seen
        finally:
            self._lease = 0

    # --- telemetry --------------------------------------------------------------------------------------------------

    def subscribe(self, *topics: str, timeout: Optional[float] = None) -> Messages:
        """Messages as they come, from the moment of this call on, for `async for`; ends after timeout [s] without any.

        topics  of "event", "log", "progress", "probe"; none: all
        """
        return Messages(self._connected(), Listening(topics), timeout)

    def samples(self, timeout: Optional[float] = None) -> Messages:
        """Probe samples as they are taken, as subscribe() has them."""
        return self.subscribe("probe", timeout=timeout)

    def events(self, timeout: Optional[float] = None) -> Messages:
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
    ) -> AsyncStream:
        """Data at your own pace, as Client.stream(): `async with client.stream(...) as stream: async for item in stream`."""
        connection = self._connected()
        wish = subscription(
            what, names, exact, pack, every_steps, interval, max_hz, first, box, sphere, phases, walls, every
        )
        return AsyncStream(connection.endpoint, connection.keys, what, wish, since, timeout, memory)

    # --- under the hood ---------------------------------------------------------------------------------------------

    def _connected(self) -> AsyncConnection:
        if not self._connection:
            raise RuntimeError("not connected: use `async with AsyncClient(...)`, or await connect() first")
        return self._connection

    async def _do(self, command: Command[T]) -> T:
        if self._lease:
            command.request.lease_epoch = self._lease
        timeout = self.timeout if command.timeout is None else command.timeout
        try:
            return command.read(*await self._connected().call(command.request, timeout, command.request_id))
        except MeniscusError as error:
            if not command.explain:
                raise
            raise command.explain(error) from None


class AsyncStream(StreamFacts):
    """Items for `async for`, until it is closed, or for the timeout of the stream none came."""

    def __init__(
        self,
        endpoint: str,
        keys: Optional[Keys],
        what: str,
        wish: Subscribe,
        since: Optional[Cursor],
        timeout: Optional[float],
        memory: int,
    ) -> None:
        self._flow = Flow(data_endpoint(endpoint), keys, what, wish, since, memory)
        self._timeout = timeout
        self._connection: Optional[AsyncConnection] = None
        self._opening = asyncio.Lock()
        self._closed = False

    async def open(self) -> AsyncStream:
        """Subscribe, as `async with` does."""
        async with self._opening:
            self._check_open()
            if not self._connection:
                self._connection = AsyncConnection(self._flow.endpoint, self._flow.keys, self._flow)
                try:
                    await self._connection.open()
                except BaseException:
                    self._connection = None
                    self._check_open()
                    raise
        return self

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError("the stream is closed")

    async def next(self, timeout: Optional[float] = None) -> Optional[StreamItem]:
        """The next item; None if there was none within so many seconds. RuntimeError: the stream is closed, before or meanwhile."""
        await self.open()
        assert self._connection
        try:
            item: Optional[StreamItem] = await self._connection.do(self._flow.next(timeout))
        except UnavailableError:
            self._check_open()
            raise
        return item

    async def cancel(self) -> None:
        """Give up the item under way; the next one follows. Not of a series."""
        if self._connection:
            await self._connection.do(self._flow.cancel())

    def __aiter__(self) -> AsyncStream:
        return self

    async def __anext__(self) -> StreamItem:
        try:
            item = await self.next(self._timeout)
        except RuntimeError:
            if not self._closed:
                raise
            item = None
        if item is None:
            raise StopAsyncIteration
        return item

    async def aclose(self) -> None:
        """Take no more. Who awaits an item is told."""
        connection, self._connection, self._closed = self._connection, None, True
        if connection:
            try:
                await connection.do(self._flow.close())
            except MeniscusError:
                pass  # nobody is there to be told
            await connection.close()

    async def __aenter__(self) -> AsyncStream:
        return await self.open()

    async def __aexit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        await self.aclose()


class Messages:
    """Telemetry for `async for`. It listens until it is closed, with `async with` or aclose(), or its client is."""

    def __init__(self, connection: AsyncConnection, listening: Listening, timeout: Optional[float]) -> None:
        connection.check_process()
        self._connection = connection
        self._listening = listening
        self._timeout_ms = None if timeout is None else int(1000 * timeout)
        self._socket = connection.context.socket(zmq.SUB)
        listening.prepare(self._socket, connection.endpoint, connection.keys)
        self._socket.connect(telemetry_endpoint(connection.endpoint))

    def __aiter__(self) -> Messages:
        return self

    async def __anext__(self) -> Telemetry:
        self._connection.check_process()
        if not await self._ready():
            await self.aclose()
            raise StopAsyncIteration
        frames: List[bytes] = await self._socket.recv_multipart()
        return self._listening.read(frames)

    async def _ready(self) -> bool:
        try:
            return not self._socket.closed and bool(await self._socket.poll(self._timeout_ms))
        except asyncio.CancelledError:
            if not self._socket.closed:
                raise
            return False  # who closes a socket cancels what is waited for; nobody cancelled us

    async def aclose(self) -> None:
        """Listen no more."""
        self._socket.close(0)

    async def __aenter__(self) -> Messages:
        return self

    async def __aexit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        await self.aclose()

# SPDX-License-Identifier: BSD-3-Clause
"""Requests and their replies, without a socket: ids, deadlines, safe repetition, checked arrays, lost messages.

Dialogue tells what to send and how long to wait, as steps of a generator; Connection and AsyncConnection do it and report
what came and what became of the connection. So both mean the same by a lost connection, a deadline and a damaged array.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Any, Dict, Generator, List, Optional, Tuple, Union

import xxhash
import zmq
from google.protobuf.message import DecodeError

from . import meniscus_pb2 as pb
from .errors import CorruptError, DeniedError, MeniscusError, TimedOutError, UnavailableError, error_for
from .escapes import shown
from .keys import Keys
from .texts import check_text
from .values import Frame, Telemetry, code_of, read_telemetry

CONNECT_S = 5.0  # to a daemon that should be there
REFUSALS = 3  # a tenth of a second apart: where nobody listens then, nobody is about to, as a daemon started just now is
CUTS = 3  # handshakes in a row that end without a word: so often it is for what we say, and not for who has just been started anew
RECONNECT_S = 5.0  # to a daemon that was there
GREETING_S = 5.0  # a daemon answers greetings at once, whatever it computes
GRACE_S = 2.0  # beyond the deadline that the daemon knows, for its answer to get here
TRY_S = 0.1  # to send, before we look what became of the connection
MAX_REQUEST = 1 << 20  # bytes; a daemon takes no more
MAX_ENDED = 2  # daemons that end while they have a request: once is an accident
FAILURES = (zmq.EVENT_HANDSHAKE_FAILED_AUTH, zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL, zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL)
EVENTS = zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED | zmq.EVENT_CONNECT_RETRIED | sum(FAILURES)


@dataclass(frozen=True)
class Send:
    """Send a frame, if that is possible within TRY_S. The generator is told whether it was."""

    frame: bytes


@dataclass(frozen=True)
class Wait:
    """Return when something came or happened, or after so many seconds."""

    seconds: float


Answer = Tuple[pb.Reply, List[Frame]]
Connecting = Generator[Union[Send, Wait], bool, None]
Calling = Generator[Union[Send, Wait], bool, Answer]


class Dialogue:
    """With one daemon, over a connection that may be lost and made anew. Any number of calls may be under way."""

    def __init__(self, endpoint: str, keys: Optional[Keys] = None) -> None:
        self.endpoint = endpoint
        self.keys = keys
        self.epoch = 0  # of the daemon
        self._failed = 0  # the event of a handshake that failed since
        self._refusals = 0
        self._cut = 0  # handshakes in a row that ended without a word
        self._was_cut = False  # the last attempt did
        self._connected = False
        self._connections = 0
        self._lost_since = time.monotonic()
        self._answers: Dict[bytes, Union[None, Answer, MeniscusError]] = {}  # of calls under way

    def _why_closed(self) -> str:
        """A daemon whose places are used up ends a connection as one does that cannot make sense of the handshake: without a word."""
        full = "its places for connections are used up (see its log, which names the process that has most of them)"
        who = f"the program at {self.endpoint} closes each connection at once"
        if self.endpoint.startswith("ipc://"):
            return f"{who}: {full}, or it is no daemon"
        what = f"does not have the secret of the server key {self.keys.server}" if self.keys else "takes no plain text"
        return f"{who}: it {what} (see the keys of the daemon), or {full}"

    # --- what the transport reports -------------------------------------------------------------------------------------

    def note(self, event: int) -> None:
        """Something happened to the connection: an event of ZeroMQ.

        Whoever cannot make sense of what we say ends the connection without a word, as does one that dies or is started anew at
        that moment: which it was is seen when ZeroMQ has tried again.
        """
        if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
            self._connected, self._was_cut = True, False
            self._failed = self._cut = self._refusals = 0
            self._connections += 1
        elif event == zmq.EVENT_DISCONNECTED and self._connected:
            self._connected = False
            self._lost_since = time.monotonic()
        elif event == zmq.EVENT_CONNECT_RETRIED:  # also after a cut, which is no refusal
            self._refusals += not self._was_cut
            self._was_cut = False
        elif event == zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL:
            self._cut, self._was_cut = self._cut + 1, True
            if self._cut >= CUTS:
                self._failed = self._failed or event
        elif event in FAILURES and self._failed != zmq.EVENT_HANDSHAKE_FAILED_AUTH:
            self._failed = event

    def deliver(self, frames: List[Frame]) -> None:
        """A message came. What nobody waits for is dropped."""
        try:
            reply = pb.Reply.FromString(bytes(frames[0]))
        except DecodeError:
            text = "cannot read the reply; is this a meniscusd of this version?"
            for call in self._answers:
                self._answers[call] = MeniscusError("UNIMPLEMENTED", text)
            return
        if reply.id in self._answers:
            self._answers[reply.id] = reply, frames[1:]

    # --- what the transport is to do ------------------------------------------------------------------------------------

    def connect(self) -> Connecting:
        """Wait until it is connected, and ask whether somebody is there."""
        deadline = time.monotonic() + CONNECT_S
        self._refusals = 0
        while not (self._connected or self._failed or self._refusals >= REFUSALS) and time.monotonic() < deadline:
            yield Wait(max(0.001, deadline - time.monotonic()))
        self._check_denied()
        if self._failed:
            raise UnavailableError("UNAVAILABLE", self._why_closed())
        if not self._connected and self._cut:
            why = "was lost before it stood, and trying again did not help in time; who listens there may be starting anew: try again"
            raise UnavailableError("UNAVAILABLE", f"the connection to {self.endpoint} {why}")
        if not self._connected and not self._refusals:
            why = "who listens there hangs, or the network loses what is sent; see `meniscus ls` on its machine"
            raise UnavailableError("UNAVAILABLE", f"no answer from {self.endpoint}: {why}")
        if not self._connected:
            raise UnavailableError("UNAVAILABLE", f"nobody listens at {self.endpoint}; start a daemon with `meniscusd`")
        yield from self._greet()

    def call(self, request: pb.Request, timeout: Optional[float] = None, request_id: Optional[bytes] = None) -> Calling:
        """Send a request, wait for its reply and the frames of its arrays; raise what error_for() makes of a code."""
        request.major = pb.PROTOCOL_MAJOR
        request.id = request_id or os.urandom(16)
        if timeout is not None:
            request.deadline_ms = int(1000 * timeout)
        if request.id in self._answers:
            raise ValueError("a request of this id is under way already")
        self._answers[request.id] = None
        try:
            reply, frames = yield from self._exchange(request, timeout)
        finally:
            del self._answers[request.id]
        code = code_of(reply)
        if code != "OK":
            allowed = [pb.State.Name(state) for state in reply.allowed]
            raise error_for(code, reply.message, reply.path, reply.reason, allowed)
        check(reply, frames)
        return reply, frames

    def _greet(self) -> Connecting:
        request = pb.Request(status=pb.GetStatus())
        try:
            reply, _ = yield from self.call(request, GREETING_S)
        except TimedOutError:
            raise UnavailableError("UNAVAILABLE", f"{self.endpoint} is open, but nobody answers there") from None
        self.epoch = reply.daemon_epoch

    def _exchange(self, request: pb.Request, timeout: Optional[float]) -> Calling:
        packed = request.SerializeToString()
        if len(packed) > MAX_REQUEST:
            text = f"the request has {len(packed)} bytes, a daemon takes {MAX_REQUEST}; send it in parts"
            raise MeniscusError("RESOURCE_EXHAUSTED", text)
        deadline = None if timeout is None else time.monotonic() + timeout + GRACE_S
        ended = 0  # daemons, while they had the request
        while True:
            yield Wait(0)  # learn what happened since the last call
            connections = yield from self._send(packed)
            answer = yield from self._await_answer(request.id, connections, deadline)
            if answer:
                return answer
            kind = request.WhichOneof("command")
            if kind == "status":
                continue
            before = self.epoch
            yield from self._greet()
            if self.epoch != before and kind != "wait":
                ended += 1
                self._check_repeatable(kind, ended)

    def _check_repeatable(self, kind: Optional[str], ended: int) -> None:
        """May it be given to a daemon that was started since? The one before has ended, which is all that a shutdown wants, and
        what another request may have brought about: one that ends every daemon must not be given to each that is started. A wait
        brings nothing about."""
        if kind == "shutdown":
            text = "the daemon ended before it answered, and another was started; give the command again if that shall end too"
            raise UnavailableError("UNAVAILABLE", text)
        if ended >= MAX_ENDED:
            text = f"the daemon at {self.endpoint} ended {ended} times before it answered, perhaps because of this command"
            more = "which is not given to it again: see its log for why, and status() for what took effect"
            raise UnavailableError("UNAVAILABLE", f"{text}, {more}")

    def _send(self, packed: bytes) -> Generator[Union[Send, Wait], bool, int]:
        """Returns how many connections there had been by then."""
        deadline = time.monotonic() + RECONNECT_S
        while True:
            connections = self._connections
            if (yield Send(packed)):
                if not self._connected:  # a connection took it, which we shall hear of: the one that was lost may have been so for long
                    self._lost_since = time.monotonic()
                return connections
            self._check_denied()
            if time.monotonic() > deadline:
                raise self._gone()

    def _await_answer(
        self, request_id: bytes, connections: int, deadline: Optional[float]
    ) -> Generator[Union[Send, Wait], bool, Optional[Answer]]:
        """The answer; None if the connection was made anew, so that it may be lost."""
        while True:
            answer = self._answers[request_id]
            if isinstance(answer, MeniscusError):
                raise answer
            if answer:
                return answer
            if self._connections > connections:
                return None
            self._check_denied()
            now = time.monotonic()
            if not self._connected and now > self._lost_since + RECONNECT_S:
                raise self._gone()
            if deadline is not None and now > deadline:
                raise TimedOutError("DEADLINE_EXCEEDED", f"no answer from {self.endpoint} in time")
            yield Wait(1 if deadline is None else max(0.001, min(1, deadline - now)))

    def _check_denied(self) -> None:
        """ZeroMQ does not try again when a key was refused."""
        if self.keys and self._failed == zmq.EVENT_HANDSHAKE_FAILED_AUTH:
            text = f"the daemon at {self.endpoint} does not let in the key {self.keys.public}"
            raise DeniedError("UNAUTHENTICATED", f"{text}; on its machine, `meniscus keys list` tells which it does")

    def _gone(self) -> UnavailableError:
        return UnavailableError(
            "UNAVAILABLE", f"the daemon at {self.endpoint} went away; whether the command took effect is not known"
        )


def check(reply: pb.Reply, frames: List[Frame]) -> None:
    """CorruptError unless the frames are those that the reply announces."""
    if len(reply.arrays) != len(frames):
        raise CorruptError("DATA_LOSS", f"the reply announces {len(reply.arrays)} arrays and has {len(frames)}")
    for array, frame in zip(reply.arrays, frames):
        if xxhash.xxh64_intdigest(frame) != array.xxh64:
            raise CorruptError("DATA_LOSS", f'array "{array.name}" came damaged: its checksum does not match')


def prepare(socket: Any, endpoint: str, keys: Optional[Keys]) -> None:
    """Options of any socket to a daemon, before it is connected."""
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.IPV6, int("[" in endpoint))
    if keys:
        keys.secure(socket)


def prepare_control(socket: Any, endpoint: str, keys: Optional[Keys]) -> None:
    """The same for that of the commands: a daemon that died is noticed without a time limit."""
    prepare(socket, endpoint, keys)
    socket.setsockopt(zmq.IMMEDIATE, 1)
    socket.setsockopt(zmq.HEARTBEAT_IVL, 2000)
    socket.setsockopt(zmq.HEARTBEAT_TIMEOUT, 6000)
    socket.setsockopt(zmq.RECONNECT_IVL_MAX, 1000)


class Listening:
    """What was heard of each topic: numbers rise by one, and begin anew when the daemon is restarted; a gap is a loss."""

    TOPICS = ("event", "log", "progress", "probe")

    def __init__(self, topics: Tuple[str, ...]) -> None:
        for topic in topics:
            check_text("topics", topic)
            if topic not in self.TOPICS:
                raise ValueError(f'there is no topic "{shown(topic)}"; there are {", ".join(self.TOPICS)}')
        self.topics = topics or self.TOPICS
        self._heard: Dict[str, Tuple[int, int]] = {}

    def prepare(self, socket: Any, endpoint: str, keys: Optional[Keys]) -> None:
        """Options of a SUB socket, before it is connected."""
        prepare(socket, endpoint, keys)
        socket.setsockopt(zmq.RCVHWM, 10000)
        for topic in self.topics:
            socket.setsockopt(zmq.SUBSCRIBE, topic.encode())

    def read(self, frames: List[bytes]) -> Telemetry:
        """A message that came."""
        topic, message = frames[0].decode(), pb.Telemetry.FromString(frames[1])
        epoch, last = self._heard.get(topic, (0, 0))
        known = epoch == message.daemon_epoch and message.sequence > last
        self._heard[topic] = (message.daemon_epoch, message.sequence)
        return read_telemetry(topic, message, message.sequence - last - 1 if known else 0)

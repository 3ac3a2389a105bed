# SPDX-License-Identifier: BSD-3-Clause
"""A request and its reply over a socket: ids, deadlines, safe repetition, checked arrays."""

from __future__ import annotations

import os
import time
from typing import List, Optional, Tuple

import zmq
from google.protobuf.message import DecodeError
from zmq.utils.monitor import recv_monitor_message

from . import meniscus_pb2 as pb
from .checksum import xxh64
from .errors import CorruptError, DeniedError, MeniscusError, TimedOutError, UnavailableError, error_for
from .keys import Keys

CONNECT_S = 5.0  # to a daemon that should be there: where nobody listens it is known at once
RECONNECT_S = 5.0  # to a daemon that was there
GREETING_S = 5.0  # a daemon answers greetings at once, whatever it computes
GRACE_S = 2.0  # beyond the deadline that the daemon knows, for its answer to get here
MAX_REQUEST = 1 << 20  # bytes; a daemon takes no more
FAILURES = (zmq.EVENT_HANDSHAKE_FAILED_AUTH, zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL, zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL)


class Connection:
    """One DEALER socket. A monitor tells when it is connected, so a dead daemon is noticed without a time limit."""

    def __init__(self, endpoint: str, keys: Optional[Keys] = None) -> None:
        self.endpoint = endpoint
        self._keys = keys
        self._failed = 0  # the event of a handshake that failed since
        self.epoch = 0
        self._connected = False
        self._connections = 0
        self._lost_since = time.monotonic()
        self.context = zmq.Context()
        self._socket = self.context.socket(zmq.DEALER)
        self._monitor = self._socket.get_monitor_socket(
            zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED | zmq.EVENT_CONNECT_RETRIED | sum(FAILURES)
        )
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.IMMEDIATE, 1)
        self._socket.setsockopt(zmq.HEARTBEAT_IVL, 2000)
        self._socket.setsockopt(zmq.HEARTBEAT_TIMEOUT, 6000)
        self._socket.setsockopt(zmq.RECONNECT_IVL_MAX, 1000)
        self.secure(self._socket)
        try:
            self._socket.connect(endpoint)
            self._await_connection()
            self._greet()
        except BaseException:
            self.close()
            raise

    def secure(self, socket: zmq.Socket) -> None:
        """Prepare a socket for this daemon, before it is connected."""
        socket.setsockopt(zmq.IPV6, int("[" in self.endpoint))
        if self._keys:
            self._keys.secure(socket)

    def close(self) -> None:
        """Disconnect. Commands that were accepted go on without us."""
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close(0)
        self.context.destroy(0)

    def call(
        self, request: pb.Request, timeout: Optional[float] = None, request_id: Optional[bytes] = None
    ) -> Tuple[pb.Reply, List[bytes]]:
        """Send a request, wait for its reply and the frames of its arrays; raise what error_for() makes of a code."""
        request.major = pb.PROTOCOL_MAJOR
        request.id = request_id or os.urandom(16)
        if timeout is not None:
            request.deadline_ms = int(1000 * timeout)
        reply, frames = self._exchange(request, timeout)
        if reply.code != pb.OK:
            known = reply.code in pb.Code.values()
            code = pb.Code.Name(reply.code) if known else str(reply.code)
            allowed = [pb.State.Name(state) for state in reply.allowed]
            raise error_for(code, reply.message, reply.path, reply.reason, allowed)
        _check(reply, frames)
        return reply, frames

    def _greet(self) -> None:
        request = pb.Request(status=pb.GetStatus())
        try:
            self.epoch = self.call(request, GREETING_S)[0].daemon_epoch
        except TimedOutError:
            raise UnavailableError("UNAVAILABLE", f"{self.endpoint} is open, but nobody answers there") from None

    def _exchange(self, request: pb.Request, timeout: Optional[float]) -> Tuple[pb.Reply, List[bytes]]:
        packed = request.SerializeToString()
        if len(packed) > MAX_REQUEST:
            text = f"the request has {len(packed)} bytes, a daemon takes {MAX_REQUEST}"
            raise MeniscusError("RESOURCE_EXHAUSTED", text)
        deadline = None if timeout is None else time.monotonic() + timeout + GRACE_S
        while True:
            self._send(packed)
            answer = self._await_reply(request.id, deadline)
            if answer:
                return answer
            if request.WhichOneof("command") != "status":
                self._check_repeatable(request)

    def _check_repeatable(self, request: pb.Request) -> None:
        before = self.epoch
        self._greet()
        if self.epoch != before and request.HasField("shutdown"):
            text = "the daemon ended before it answered, and another was started; give the command again if that shall end too"
            raise UnavailableError("UNAVAILABLE", text)

    def _send(self, packed: bytes) -> None:
        deadline = time.monotonic() + RECONNECT_S
        while True:
            self._note_events()
            try:
                self._socket.send(packed, zmq.DONTWAIT)
                return
            except zmq.Again:
                self._check_denied()
                if time.monotonic() > deadline:
                    raise self._gone() from None
                self._socket.poll(100, zmq.POLLOUT)

    def _await_reply(self, request_id: bytes, deadline: Optional[float]) -> Optional[Tuple[pb.Reply, List[bytes]]]:
        """The reply; None if the connection was made anew, so that it may be lost."""
        connections = self._connections
        poller = zmq.Poller()
        poller.register(self._socket, zmq.POLLIN)
        poller.register(self._monitor, zmq.POLLIN)
        while True:
            until = min(deadline or float("inf"), time.monotonic() + 1)
            ready = dict(poller.poll(max(0, int(1000 * (until - time.monotonic())) + 1)))
            if self._socket in ready:
                reply, frames = _unpack(self._socket.recv_multipart())
                if reply.id == request_id:
                    return reply, frames
                continue
            self._note_events()
            if self._connections > connections:
                return None
            self._check_denied()
            now = time.monotonic()
            if not self._connected and now > self._lost_since + RECONNECT_S:
                raise self._gone()
            if deadline is not None and now > deadline:
                raise TimedOutError("DEADLINE_EXCEEDED", f"no answer from {self.endpoint} in time")

    def _note_events(self) -> int:
        event = 0
        while self._monitor.poll(0):
            event = int(recv_monitor_message(self._monitor)["event"])
            if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
                self._connected = True
                self._failed = 0
                self._connections += 1
            elif event == zmq.EVENT_DISCONNECTED and self._connected:
                self._connected = False
                self._lost_since = time.monotonic()
            elif event in FAILURES and self._failed != zmq.EVENT_HANDSHAKE_FAILED_AUTH:
                self._failed = event
        return event

    def _check_denied(self) -> None:
        """ZeroMQ does not try again when a key was refused."""
        if self._keys and self._failed == zmq.EVENT_HANDSHAKE_FAILED_AUTH:
            text = f"the daemon at {self.endpoint} does not let in the key {self._keys.public}"
            raise DeniedError("UNAUTHENTICATED", f"{text}; on its machine, `meniscus keys list` tells which it does")

    def _await_connection(self) -> None:
        deadline = time.monotonic() + CONNECT_S
        event = 0
        while not (self._connected or self._failed or event == zmq.EVENT_CONNECT_RETRIED) and time.monotonic() < deadline:
            self._monitor.poll(max(1, int(1000 * (deadline - time.monotonic()))))
            event = self._note_events()
        self._check_denied()
        if self._failed:
            what = f"does not have the secret of the server key {self._keys.server}" if self._keys else "takes no plain text"
            raise UnavailableError("UNAVAILABLE", f"whoever listens at {self.endpoint} {what}; see the keys of the daemon")
        if not self._connected:
            raise UnavailableError("UNAVAILABLE", f"nobody listens at {self.endpoint}; start a daemon with `meniscusd`")

    def _gone(self) -> UnavailableError:
        return UnavailableError(
            "UNAVAILABLE", f"the daemon at {self.endpoint} went away; whether the command took effect is not known"
        )


def _unpack(frames: List[bytes]) -> Tuple[pb.Reply, List[bytes]]:
    try:
        return pb.Reply.FromString(frames[0]), frames[1:]
    except DecodeError:
        raise MeniscusError("UNIMPLEMENTED", "cannot read the reply; is this a meniscusd of this version?") from None


def _check(reply: pb.Reply, frames: List[bytes]) -> None:
    if len(reply.arrays) != len(frames):
        raise CorruptError("DATA_LOSS", f"the reply announces {len(reply.arrays)} arrays and has {len(frames)}")
    for array, frame in zip(reply.arrays, frames):
        if xxh64(frame) != array.xxh64:
            raise CorruptError("DATA_LOSS", f'array "{array.name}" came damaged: its checksum does not match')

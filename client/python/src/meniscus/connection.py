# SPDX-License-Identifier: BSD-3-Clause
"""The dialogue over a socket that is waited for."""

from __future__ import annotations

import math
from typing import Any, Generator, List, Optional, TypeVar, Union

import zmq
from zmq.utils.monitor import parse_monitor_message

from . import meniscus_pb2 as pb
from .dialogue import EVENTS, TRY_S, Answer, Dialogue, Send, Wait, prepare_control
from .errors import UnavailableError
from .keys import Keys
from .process import OfOneProcess
from .values import Frame

T = TypeVar("T")


class Connection(OfOneProcess):
    """One DEALER socket. A monitor tells when it is connected, so a dead daemon is noticed without a time limit."""

    def __init__(self, endpoint: str, keys: Optional[Keys] = None, dialogue: Optional[Dialogue] = None) -> None:
        super().__init__()
        self.endpoint = endpoint
        self.keys = keys
        self._dialogue = dialogue or Dialogue(endpoint, keys)
        self.context = zmq.Context()
        self._socket = self.context.socket(zmq.DEALER)
        self._monitor = self._socket.get_monitor_socket(EVENTS)
        self._poller = zmq.Poller()
        self._poller.register(self._socket, zmq.POLLIN)
        self._poller.register(self._monitor, zmq.POLLIN)
        try:
            prepare_control(self._socket, endpoint, keys)
            self._socket.connect(endpoint)
            self.do(self._dialogue.connect())
        except BaseException:
            self.close()
            raise

    @property
    def epoch(self) -> int:
        """Of the daemon: another number after every start of it."""
        return self._dialogue.epoch

    def close(self, linger_ms: int = 0) -> None:
        """Disconnect. Commands that were accepted go on without us. In a forked process the sockets are the parent's."""
        if self._socket.closed or self.is_inherited:
            return
        self._socket.disable_monitor()
        self._monitor.close(0)
        self._socket.close(linger_ms)
        self.context.destroy(linger_ms)

    def call(
        self, request: pb.Request, timeout: Optional[float] = None, request_id: Optional[bytes] = None
    ) -> Answer:
        """Dialogue.call()."""
        self.check_process()
        if self._socket.closed:
            raise UnavailableError("UNAVAILABLE", "the client is closed; make a new one")
        return self.do(self._dialogue.call(request, timeout, request_id))

    def do(self, steps: Generator[Union[Send, Wait], bool, T]) -> T:
        """What the dialogue says is to be done, to its end."""
        self.check_process()
        try:
            step = next(steps)
            while True:
                step = steps.send(self._send(step.frame) if isinstance(step, Send) else self._wait(step.seconds))
        except StopIteration as end:
            result: T = end.value
            return result
        finally:
            steps.close()

    def _send(self, frame: bytes) -> bool:
        try:
            self._socket.send(frame, zmq.DONTWAIT)
            return True
        except zmq.Again:
            self._socket.poll(int(1000 * TRY_S), zmq.POLLOUT)
            return self._wait(0)

    def _wait(self, seconds: float) -> bool:
        """Messages go first: what is answered need not be asked again when the connection was lost right after."""
        ready: dict[Any, int] = dict(self._poller.poll(math.ceil(1000 * seconds)))
        while self._socket in ready and self._socket.poll(0):
            self._dialogue.deliver(_buffers(self._socket.recv_multipart(copy=False)))
        while self._monitor in ready and self._monitor.poll(0):
            self._dialogue.note(parse_monitor_message(self._monitor.recv_multipart())["event"])
        return False


def _buffers(frames: List[zmq.Frame]) -> List[Frame]:
    return [frame.buffer for frame in frames]

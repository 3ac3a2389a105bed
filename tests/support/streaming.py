# SPDX-License-Identifier: BSD-3-Clause
"""A client of streams that knows no more than the protocol: what comes is kept as it came, and every byte is counted."""

import secrets
import sys
import time
from typing import Any

import numpy as np
import zmq
from daemon import BUILD, DaemonTest

sys.path.insert(0, str(BUILD / "python"))
from meniscus import stream_pb2 as sb  # noqa: E402

PLENTY = 1 << 30  # bytes of credit, for who does not count them


def fields(*names: str, **exactness: Any) -> "sb.FieldStream":
    return sb.FieldStream(fields=[sb.FieldWish(name=name, **exactness) for name in names])


class Item:
    """One item, as far as it has come."""

    def __init__(self, first: "sb.StreamItem") -> None:
        self.head = first
        self.bytes = bytearray()
        self.last = first

    def take(self, item: "sb.StreamItem", data: bytes) -> None:
        assert item.offset == len(self.bytes), f"byte {len(self.bytes)} should come, {item.offset} came"
        self.bytes += data
        self.last = item

    @property
    def whole(self) -> bool:
        return len(self.bytes) == self.head.size

    def array(self, name: str) -> "np.ndarray[Any, Any]":
        """An array that is neither quantised nor compressed."""
        offset = 0
        for array in self.head.arrays:
            if array.name == name:
                assert array.codec == 0 and not array.shuffle and not array.HasField("quantisation"), array
                return np.frombuffer(bytes(self.bytes), array.type, count=array.raw_bytes // int(array.type[2:]), offset=offset).reshape(
                    list(array.shape)
                )
            offset += array.packed_bytes
        raise KeyError(name)


class Taker:
    """A connection to the data socket."""

    def __init__(self, endpoint: str, keys: "dict[str, str] | None" = None, ahead: int = 0) -> None:
        """keys: public-key, secret-key and server-key, for those from afar. ahead: messages that ZeroMQ takes before we do; 0: any number."""
        self.socket = zmq.Context.instance().socket(zmq.DEALER)
        if keys:
            self.socket.curve_publickey = keys["public-key"].encode()
            self.socket.curve_secretkey = keys["secret-key"].encode()
            self.socket.curve_serverkey = keys["server-key"].encode()
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.setsockopt(zmq.RCVHWM, ahead)
        self.socket.connect(endpoint)
        self.received = 0  # bytes of items, both frames
        self.under_way: dict[int, Item] = {}
        self.kept: list[list[bytes]] = []  # messages that quiet() has found

    def close(self) -> None:
        self.socket.close()

    def send(self, **command: Any) -> bytes:
        ident = secrets.token_bytes(16)
        self.socket.send(sb.StreamRequest(major=1, id=ident, **command).SerializeToString())
        return ident

    def receive(self, timeout: float = 20) -> "tuple[sb.StreamMessage, bytes]":
        frames, until = self.kept.pop(0) if self.kept else [b""], time.monotonic() + timeout
        while frames == [b""]:  # which only asks whether anybody is there
            if not self.socket.poll(int(1000 * max(until - time.monotonic(), 0))):
                raise TimeoutError("nothing came")
            frames = self.socket.recv_multipart()
        message = sb.StreamMessage.FromString(frames[0])
        if message.HasField("item") and not (message.item.HasField("cancelled") or message.item.HasField("ended")):
            self.received += sum(len(frame) for frame in frames)
        return message, frames[1] if len(frames) > 1 else b""

    def quiet(self, seconds: float) -> bool:
        """Does nothing come but heartbeats?"""
        until = time.monotonic() + seconds
        while self.socket.poll(int(1000 * max(until - time.monotonic(), 0))):
            if frames := [frame for frame in self.socket.recv_multipart() if frame]:
                self.kept.append(frames)
                return False
        return True

    def ask(self, **command: Any) -> "sb.StreamReply":
        """The reply; items that come before it are kept."""
        ident = self.send(**command)
        while True:
            message, data = self.receive()
            if message.HasField("reply"):
                assert message.reply.id == ident
                return message.reply
            self.take(message.item, data)

    def subscribe(self, **what: Any) -> "sb.StreamReply":
        reply = self.ask(subscribe=sb.Subscribe(**what))
        assert reply.code == 0, reply
        return reply

    def grant(self, stream: int, n: int) -> None:
        self.socket.send(sb.StreamRequest(major=1, credit=sb.Credit(stream=stream, bytes=n)).SerializeToString())

    def take(self, item: "sb.StreamItem", data: bytes) -> Item:
        kept = self.under_way.get(item.stream)
        if item.offset == 0 or kept is None:
            kept = self.under_way[item.stream] = Item(item)
        kept.take(item, data)
        return kept

    def item(self, timeout: float = 20) -> Item:
        """The next item that is whole."""
        until = time.monotonic() + timeout
        while True:
            message, data = self.receive(max(until - time.monotonic(), 0))
            if not message.HasField("item"):
                continue
            if message.item.HasField("cancelled") or message.item.HasField("ended"):
                return Item(message.item)
            item = self.take(message.item, data)
            if item.whole:
                return item


class StreamTest(DaemonTest):
    """Tests of one daemon's streams: each has a connection of its own, and may have more."""

    def setUp(self) -> None:
        self.endpoint = f"ipc://{self.home}/run/meniscus/default/data.ipc"
        self.taker = self.new_taker()

    def new_taker(self) -> Taker:
        taker = Taker(self.endpoint)
        self.addCleanup(taker.close)
        return taker

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A client written from proto/README.md alone, in 150 lines: it follows the series of probes, prints each row once, and notices when its connection is lost.

PYTHONPATH has the modules that the page says to compile for data.

    page_client.py DATA_ENDPOINT      lines: "row STEP VALUES...", "abandoned ROW", and "lost", "resumed", "subscribed" for its connection
"""

import secrets
import sys
import time
from typing import Any, Optional

import numpy as np
import stream_pb2 as pb
import zmq

SILENCE = 10  # seconds: "What a client notices"
CREDIT = 1 << 20


def say(*words: object) -> None:
    print(*words, flush=True)


class Lost(Exception):
    """Nothing has come for so long."""


class Series:
    def __init__(self, endpoint: str) -> None:
        self.endpoint = endpoint
        self.socket: Any = None
        self.stream = 0  # none
        self.sequence = 0  # of the item that came last; 0: none has
        self.offset = 0  # bytes of it that have come
        self.size = 0
        self.bytes = b""
        self.arrays: "list[Any]" = []
        self.next: "Optional[pb.Cursor]" = None  # behind what has been printed
        self.heard = 0.0

    def connect(self) -> None:
        if self.socket:
            self.socket.close(linger=0)
        self.socket = zmq.Context.instance().socket(zmq.DEALER)
        self.socket.linger = 0
        self.socket.connect(self.endpoint)
        self.heard = time.monotonic()

    def send(self, **command: Any) -> bytes:
        ident = secrets.token_bytes(16)
        self.socket.send(pb.StreamRequest(major=1, id=ident, **command).SerializeToString())
        return ident

    def receive(self) -> "tuple[pb.StreamMessage, bytes, int]":
        """The next message that says something, its bytes, and what both frames cost."""
        while True:
            left = self.heard + SILENCE - time.monotonic()
            if left <= 0 or not self.socket.poll(int(1000 * left) + 1):
                raise Lost
            frames = self.socket.recv_multipart()
            self.heard = time.monotonic()
            message = pb.StreamMessage.FromString(frames[0])
            if message.WhichOneof("what"):
                return message, frames[1] if len(frames) > 1 else b"", sum(map(len, frames))

    def ask(self, **command: Any) -> "pb.StreamReply":
        """Items of a stream that is not told of yet cannot come before this reply."""
        ident = self.send(**command)
        while True:
            message, _, _ = self.receive()
            if message.HasField("reply") and message.reply.id == ident:
                return message.reply

    def subscribe(self) -> None:
        wish = pb.Subscribe(probes=pb.ProbeStream(), delivery=pb.LOSSLESS, credit=CREDIT)
        if self.next:
            getattr(wish, "from").CopyFrom(self.next)
        reply = self.ask(subscribe=wish)
        while reply.code == 9:  # FAILED_PRECONDITION: there is no case, perhaps not yet again
            time.sleep(0.2)
            reply = self.ask(subscribe=wish)
        if reply.code:
            raise SystemExit(reply.message)
        self.stream, self.sequence, self.offset, self.size, self.bytes = reply.stream, 0, 0, 0, b""
        say("subscribed")

    def resume(self) -> bool:
        """False: what comes would not join on to what has come."""
        under_way = self.sequence > 0 and self.offset < self.size
        place = dict(sequence=self.sequence, offset=self.offset) if under_way else {}
        reply = self.ask(resume=pb.ResumeStream(stream=self.stream, credit=CREDIT, **place))
        joins = (self.sequence, self.offset) if under_way else (self.sequence + 1, 0)
        if reply.code or (reply.sequence, reply.offset) != joins:
            return False
        say("resumed")
        return True

    def attach(self) -> None:
        self.connect()
        if not self.stream or not self.resume():
            self.subscribe()

    def take(self, item: "pb.StreamItem", data: bytes, cost: int) -> None:
        if item.HasField("ended"):
            raise SystemExit("ended")
        if item.offset == 0:
            self.bytes, self.arrays = b"", list(item.arrays)
        self.bytes += data
        self.sequence, self.offset, self.size = item.sequence, item.offset + len(data), item.size
        if self.offset < self.size:
            self.send(credit=pb.Credit(stream=item.stream, bytes=cost))
            return
        if item.HasField("abandoned"):
            say("abandoned", item.abandoned.row)
        elif self.size:
            self.show()
        self.next = item.next  # with the last message of the item
        self.send(credit=pb.Credit(stream=item.stream, bytes=cost))

    def show(self) -> None:
        columns, at = {}, 0
        for array in self.arrays:
            part = self.bytes[at : at + array.packed_bytes]
            columns[array.name] = np.frombuffer(part, array.type).reshape(list(array.shape))
            at += array.packed_bytes
        for step, values in zip(columns["step"], columns["values"]):
            say("row", int(step), *values)

    def follow(self) -> None:
        while True:
            try:
                if not self.socket:
                    self.attach()
                message, data, cost = self.receive()
                if message.HasField("item") and message.item.stream == self.stream:
                    self.take(message.item, data, cost)
            except Lost:
                say("lost")
                self.socket.close(linger=0)
                self.socket = None


if __name__ == "__main__":
    Series(sys.argv[1]).follow()

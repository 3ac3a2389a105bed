# SPDX-License-Identifier: BSD-3-Clause
"""A stream without a socket: items put together from messages, credit, and going on after a lost connection.

As in dialogue.py, what is to be sent and waited for are steps of a generator, for transports that wait and those that do not.
"""

from __future__ import annotations

import os
import time
from collections import deque
from typing import Any, Deque, Dict, Generator, List, Optional, Tuple, Union

import numpy as np
import xxhash
from google.protobuf.message import DecodeError

from . import meniscus_pb2
from . import stream_pb2 as pb
from .dialogue import RECONNECT_S, Dialogue, Send, Wait
from .errors import CorruptError, MeniscusError, StateError, UnavailableError, error_for
from .keys import Keys
from .packing import checked_size, unpack
from .texts import check_text
from .values import Frame, code_of
from .wishes import Column, Cursor, StreamItem, StreamStats

MEMORY = 1 << 30  # bytes an item may have
MAX_REQUEST = 1 << 16  # bytes; a daemon takes no more for streams
CREDIT = 1 << 30  # bytes that may be open: more would not be counted
REPLY_S = 15.0  # the state is looked at between two steps
LAST_S = 0.2  # for the number of a stream that is ended before it is known
SMALL, LARGE, SPARE = 4096, 262144, 16384
HEADER = 512  # bytes of a message beside those of the item, at most, but for the first one
WINDOWS = {"probes": SMALL + SPARE, "fields": LARGE + SPARE, "events": SMALL + SPARE, "series": 1 << 20, "snapshots": 8 << 20}

AGAIN_S = 0.2
# Refusals of a stream that had begun after which it may be asked for again.
PASSING = (meniscus_pb2.UNAVAILABLE, meniscus_pb2.RESOURCE_EXHAUSTED, meniscus_pb2.FAILED_PRECONDITION)

Steps = Generator[Union[Send, Wait], bool, Any]


class Flow(Dialogue):
    """One stream, over a connection that may be lost and made anew."""

    def __init__(
        self, endpoint: str, keys: Optional[Keys], what: str, wish: pb.Subscribe, cursor: Optional[Cursor], memory: int
    ) -> None:
        super().__init__(endpoint, keys)
        self.columns: tuple[Column, ...] = ()
        self.stats = StreamStats()
        check_text("since", cursor.file if cursor else "")
        self.cursor = cursor  # behind what was handed out
        self._behind = cursor  # the same, or of what waits to be
        self._what = what
        self._wish = wish
        self._memory = memory
        self._window = WINDOWS[what]
        wish.chunk_bytes = SMALL if self._window < LARGE else LARGE
        self._lossless = wish.delivery == pb.LOSSLESS
        self._attached_to = 0  # connections there had been when the daemon was told of this one
        self._number = 0  # of the stream, at the daemon; 0: to be subscribed
        self._chunk = 1
        self._open = 0  # bytes that were granted, and have not come
        self._wanted = 0  # that should be open
        self._sequence: Optional[int] = None  # of the item that came last, and the first byte of it that did not come
        self._offset = 0
        self._done = False  # all of it was handed out
        self._first: Optional[pb.StreamItem] = None  # of the item that is under way
        self._bytes: Any = b""
        self._file: Optional[Dict[str, Any]] = None
        self._ready: Deque[Union[StreamItem, MeniscusError]] = deque()
        self._over: Optional[MeniscusError] = None
        self._began = False
        self._unwanted = False  # the item under way is to be cancelled
        self._asked: Optional[pb.StreamRequest] = None  # whose reply is waited for, however long whoever wants an item does
        self._asked_at = 0.0
        self._asked_over = 0  # the connection
        self._again = False  # it is asked for again
        self._reply: Optional[pb.StreamReply] = None
        self._useless: List[int] = []  # streams of which nothing can be used, to be ended

    # --- what is to be done ---------------------------------------------------------------------------------------------

    def _greet(self) -> Steps:
        while not (yield from self._attach(None)):
            self._check_gone()
            yield Wait(AGAIN_S)

    def next(self, timeout: Optional[float]) -> Steps:
        """The next item; None if none was whole within the timeout. Being asked for it tells that the one before is done with."""
        deadline = None if timeout is None else time.monotonic() + timeout
        if not self._ready:
            self._want(self._window)
        while True:
            yield Wait(0)
            if self._unwanted:
                self._unwanted = False
                yield from self.cancel()
            while self._useless and self._connected:
                yield from self._tell(pb.StreamRequest(unsubscribe=pb.Unsubscribe(stream=self._useless.pop())))
            if self._ready:
                return self._hand_out(self._ready.popleft())
            if self._over:
                raise self._over
            if self._connected and (self._asked or not self._number or self._attached_to != self._connections):
                try:
                    yield from self._attach(deadline)
                except StateError:  # a daemon that was started again has no case for a while
                    yield Wait(AGAIN_S)
            elif self._connected and self._open < self._wanted:
                yield from self._grant()
            if self._ready:
                continue
            self._check_gone()
            now = time.monotonic()
            if deadline is not None and now >= deadline:
                return None
            yield Wait(1 if deadline is None else max(0.001, min(1, deadline - now)))

    def cancel(self) -> Steps:
        """Give up the item under way; the next one follows."""
        if self._what == "series":
            text = "no row of a series can be left out; close the stream, and begin one at its cursor later"
            raise error_for("FAILED_PRECONDITION", text)
        if self._number:
            yield from self._tell(pb.StreamRequest(cancel=pb.CancelItem(stream=self._number)))

    def close(self) -> Steps:
        """Say that no more is wanted. Nobody waits for the answer, but for a moment for the number of what has just been asked for."""
        until = time.monotonic() + LAST_S
        while self._asked and not self._reply and self._connected and time.monotonic() < until:
            yield Wait(LAST_S / 4)
        if self._number and self._connected:
            request = pb.StreamRequest(unsubscribe=pb.Unsubscribe(stream=self._number))
            yield Send(self._sealed(request))

    def _hand_out(self, what: Union[StreamItem, MeniscusError]) -> StreamItem:
        if isinstance(what, MeniscusError):
            raise what
        self.cursor = what.cursor or self.cursor
        self.stats.items += not what.file or what.whole or what.abandoned
        self.stats.skipped += what.skipped
        return what

    def _sealed(self, request: pb.StreamRequest) -> bytes:
        request.major, request.id = meniscus_pb2.PROTOCOL_MAJOR, os.urandom(16)
        sealed: bytes = request.SerializeToString()
        if len(sealed) > MAX_REQUEST:
            text = f"the request has {len(sealed)} bytes, a daemon takes {MAX_REQUEST}; ask for fewer fields or probes, or by several streams"
            raise MeniscusError("RESOURCE_EXHAUSTED", text)
        return sealed

    def _tell(self, request: pb.StreamRequest) -> Steps:
        yield from self._send(self._sealed(request))

    def _check_gone(self) -> None:
        now = time.monotonic()
        if not self._connected and now > self._lost_since + RECONNECT_S:
            self._lost_since = now  # whoever asks again waits again
            raise self._gone()

    def _want(self, credit: int) -> None:
        self._wanted = max(self._wanted, min(credit, CREDIT))

    def _grant(self) -> Steps:
        more = self._wanted - self._open
        self._open, self._wanted = self._wanted, 0
        yield from self._tell(pb.StreamRequest(credit=pb.Credit(stream=self._number, bytes=more)))

    def _ask(self, request: pb.StreamRequest) -> None:
        self._asked, self._reply, self._asked_at, self._asked_over = request, None, time.monotonic(), 0

    def _answer(self, until: Optional[float]) -> Generator[Union[Send, Wait], bool, Optional[pb.StreamReply]]:
        """To what was asked, which is sent again over each new connection: a reply, which may be a refusal. None: there was none until
        then, or the connection is lost; it is waited for the next time."""
        while self._asked and not self._reply and self._connected:
            if self._asked_over != self._connections:
                packed = self._sealed(self._asked)
                self._asked_over = self._attached_to = yield from self._send(packed)
            now = time.monotonic()
            if now > self._asked_at + REPLY_S:
                self._asked = None
                raise UnavailableError("UNAVAILABLE", f"{self.endpoint} is open, but nobody answers there")
            if until is not None and now >= until:
                return None
            yield Wait(max(0.001, min(1, (until or now + 1) - now)))
            self._check_denied()
        reply, self._reply = self._reply, None
        if reply:
            self._asked = None
        return reply

    def _attach(self, until: Optional[float]) -> Generator[Union[Send, Wait], bool, bool]:
        """Tell the daemon of this one, by its number if it has one. False: there is no answer yet."""
        if not self._asked:
            self._again, self._began = self._began, True
            self._ask(self._resume() if self._number else self._subscribe())
        resumes = self._asked and self._asked.HasField("resume")
        reply = yield from self._answer(until)
        if reply and resumes and code_of(reply) != "OK":
            self._ask(self._subscribe())
            reply = yield from self._answer(until)
        if not reply:
            return False
        if code_of(reply) != "OK":
            error = error_for(code_of(reply), reply.message, reply.path, reply.reason)
            if self._again and reply.code not in PASSING:
                self._over = error
            raise error
        self.stats.reconnects += self._again
        return True

    def _resume(self) -> pb.StreamRequest:
        rest = len(self._bytes) - self._offset if self._first else 0
        credit = min(self._window + rest + rest // self._chunk * HEADER, CREDIT)
        resume = pb.ResumeStream(stream=self._number, credit=credit)
        if self._sequence is not None:
            resume.sequence, resume.offset = self._sequence, self._offset
        return pb.StreamRequest(resume=resume)

    def _resumed(self, reply: pb.StreamReply, request: pb.StreamRequest) -> None:
        if (reply.sequence, reply.offset) != (self._sequence, self._offset):
            self._first = None
        self._open = request.resume.credit

    def _subscribe(self) -> pb.StreamRequest:
        self._start_over()
        place = self._place()
        if place:
            getattr(self._wish, "from").CopyFrom(place)
        self._wish.credit = self._window
        return pb.StreamRequest(subscribe=self._wish)

    def _subscribed(self, reply: pb.StreamReply) -> None:
        self._number, self._chunk = reply.stream, reply.chunk_bytes or 1
        self.epoch = reply.daemon_epoch
        self._open = self._window
        self.columns = tuple(Column(c.name, c.unit, c.type, c.components or 1) for c in reply.columns)

    def _place(self) -> Optional[pb.Cursor]:
        """Within a file, if the line of the cursor is that of this file; else bytes that came before are passed over when they come again."""
        cursor = self._behind
        if not self._lossless or not cursor:
            return None
        if self._what == "series":
            return pb.Cursor(line=cursor.line, row=cursor.row)
        if self._file and self._file["name"] == cursor.file:
            return pb.Cursor(line=cursor.line, file=self._file["name"], offset=self._file["got"])
        return pb.Cursor(line=cursor.line, file=cursor.file, offset=cursor.offset)

    # --- what came ------------------------------------------------------------------------------------------------------

    def deliver(self, frames: List[Frame]) -> None:
        try:
            message = pb.StreamMessage.FromString(bytes(frames[0]))
            if message.HasField("reply"):
                self._take_reply(message.reply)
            elif message.item.stream == self._number and self._number:
                self._open -= sum(map(len, frames))
                self._take(message.item, frames[1:])
        except DecodeError:
            self._distrust(CorruptError("DATA_LOSS", "a message of a stream cannot be read"))
        except CorruptError as error:
            self._distrust(error)
        except (MeniscusError, ImportError) as error:
            self._fail(error if isinstance(error, MeniscusError) else MeniscusError("UNIMPLEMENTED", str(error)))

    def _take_reply(self, reply: pb.StreamReply) -> None:
        """Items may be right behind it, so what it says holds at once."""
        if self._asked and reply.id == self._asked.id:
            self._reply = reply
            if code_of(reply) == "OK" and self._asked.HasField("resume"):
                self._resumed(reply, self._asked)
            elif code_of(reply) == "OK":
                self._subscribed(reply)
        elif reply.code == meniscus_pb2.NOT_FOUND and not self._asked:
            self._start_over()  # forgotten, as nothing was taken for long

    def _start_over(self) -> None:
        self._number, self._sequence, self._first, self._done = 0, None, None, False

    def _end_at_daemon(self) -> None:
        if self._number:
            self._useless.append(self._number)

    def _distrust(self, error: MeniscusError) -> None:
        """What comes of this stream cannot be used: end it, and begin anew behind what was whole."""
        self._end_at_daemon()
        self._start_over()
        self._ready.append(error)

    def _fail(self, error: MeniscusError) -> None:
        if self._lossless:
            self._over = error
            self._end_at_daemon()
            self._start_over()
        self._first, self._unwanted = None, not self._lossless
        self._ready.append(error)

    def _take(self, item: pb.StreamItem, frames: List[Frame]) -> None:
        same = item.sequence == self._sequence
        if item.HasField("ended"):
            self._end(item.ended)
        elif item.HasField("cancelled"):
            self._first = self._file = None
            self.stats.cancelled += 1
            self._behind = _cursor(item) or self._behind
            why = item.cancelled
            if self._lossless and why.reason != "cancelled":  # which leaves a gap
                self._ready.append(error_for(code_of(why), why.message, "", why.reason))
        elif self._sequence is None or item.sequence > self._sequence or (same and not self._done):
            if not same:
                self._offset = 0
            self._sequence, self._done = item.sequence, False
            data = memoryview(frames[0]) if frames else memoryview(b"")
            if self._what == "snapshots" and not item.HasField("abandoned"):
                self._take_file(item, data)
            else:
                self._take_piece(item, data)
        if not self._ready and not self._first:  # it used credit, and made no item
            self._want(self._window)

    def _end(self, end: pb.StreamEnd) -> None:
        self._start_over()
        if end.code not in (meniscus_pb2.UNAVAILABLE, meniscus_pb2.RESOURCE_EXHAUSTED):  # it leaves, or we were slow
            self._over = error_for(code_of(end), end.message, "", end.reason)

    def _take_piece(self, item: pb.StreamItem, data: memoryview) -> None:
        if not item.offset:
            self._check_arrays(item)
            self._first, self._offset = item, 0
            single = len(data) == item.size  # in the memory it was received in
            self._bytes = data if single else np.empty(item.size, np.uint8).data
        elif not self._first or self._first.sequence != item.sequence:
            return  # of an item that was given up
        if item.offset != self._offset or item.size != self._first.size or len(data) > item.size - item.offset:
            raise CorruptError("DATA_LOSS", "an item of the stream came damaged: its bytes do not follow one another")
        if self._bytes is not data:
            self._bytes[self._offset : self._offset + len(data)] = data
        self._offset += len(data)
        rest = item.size - self._offset
        if rest:
            self._want(rest + (rest // self._chunk + 1) * HEADER)
            return
        first, self._first, self._done = self._first, None, True
        self._ready.append(self._whole(first, _cursor(item)))
        self._behind = _cursor(item) or self._behind

    def _check_arrays(self, item: pb.StreamItem) -> None:
        left = self._memory
        for array in item.arrays:
            left -= checked_size(array, left)
        if sum(array.packed_bytes for array in item.arrays) != item.size:
            raise CorruptError("DATA_LOSS", "an item of the stream came damaged: its arrays do not have its bytes")

    def _whole(self, first: pb.StreamItem, cursor: Optional[Cursor]) -> StreamItem:
        arrays: Dict[str, np.ndarray] = {}
        at = 0
        for array in first.arrays:
            arrays[array.name] = unpack(array, self._bytes[at : at + array.packed_bytes], self._memory)
            at += array.packed_bytes
            self.stats.raw_bytes += array.raw_bytes
        self.stats.packed_bytes += at
        more: Dict[str, Any] = {}
        if first.HasField("event"):
            event = first.event
            more = {"state": meniscus_pb2.State.Name(event.state), "what": event.what, "text": event.text}
        if first.HasField("abandoned"):
            more = {"abandoned": True, "row": first.abandoned.row, "file": first.abandoned.file or None}
            self._file = None  # which may come again, as another
        return StreamItem(*_common(first), arrays=arrays, columns=self.columns, cursor=cursor, **more)

    def _take_file(self, item: pb.StreamItem, data: memoryview) -> None:
        """A piece of a file. What comes a second time was handed out already."""
        if item.HasField("file"):
            name = item.file.name
            if not name or name.startswith(".") or "/" in name:
                raise CorruptError("DATA_LOSS", "a file of the stream has a name that it cannot have")
            file = self._file
            if not file or file["name"] != name or file["size"] != item.size or item.offset > file["got"]:
                self._file = {"name": name, "size": item.size, "got": item.offset, "sum": None if item.offset else xxhash.xxh64()}
        file = self._file
        if not file or item.offset > file["got"] or item.size != file["size"] or len(data) > item.size - item.offset:
            raise CorruptError("DATA_LOSS", "an item of the stream came damaged: the bytes of a file do not follow one another")
        before = file["got"]
        fresh = data[before - item.offset :]
        if file["sum"]:
            file["sum"].update(fresh)
        file["got"] += len(fresh)
        self._offset = item.offset + len(data)
        whole = self._offset == item.size
        if whole:
            self._file, self._done = None, True
            if file["sum"] and item.HasField("xxh64") and file["sum"].intdigest() != item.xxh64:
                raise CorruptError("DATA_LOSS", f"{file['name']} came damaged: its checksum does not match")
            self._behind = _cursor(item) or self._behind
        if len(fresh) or whole:
            self.stats.packed_bytes += len(fresh)
            self.stats.raw_bytes += len(fresh)
            self._ready.append(
                StreamItem(*_common(item), file=file["name"], file_size=item.size, offset=before, data=fresh, whole=whole,
                           cursor=_cursor(item))
            )


def _common(item: pb.StreamItem) -> tuple[int, int, int, int, float]:
    return item.sequence, item.skipped, item.daemon_epoch, item.step, item.time


def _cursor(item: pb.StreamItem) -> Optional[Cursor]:
    if not item.HasField("next"):
        return None
    return Cursor(item.next.line, item.next.row, item.next.file, item.next.offset)


class StreamFacts:
    """What streams tell of themselves, with asyncio and without."""

    _flow: Flow

    @property
    def columns(self) -> Tuple[Column, ...]:
        """Of the items: name, unit, type, components."""
        return self._flow.columns

    @property
    def stats(self) -> StreamStats:
        """What became of it so far."""
        return self._flow.stats

    @property
    def cursor(self) -> Optional[Cursor]:
        """Of a series or of snapshots: behind the last item that was taken."""
        return self._flow.cursor

# SPDX-License-Identifier: BSD-3-Clause
"""Streams of data as iterators that wait; asynchronous.py has those that do not."""

from __future__ import annotations

from types import TracebackType
from typing import Iterator, Optional, Type

from .connection import Connection
from .endpoint import data_endpoint
from .errors import MeniscusError
from .flow import Flow, StreamFacts
from .keys import Keys
from .stream_pb2 import Subscribe
from .wishes import Cursor, StreamItem

LINGER_MS = 200  # for the last word


class Stream(StreamFacts):
    """Items as they come, at the pace of who takes them; made by Client.stream(). Usable as a context manager."""

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
        self._connection: Optional[Connection] = Connection(self._flow.endpoint, keys, self._flow)

    def next(self, timeout: Optional[float] = None) -> Optional[StreamItem]:
        """The next item; None if there was none within so many seconds."""
        if not self._connection:
            raise RuntimeError("the stream is closed")
        item: Optional[StreamItem] = self._connection.do(self._flow.next(timeout))
        return item

    def cancel(self) -> None:
        """Give up the item under way; the next one follows. Not of a series."""
        if self._connection:
            self._connection.do(self._flow.cancel())

    def close(self) -> None:
        """Take no more."""
        connection, self._connection = self._connection, None
        if connection:
            try:
                connection.do(self._flow.close())
            except MeniscusError:
                pass  # nobody is there to be told
            connection.close(LINGER_MS)

    def __iter__(self) -> Iterator[StreamItem]:
        while self._connection:
            item = self.next(self._timeout)
            if item is None:
                return
            yield item

    def __enter__(self) -> Stream:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

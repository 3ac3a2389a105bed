# SPDX-License-Identifier: BSD-3-Clause
"""What a browser says to the dashboard's gateway and hears from it, without a browser."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import socket
import struct
import time
from typing import Any, Optional

PATIENCE_S = 20
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


class Browser:
    """As much of a WebSocket as a test needs; nothing is hidden, so that it can misbehave."""

    def __init__(self, port: int, host: Optional[str] = None, origin: Optional[str] = "same", receive: int = 0) -> None:
        host = host or f"127.0.0.1:{port}"
        self.socket = socket.socket()
        if receive:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive)
        self.socket.settimeout(20)
        self.socket.connect(("127.0.0.1", port))
        lines = [
            "GET / HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
            f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}", "Sec-WebSocket-Protocol: meniscus-dashboard",
        ]
        if origin:
            lines.append(f"Origin: {'http://' + host if origin == 'same' else origin}")
        self.socket.sendall("\r\n".join([*lines, "", ""]).encode())
        self.bytes = b""
        while b"\r\n\r\n" not in self.bytes:
            piece = self.socket.recv(4096)
            if not piece:
                break
            self.bytes += piece
        head, _, self.bytes = self.bytes.partition(b"\r\n\r\n")
        self.status = int(head.split()[1]) if head else 0

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def frame(self, data: bytes, kind: int = TEXT, last: bool = True) -> None:
        mask, n = os.urandom(4), len(data)
        size = bytes([n]) if n < 126 else b"\x7e" + struct.pack(">H", n) if n < 65536 else b"\x7f" + struct.pack(">Q", n)
        size = bytes([size[0] | 128]) + size[1:]
        self.socket.sendall(bytes([(128 if last else 0) | kind]) + size + mask + bytes(c ^ mask[k % 4] for k, c in enumerate(data)))

    def say(self, **message: Any) -> None:
        self.frame(json.dumps(message).encode())

    def _take(self, n: int) -> bytes:
        while len(self.bytes) < n:
            piece = self.socket.recv(65536)
            if not piece:
                raise EOFError
            self.bytes += piece
        taken, self.bytes = self.bytes[:n], self.bytes[n:]
        return taken

    def hear(self) -> "tuple[int, bytes]":
        kind, size = self._take(2)
        n = size & 127
        if n == 126:
            (n,) = struct.unpack(">H", self._take(2))
        elif n == 127:
            (n,) = struct.unpack(">Q", self._take(8))
        data = self._take(n)
        if kind & 15 == PING:
            self.frame(data, PONG)
            return self.hear()
        return kind & 15, data

    def until(self, topic: str, **having: Any) -> "dict[str, Any]":
        """The next message of a topic, with these entries."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            kind, data = self.hear()
            if kind == CLOSE:
                raise EOFError(data)
            if kind != TEXT:
                continue
            message = json.loads(data)
            if message["topic"] == topic and having.items() <= message.items():
                return message
        raise TimeoutError(f"no {topic} with {having}")

    def until_all(self, *topics: str) -> "dict[str, Any]":
        """Until there is one of each topic, the latest of each."""
        found: "dict[str, Any]" = {}
        while len(found) < len(topics):
            kind, data = self.hear()
            message = json.loads(data) if kind == TEXT else {"topic": ""}
            if message["topic"] in topics:
                found[message["topic"]] = message
        return found

    def history(self) -> "dict[str, Any]":
        """All of the history that comes next, by the names of its probes."""
        piece = self.until("history", first=True)
        probes = piece["probes"]
        while not piece["last"]:
            piece = self.until("history")
            probes += piece["probes"]
        return {probe["name"]: probe for probe in probes}

    def picture(self) -> "dict[str, Any]":
        """The header of the next picture; drawn() says that there may be another."""
        kind, data, end = 0, b"", time.monotonic() + PATIENCE_S
        while kind != BINARY and time.monotonic() < end:
            kind, data = self.hear()
        assert kind == BINARY, "no picture"
        size, skipped = struct.unpack_from("<II", data)
        header = json.loads(data[8 : 8 + size])
        n, width = header["particles"], header["dimensions"] * 4 + 1 + (4 if header["field"] != "phase" else 0)
        assert len(data) == 8 + size + n * width, (len(data), header)
        return header | {"skipped": skipped}

    def ask(self, **message: Any) -> "dict[str, Any]":
        self.say(**message)
        return self.until("reply", id=message["id"])

    def closed(self) -> "tuple[int, bytes]":
        """Code and reason with which the other side closes."""
        end = time.monotonic() + PATIENCE_S
        with contextlib.suppress(EOFError, ConnectionError):
            while time.monotonic() < end:
                kind, data = self.hear()
                if kind == CLOSE:
                    return (struct.unpack(">H", data[:2])[0], data[2:]) if data else (1005, b"")
            return 0, b"still open"
        return 1006, b""

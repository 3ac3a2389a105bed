# SPDX-License-Identifier: BSD-3-Clause
"""Keys for daemons off this machine: the rules are those of <meniscus/client.h>."""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass, field
from typing import Optional

import zmq

from .endpoint import near_number
from .errors import DeniedError, MeniscusError, RefusedError, StateError
from .texts import check_path, check_word

_KEY = re.compile(r"[0-9a-zA-Z.:+=^!/*?&<>()\[\]{}@%$#-]{40}")


@dataclass(frozen=True)
class Keys:
    """Our pair and the daemon's public key."""

    public: str
    secret: str = field(repr=False)
    server: str

    def secure(self, socket: zmq.Socket) -> None:
        """Have a socket that is not connected yet use them."""
        socket.setsockopt_string(zmq.CURVE_SERVERKEY, self.server)
        socket.setsockopt_string(zmq.CURVE_PUBLICKEY, self.public)
        socket.setsockopt_string(zmq.CURVE_SECRETKEY, self.secret)


def is_far(endpoint: str) -> bool:
    """May others read what goes there? Then it takes a key. Of what control_endpoint() has made: there, this machine is a number."""
    tcp = re.fullmatch(r"tcp://(.+):[0-9]+", endpoint)
    return not endpoint.startswith("ipc://") and not (tcp and near_number(tcp[1]))


def choose_keys(endpoint: str, file: Optional[str] = None, server: Optional[str] = None) -> Optional[Keys]:
    """The keys to use at an endpoint: of a file, or $MENISCUS_KEY; server: instead of that in the file, or $MENISCUS_SERVER_KEY.

    None: plain text, as at sockets of this machine.
    """
    file = file or os.environ.get("MENISCUS_KEY")
    server = server or os.environ.get("MENISCUS_SERVER_KEY")
    check_path("key", file or "")
    check_word("server_key", server or "")
    if endpoint.startswith("ipc://") or (not file and not is_far(endpoint)):
        return None
    if not file:
        raise DeniedError(
            "PERMISSION_DENIED",
            f"{endpoint} is no loopback address, so it takes a key: Client(key=FILE) or MENISCUS_KEY; `meniscus keys new` writes the "
            "file on the daemon's machine; on that machine a daemon has a name, or listens at tcp://127.0.0.1:PORT",
        )
    words = _read(file)
    server = server or words.get("server-key")
    if not server or not _KEY.fullmatch(server):
        raise RefusedError("INVALID_ARGUMENT", f'"{server or ""}" is no public key of a daemon, as `meniscus keys list` prints it')
    if not {"public-key", "secret-key"} <= set(words):
        raise RefusedError("INVALID_ARGUMENT", f"{file} lacks its public-key or its secret-key")
    return Keys(words["public-key"], words["secret-key"], server)


def _at_once(file: str, flags: int) -> int:
    """A pipe holds nothing up."""
    return os.open(file, flags | os.O_NONBLOCK | os.O_NOCTTY)


def _read(file: str) -> dict[str, str]:
    try:
        with open(file, encoding="ascii", errors="replace", opener=_at_once) as stream:
            info = os.fstat(stream.fileno())
            if not stat.S_ISREG(info.st_mode):
                raise StateError("FAILED_PRECONDITION", f"{file} is no file; keys are not read from it")
            if info.st_uid != os.geteuid() or stat.S_IMODE(info.st_mode) & 0o077:
                raise StateError("FAILED_PRECONDITION", f"others have access to {file}: take it from them with `chmod 600 {file}`")
            lines = [line.split() for line in stream if line.strip() and not line.startswith("#")]
    except FileNotFoundError:
        raise RefusedError("NOT_FOUND", f"there is no file of a key {file}") from None
    except OSError as error:
        raise MeniscusError("INTERNAL", f"cannot read {file}: {error.strerror}; check the path, and that the file is yours", reason="input/output error") from None
    for line in lines:
        if len(line) != 2 or not _KEY.fullmatch(line[1]):
            raise RefusedError("INVALID_ARGUMENT", f"{file}: a line is public-key, secret-key or server-key, and 40 letters of Z85")
    return {name: key for name, key in lines}

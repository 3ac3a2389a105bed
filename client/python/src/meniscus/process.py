# SPDX-License-Identifier: BSD-3-Clause
"""Connections belong to the process that made them: ZeroMQ's threads do not survive fork(), and sockets cannot be pickled."""

from __future__ import annotations

import os
import resource
from typing import NoReturn

from .errors import MeniscusError, UnavailableError

OPEN_FILES = 16  # that a connection takes, as OPEN_FILES_CLIENT of common/host/open_files.h


def check_open_files() -> None:
    """ZeroMQ ends the process where it cannot have the files for its sockets, so the connection is refused before."""
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    free = 0
    for number in range(most if most != resource.RLIM_INFINITY else 1 << 20):
        try:
            os.fstat(number)
        except OSError:
            free += 1
        if free == OPEN_FILES:
            return
    text = f"a connection takes {OPEN_FILES} open files, and of the {most} that this process may have, {free} {'is' if free == 1 else 'are'} left; raise the limit (`ulimit -n`), or close some"
    raise MeniscusError("RESOURCE_EXHAUSTED", text)


class OfOneProcess:
    """The base of connections. A forked process that used one would wait for ever, and so gets an exception."""

    endpoint: str

    def __init__(self) -> None:
        check_open_files()
        self._process = os.getpid()

    @property
    def is_inherited(self) -> bool:
        """Whether this process was forked from the one that made the connection."""
        return self._process != os.getpid()

    def check_process(self) -> None:
        """UnavailableError if it is inherited."""
        if self.is_inherited:
            text = f"process {self._process} made this connection to {self.endpoint}, and a forked process such as {os.getpid()} cannot use it"
            raise UnavailableError("UNAVAILABLE", text, hint="make a client in this process; that of the parent goes on")

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"a connection to {self.endpoint} cannot be pickled: make a client in each process")

# SPDX-License-Identifier: BSD-3-Clause
"""Connections belong to the process that made them: ZeroMQ's threads do not survive fork(), and sockets cannot be pickled."""

from __future__ import annotations

import os
from typing import NoReturn

from .errors import UnavailableError


class OfOneProcess:
    """The base of connections. A forked process that used one would wait for ever, and so gets an exception."""

    endpoint: str

    def __init__(self) -> None:
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

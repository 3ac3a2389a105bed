# SPDX-License-Identifier: BSD-3-Clause
"""What can go wrong, as exceptions with a code, a sentence and the entry to blame."""

from __future__ import annotations

from typing import Type


class MeniscusError(Exception):
    """A command failed.

    code     of the protocol, as in "FAILED_PRECONDITION"
    message  what was found, what is allowed, what to do
    path     the entry to blame, as in "fluids[1].density"; empty if there is none
    """

    def __init__(self, code: str, message: str, path: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.path = path


class CaseError(MeniscusError):
    """The case is wrong. The message begins with FILE:LINE:COLUMN where the entry comes from a file."""


class RefusedError(MeniscusError):
    """An input is malformed or out of bounds, or something of that name does not exist."""


class StateError(MeniscusError):
    """Not possible in the present state."""


class UnavailableError(MeniscusError):
    """Nobody answers, or the daemon was restarted meanwhile."""


class TimedOutError(MeniscusError):
    """Not done within the time limit."""


class CancelledError(MeniscusError):
    """Another client ended the command."""


class DivergedError(MeniscusError):
    """The simulation has diverged; it can be inspected and restored."""


class CorruptError(MeniscusError):
    """An array came damaged, or a file is."""


_BY_CODE: dict[str, Type[MeniscusError]] = {
    "INVALID_ARGUMENT": RefusedError,
    "OUT_OF_RANGE": RefusedError,
    "NOT_FOUND": RefusedError,
    "FAILED_PRECONDITION": StateError,
    "ALREADY_EXISTS": StateError,
    "UNAVAILABLE": UnavailableError,
    "DEADLINE_EXCEEDED": TimedOutError,
    "ABORTED": CancelledError,
    "DATA_LOSS": CorruptError,
}


def error_for(code: str, message: str, path: str = "", reason: str = "") -> MeniscusError:
    """The exception that stands for a code of the protocol, or for its reason where that is more exact."""
    if reason == "diverged":
        return DivergedError(code, message, path)
    return _BY_CODE.get(code, MeniscusError)(code, message, path)

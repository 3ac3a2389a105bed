# SPDX-License-Identifier: BSD-3-Clause
"""What can go wrong, as exceptions with a code, a sentence and the entry to blame."""

from __future__ import annotations

import copyreg
import sys
from typing import Any, Optional, Sequence, Tuple, Type

from .escapes import shown

# What the reply calls its reason, by code, for failures that have none as they did not come from a daemon.
_STATUS: dict[str, str] = {
    "INVALID_ARGUMENT": "invalid",
    "OUT_OF_RANGE": "invalid",
    "NOT_FOUND": "not found",
    "FAILED_PRECONDITION": "wrong state",
    "ALREADY_EXISTS": "wrong state",
    "RESOURCE_EXHAUSTED": "limit reached",
    "ABORTED": "interrupted",
    "DEADLINE_EXCEEDED": "timed out",
    "UNIMPLEMENTED": "wrong version",
    "UNAVAILABLE": "unavailable",
    "DATA_LOSS": "corrupt",
    "PERMISSION_DENIED": "denied",
    "UNAUTHENTICATED": "denied",
}

_HINTS: dict[str, str] = {
    "invalid": "mend what the message names and try again",
    "not found": "check the name; the message says what there is, and capabilities() of fields, probes and parameters",
    "wrong state": "see status().state, and wait() for a state in which it is possible",
    "limit reached": "ask for less, or raise the limit if the message names an entry for it",
    "out of memory": "compute with fewer particles, or on a machine with more memory",
    "diverged": "look at the last snapshot, then restore() a checkpoint, or load() the case with what the message advises",
    "input/output error": "see to the file or directory that the message names, then try again",
    "no space": "make room, or where a file is too large raise the limit on the size of files (`ulimit -f`); then resume()",
    "corrupt": "try again; of checkpoints, restore() without a name finds the newest whole one",
    "wrong version": "use programs of the same version",
    "unavailable": "see which daemons there are with `meniscus ls`, or start one with `meniscusd`",
    "timed out": "allow more time, or see with status() how far it is",
    "interrupted": "another client ended the command: give it again if it is still wanted",
    "held": "wait until it is given back, or only watch; pause(), stop() and shutdown() need no lease",
    "expired": "see status().lease_holder for who holds it now, and take a new one with lease()",
    "denied": "ask whoever keeps the daemon's keys: `meniscus keys` makes one of the role that is needed",
    "internal error": "please report this with the daemon's log",
}


class MeniscusError(Exception):
    """A command failed.

    code     of the protocol, as in "FAILED_PRECONDITION"
    status   what is wrong in a word or two, finer than the code, as in "wrong state", "diverged" or "no space": the words
             that `meniscus -o json` prints
    message  what was found, what is allowed, what to do
    path     the entry to blame, as in "fluids[1].density"; empty if there is none
    hint     what to do about failures of that status; tracebacks show it below the message
    allowed  names of the states in which the command is possible, where its state was wrong
    """

    def __init__(
        self, code: str, message: str, path: str = "", reason: str = "", allowed: Sequence[str] = (), hint: Optional[str] = None
    ) -> None:
        message = shown(message)
        super().__init__(message)
        self.code = code
        self.message = message
        self.path = path
        self.status = reason or _STATUS.get(code, "internal error")
        self.hint = _HINTS.get(self.status, "") if hint is None else hint
        self.allowed: Tuple[str, ...] = tuple(allowed)
        if self.hint and sys.version_info >= (3, 11):
            self.add_note(f"hint: {self.hint}")

    def __reduce__(self) -> Tuple[Any, ...]:
        """Without __init__(), which takes more than the sentence: a process pool must be able to send the exception back."""
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__  # type: ignore[attr-defined]


class CaseError(MeniscusError):
    """The case is wrong. The message begins with FILE:LINE:COLUMN where the entry comes from a file."""


class RefusedError(MeniscusError):
    """An input is malformed or out of bounds, or something of that name does not exist."""


class StateError(MeniscusError):
    """Not possible in the present state."""


class DeniedError(MeniscusError):
    """The key lacks the role that this takes, or is not let in (any more)."""


class UnavailableError(MeniscusError):
    """Nobody answers, also not within five seconds of a lost connection."""


class TimedOutError(MeniscusError):
    """Not done within the time limit."""


class CancelledError(MeniscusError):
    """Another client ended the command."""


class LeaseError(MeniscusError):
    """Somebody else holds the lease, or that of this client is over."""


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
    "PERMISSION_DENIED": DeniedError,
    "UNAUTHENTICATED": DeniedError,
    "UNAVAILABLE": UnavailableError,
    "DEADLINE_EXCEEDED": TimedOutError,
    "ABORTED": CancelledError,
    "DATA_LOSS": CorruptError,
}


def error_for(
    code: str, message: str, path: str = "", reason: str = "", allowed: Sequence[str] = ()
) -> MeniscusError:
    """The exception that stands for a code of the protocol, or for its reason where that is more exact."""
    if reason == "diverged":
        return DivergedError(code, message, path, reason, allowed)
    if reason in ("held", "expired"):
        return LeaseError(code, message, path, reason, allowed)
    return _BY_CODE.get(code, MeniscusError)(code, message, path, reason, allowed)

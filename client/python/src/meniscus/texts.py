# SPDX-License-Identifier: BSD-3-Clause
"""The one check of texts that callers give: what no message and no path can hold is refused by the name of the argument."""

from __future__ import annotations

import functools
import inspect
import os
from typing import TYPE_CHECKING, Any, Callable, Mapping, TypeVar

from .errors import RefusedError

if TYPE_CHECKING:
    from typing_extensions import ParamSpec

    P = ParamSpec("P")

T = TypeVar("T")


def _refuse(name: str, text: str) -> RefusedError:
    return RefusedError("INVALID_ARGUMENT", text, name)


def whole_pairs(text: str) -> str:
    """Both halves of a surrogate pair, as other programs write them, are a character."""
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "surrogatepass")


def check_text(name: str, text: str) -> None:
    """RefusedError, whose path is the name of the argument, for a text with half of a surrogate pair, which no message can hold."""
    try:
        text.encode()
    except UnicodeEncodeError as error:
        where = f"{ascii(text):.60} of {name} at character {error.start}"
        raise _refuse(name, f"half of a surrogate pair is no character, as in {where}: write the character itself") from None


def check_path(name: str, path: Any) -> None:
    """The same for a path, whose bytes may be any but zero: Python writes those that are no text as half of a pair."""
    encoded = b""
    try:
        encoded = os.fsencode(path)
    except UnicodeEncodeError:
        check_text(name, str(path))
    if b"\0" in encoded:
        raise _refuse(name, f"{name} has a zero byte (U+0000) in it: remove it")


def check_word(name: str, text: str) -> None:
    """The same for a text that becomes part of a path or an address."""
    check_text(name, text)
    check_path(name, text)


def _check(name: str, value: Any, values: bool = True) -> None:
    """values: also those of mappings, in which both halves of a pair are a character."""
    if isinstance(value, str):
        check_text(name, value)
    elif isinstance(value, Mapping):
        for key, entry in value.items():
            _check(name, key)
            if values:
                _check(name, whole_pairs(entry) if isinstance(entry, str) else entry)
    elif isinstance(value, (list, tuple)):
        for entry in value:
            _check(name, entry)


def texts_only(build: Callable[P, T]) -> Callable[P, T]:
    """A function that refuses such texts, in lists and mappings too, by the argument they are in. Of a case, what has lines is left to its reader, which
    names the line."""
    signature = inspect.signature(build)

    @functools.wraps(build)
    def checked(*args: P.args, **words: P.kwargs) -> T:
        for name, value in signature.bind(*args, **words).arguments.items():
            if name == "case":
                if isinstance(value, (str, os.PathLike)):
                    check_path(name, value)
            else:
                _check(name, value, name != "overrides")
        return build(*args, **words)

    return checked

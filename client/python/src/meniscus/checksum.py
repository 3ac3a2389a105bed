# SPDX-License-Identifier: BSD-3-Clause
"""xxh64 of arrays, by the package xxhash if there is one, else by the library that the daemon uses too."""

from __future__ import annotations

import ctypes
import ctypes.util
from typing import Any, Callable, Union

import numpy as np


def _load() -> Callable[[Union[bytes, memoryview]], int]:
    try:
        import xxhash

        return lambda data: int(xxhash.xxh64_intdigest(data))
    except ImportError:
        name = ctypes.util.find_library("xxhash")
        if not name:
            raise ImportError("install the Python package xxhash or the system's libxxhash") from None
        function = ctypes.CDLL(name).XXH64
        function.restype = ctypes.c_uint64
        function.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint64]

        def digest(data: Union[bytes, memoryview]) -> int:
            octets = np.frombuffer(data, dtype=np.uint8)  # whose address can be had without a copy
            return int(function(octets.ctypes.data, octets.size, 0))

        return digest


xxh64 = _load()


class Xxh64:
    """The same of bytes that come piece by piece."""

    def __init__(self) -> None:
        try:
            import xxhash

            self._hash: Any = xxhash.xxh64()
        except ImportError:
            self._hash = _LibraryHash()

    def update(self, data: Union[bytes, memoryview]) -> None:
        """More bytes."""
        if len(data):
            self._hash.update(data)

    def digest(self) -> int:
        """Of all so far."""
        return int(self._hash.intdigest())


class _LibraryHash:
    def __init__(self) -> None:
        self._library = ctypes.CDLL(ctypes.util.find_library("xxhash"))
        self._library.XXH64_createState.restype = ctypes.c_void_p
        self._library.XXH64_digest.restype = ctypes.c_uint64
        self._state = ctypes.c_void_p(self._library.XXH64_createState())
        self._library.XXH64_reset(self._state, ctypes.c_uint64(0))

    def __del__(self) -> None:
        self._library.XXH64_freeState(self._state)

    def update(self, data: Union[bytes, memoryview]) -> None:
        octets = np.frombuffer(data, dtype=np.uint8)
        self._library.XXH64_update(self._state, ctypes.c_void_p(octets.ctypes.data), ctypes.c_size_t(octets.size))

    def intdigest(self) -> int:
        return int(self._library.XXH64_digest(self._state))

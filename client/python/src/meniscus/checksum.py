# SPDX-License-Identifier: BSD-3-Clause
"""xxh64 of arrays, by the package xxhash if there is one, else by the library that the daemon uses too."""

from __future__ import annotations

import ctypes
import ctypes.util
from typing import Callable, Union

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

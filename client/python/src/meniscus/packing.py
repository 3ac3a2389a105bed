# SPDX-License-Identifier: BSD-3-Clause
"""Packed arrays of streams as numpy arrays. The codecs are packages that only those need who ask for them: lz4, zstandard."""

from __future__ import annotations

import math
from typing import Any, Union

import numpy as np
import xxhash

from . import packing_pb2 as pb
from .errors import CorruptError, MeniscusError

Bytes = Union[bytes, bytearray, memoryview]
TYPES = ("<f8", "<f4", "<u8", "<u4", "|u1")


def checked_size(manifest: pb.PackedArray, limit: int) -> int:
    """Bytes of the array once it is unpacked. CorruptError if the manifest contradicts itself, MeniscusError beyond the limit."""
    if manifest.type not in TYPES or manifest.codec not in pb.Codec.values():
        raise MeniscusError("UNIMPLEMENTED", f'the array "{manifest.name}" is of a type or codec that is not known here')
    size: int = math.prod(manifest.shape) * np.dtype(manifest.type).itemsize
    if size > limit:
        raise MeniscusError("RESOURCE_EXHAUSTED", f'the array "{manifest.name}" is larger than the {limit} bytes there is room for')
    if len(manifest.shape) > 4 or manifest.raw_bytes != size or not manifest.HasField("xxh64"):
        raise _corrupt(manifest, "its size is not that of its type and shape, or it tells no checksum")
    plain = _plain_size(manifest)
    packed = manifest.packed_bytes
    if packed > plain or (packed != plain and manifest.codec == pb.CODEC_NONE) or (packed == plain and manifest.codec != pb.CODEC_NONE):
        raise _corrupt(manifest, "its sizes contradict each other")
    if manifest.HasField("shuffle") and (not 2 <= manifest.shuffle <= 256 or plain % manifest.shuffle):
        raise _corrupt(manifest, "its bytes cannot have been shuffled in rows of that length")
    if manifest.HasField("quantisation"):
        _check_quantisation(manifest)
    return size


def unpack(manifest: pb.PackedArray, packed: Bytes, limit: int) -> np.ndarray:
    """The array, in memory of its own or, if nothing had to be done, in that of the bytes."""
    checked_size(manifest, limit)
    if len(packed) != manifest.packed_bytes:
        raise _corrupt(manifest, "not all of its bytes came, or too many")
    if xxhash.xxh64_intdigest(packed if len(packed) else b"") != manifest.xxh64:
        raise _corrupt(manifest, "its checksum does not match")
    data = np.frombuffer(_decode(manifest, packed), np.uint8)
    if manifest.HasField("shuffle"):
        data = data.reshape(manifest.shuffle, -1).T.ravel()
    shape = tuple(manifest.shape)
    if not manifest.HasField("quantisation"):
        array = data.view(manifest.type).reshape(shape)
        return array if array.flags.writeable and array.flags.aligned else array.copy()
    grid = manifest.quantisation
    integers = data.view(f"<u{grid.width}").reshape(-1, len(grid.offset))
    values = np.multiply(integers, grid.step, dtype=np.float64)
    values += np.array(grid.offset)
    return values.reshape(shape)


def _check_quantisation(manifest: pb.PackedArray) -> None:
    grid = manifest.quantisation
    offsets = len(grid.offset)
    if manifest.type != "<f8" or grid.width not in (1, 2, 4) or not 1 <= offsets <= 16:
        raise _corrupt(manifest, "it is quantised in a way that there is not")
    if math.prod(manifest.shape) % offsets or not all(map(math.isfinite, [grid.step, *grid.offset])):
        raise _corrupt(manifest, "its step or offsets do not fit it")


def _plain_size(manifest: pb.PackedArray) -> int:
    quantised = manifest.HasField("quantisation")
    number: int = manifest.quantisation.width if quantised else np.dtype(manifest.type).itemsize
    count: int = math.prod(manifest.shape)
    return count * number


def _decode(manifest: pb.PackedArray, packed: Bytes) -> Bytes:
    if manifest.codec == pb.CODEC_NONE:
        return packed
    size = _plain_size(manifest)
    try:
        data: Bytes = _decode_lz4(packed, size) if manifest.codec == pb.CODEC_LZ4 else _decode_zstd(packed, size)
    except ImportError:
        raise
    except Exception as error:  # each package has exceptions of its own
        raise _corrupt(manifest, f"its codec cannot read it: {error}") from None
    if len(data) != size:
        raise _corrupt(manifest, "its codec does not make the bytes of its shape of what came")
    return data


def _decode_lz4(packed: Bytes, size: int) -> Bytes:
    block: Any = codec_module("lz4.block", "lz4")
    data: Bytes = block.decompress(packed, uncompressed_size=size, return_bytearray=True)
    return data


def _decode_zstd(packed: Bytes, size: int) -> Bytes:
    zstandard: Any = codec_module("zstandard", "zstandard")
    if zstandard.frame_content_size(packed) != size:  # before any memory is taken for it
        return b""
    data: Bytes = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    return data


def codec_module(module: str, package: str) -> Any:
    """The package of a codec. ImportError that says what to install."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError:
        raise ImportError(f"this codec takes the Python package {package} (Debian: python3-{package}), or ask for another") from None


def _corrupt(manifest: pb.PackedArray, what: str) -> CorruptError:
    return CorruptError("DATA_LOSS", f'the array "{manifest.name}" came damaged: {what}')

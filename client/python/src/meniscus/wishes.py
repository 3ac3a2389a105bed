# SPDX-License-Identifier: BSD-3-Clause
"""What a stream is asked for, and what comes of it, as plain values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import packing_pb2
from . import stream_pb2 as pb
from .errors import RefusedError
from .packing import codec_module
from .texts import texts_only

KINDS = ("probes", "fields", "events", "series", "snapshots")
CODECS = {"none": packing_pb2.CODEC_NONE, "lz4": packing_pb2.CODEC_LZ4, "zstd": packing_pb2.CODEC_ZSTD}
Exactness = Union[None, str, float, Mapping[str, Union[str, float]]]
Point = Union[Sequence[float], np.ndarray]
Box = Tuple[Point, Point]  # lower and upper corner [m]
Sphere = Tuple[Point, float]  # centre and radius [m]


@dataclass(frozen=True)
class Cursor:
    """A place in the files of a run, at which a stream of a series or of snapshots goes on. Keep it with what was taken."""

    line: int = 0  # the time line: another number after each restore or reset
    row: int = 0  # of a series: the next one
    file: str = ""  # of snapshots
    offset: int = 0  # of the first byte that was not taken


@dataclass(frozen=True)
class Column:
    """One column of the items of a stream."""

    name: str
    unit: str
    type: str  # as numpy writes it
    components: int


@dataclass(frozen=True)
class StreamItem:
    """What came. item["NAME"] is the array of a field, [particles] or [particles][components]; of probes a number, of a series [rows]."""

    sequence: int
    skipped: int  # items that were due since the one before, and were not sent
    daemon_epoch: int
    step: int
    time: float  # simulated [s]
    arrays: Dict[str, np.ndarray] = field(default_factory=dict)
    columns: Tuple[Column, ...] = ()
    state: Optional[str] = None  # events
    what: str = ""  # events
    text: str = ""  # events
    file: Optional[str] = None  # snapshots: name, without directory; abandoned: None, as those that come again tell
    file_size: int = 0  # [bytes]
    offset: int = 0  # of this piece in the file [bytes]
    data: Union[bytes, memoryview] = b""  # the piece
    whole: bool = False  # the file ends with it; its checksum matches, if it was taken from the beginning
    abandoned: bool = False  # a restore or reset undid, or a crash may have changed, what came after `row`; of snapshots those that come again by name
    row: int = 0
    cursor: Optional[Cursor] = None  # series, snapshots: behind this item; None within a file

    def __getitem__(self, name: str) -> Any:
        if name in self.arrays:
            return self.arrays[name]
        names = [column.name for column in self.columns]
        if "values" in self.arrays and name in names:
            return self.arrays["values"][..., names.index(name)]
        raise KeyError(name)

    def __getstate__(self) -> Dict[str, Any]:
        """For pickle, which takes no memoryview."""
        return {**self.__dict__, "data": bytes(self.data)}

    @property
    def units(self) -> Dict[str, str]:
        """Of what the item has, by name."""
        return {column.name: column.unit for column in self.columns}


@dataclass
class StreamStats:
    """What became of a stream so far. Bytes of arrays: as they came, and unpacked."""

    items: int = 0
    skipped: int = 0
    cancelled: int = 0
    reconnects: int = 0
    packed_bytes: int = 0
    raw_bytes: int = 0


@texts_only
def subscription(
    what: str,
    names: Iterable[str] = (),
    exact: Exactness = None,
    pack: str = "none",
    every_steps: Optional[int] = None,
    interval: Optional[float] = None,
    max_hz: Optional[float] = None,
    first: bool = False,
    box: Optional[Box] = None,
    sphere: Optional[Sphere] = None,
    phases: Iterable[int] = (),
    walls: bool = False,
    every: Optional[int] = None,
) -> pb.Subscribe:
    """The message. RefusedError for a kind, a codec or an exactness there is not; what the daemon knows better it says itself."""
    if what not in KINDS:
        raise RefusedError("INVALID_ARGUMENT", f'there is no stream of "{what}"; there are {", ".join(KINDS)}', "what")
    if pack not in CODECS:
        raise RefusedError("INVALID_ARGUMENT", f'there is no codec "{pack}"; there are {", ".join(CODECS)}', "pack")
    wish = pb.Subscribe(delivery=pb.LOSSLESS if what in ("series", "snapshots") else pb.LATEST)
    if pack != "none":
        codec_module("lz4.block" if pack == "lz4" else "zstandard", "lz4" if pack == "lz4" else "zstandard")
        wish.codec = CODECS[pack]
    names = [names] if isinstance(names, str) else list(names)
    _say_what(wish, what, names, exact)
    _say_when(wish, every_steps, interval, max_hz, True if first else False if what == "probes" else None)
    where: Dict[str, Any] = {"phases": list(phases)}
    if box is not None:
        where.update(min=box[0], max=box[1])
    if sphere is not None:
        where.update(centre=sphere[0], radius=sphere[1])
    if walls:
        where["walls"] = True
    if every is not None:
        where["every"] = every
    if len(where) > 1 or where["phases"]:
        wish.where.CopyFrom(pb.Where(**where))
    return wish


def _say_what(wish: pb.Subscribe, what: str, names: List[str], exact: Exactness) -> None:
    if what == "fields":
        for name in names:
            how = exact.get(name) if isinstance(exact, Mapping) else exact
            wish.fields.fields.add(name=name, exactness=_exactness(how))
        if not names:
            wish.fields.SetInParent()
    elif what == "events":
        wish.events.SetInParent()
    elif what == "snapshots":
        wish.snapshots.SetInParent()
    else:
        if isinstance(exact, Mapping):
            raise RefusedError("INVALID_ARGUMENT", "probes have one exactness for all", "exact")
        wish.probes.CopyFrom(pb.ProbeStream(names=names, exactness=_exactness(exact)))


def _exactness(how: Union[None, str, float]) -> Optional[pb.Exactness]:
    if how is None or how == "f64":
        return None
    if how == "f32":
        return pb.Exactness(f32=True)
    if isinstance(how, str):
        raise RefusedError("INVALID_ARGUMENT", f'exact is "f64", "f32" or a bound, not "{how}"', "exact")
    return pb.Exactness(bound=float(how))


def _say_when(
    wish: pb.Subscribe, every_steps: Optional[int], interval: Optional[float], max_hz: Optional[float], first: Optional[bool]
) -> None:
    """first: None to say nothing of it, which for probes means yes."""
    given = {"every_steps": every_steps, "interval": interval, "max_hz": max_hz, "first": first}
    when = {name: value for name, value in given.items() if value is not None}
    if when:
        wish.when.CopyFrom(pb.When(**when))  # type: ignore[arg-type]

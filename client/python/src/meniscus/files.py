# SPDX-License-Identifier: BSD-3-Clause
"""The files of a run as numpy arrays: snapshots and the series of its probes. Needs h5py, and no daemon.

Nothing is read before it is asked for. A run that goes on writing disturbs nobody: a file with its final name is whole, and what was
opened stays as it was until refresh().
"""

from __future__ import annotations

import errno
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Type, Union, overload

import numpy as np

from .errors import CorruptError
from .escapes import shown
from .texts import check_path

PathLike = Union[str, Path]


def _open(path: Path) -> Any:
    import h5py

    if not path.is_file():
        raise FileNotFoundError(f"there is no file {shown(path)}")
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise CorruptError("DATA_LOSS", f"{path} is no whole HDF5 file: {error}") from None


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


class Field:
    """One field of a snapshot, read when it is indexed or made an array: field[:], field[:100], np.asarray(field)."""

    def __init__(self, dataset: Any, columns: Optional[int] = None) -> None:
        self._dataset = dataset
        self._columns = columns
        self.name: str = dataset.name.rsplit("/", 1)[1]
        self.unit = _text(dataset.attrs.get("unit", ""))
        self.meaning = _text(dataset.attrs.get("meaning", ""))
        self.dtype: np.dtype[Any] = dataset.dtype
        self.shape: Tuple[int, ...] = dataset.shape[:1] if len(dataset.shape) == 1 else (dataset.shape[0], columns or dataset.shape[1])

    def __reduce__(self) -> Tuple[Any, ...]:
        return _field_of, (os.path.abspath(self._dataset.file.filename), self.name)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: Any) -> Any:
        whole = rows if isinstance(rows, tuple) else (rows,)
        if len(self.shape) == 2 and len(whole) == 1 and self._columns:
            return self._dataset[whole[0], : self._columns]
        return self._dataset[rows]

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> np.ndarray:
        return np.asarray(self[:], dtype=dtype)

    def __repr__(self) -> str:
        return f"<Field {self.name} {list(self.shape)} {self.dtype}, {self.meaning} [{self.unit}]>"


def _field_of(path: str, name: str) -> Field:
    """What a field is pickled as: it is read again where it is unpickled."""
    return Snapshot(path)[name]


class Snapshot(Mapping[str, Field]):
    """A snapshot: fields by name, and which moment of which run.

        with Snapshot("snapshot-0000000100.hdf") as snapshot:
            snapshot.time, snapshot.units["pressure"]
            water = snapshot.select("water")                       # a mask
            snapshot["pressure"][:][water].max()
            snapshot.array("position", "pressure")["pressure"]     # structured

    Vectors have as many components as the case has dimensions. A snapshot, and a field of one, is pickled as the path of its file.
    """

    def __init__(self, path: PathLike) -> None:
        check_path("path", path)
        self.path = Path(path)
        self._file = _open(self.path)
        try:
            about = self._file["meniscus"]
            self.time = float(about.attrs["time"])  # simulated [s]
            self.step = int(about.attrs["step"])
            self.time_step = float(about.attrs["dt"])  # the last one [s]
            self.dimensions = int(about.attrs["dim"])
            self.spacing = float(about.attrs["spacing"])  # of particles at the start [m]
            self.title = _text(about.attrs["title"])
            self.case = _text(about.attrs["case"])
            self.fluids = tuple(_text(name) for name in about["fluids"][:])
            self.walls = tuple(_text(name) for name in about["walls"][:])
            self._fields = ["position", *self._file["VTKHDF/PointData"]]
        except KeyError as error:
            self.close()
            raise CorruptError("DATA_LOSS", f"{self.path} is no snapshot of Meniscus: {error}") from None

    def close(self) -> None:
        """Close the file; arrays that were read stay."""
        self._file.close()

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.path.absolute(),)

    def __enter__(self) -> Snapshot:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def __getitem__(self, name: str) -> Field:
        if name not in self._fields:
            raise KeyError(f'"{name}" is not in {self.path.name}; there are {", ".join(self._fields)}')
        dataset = self._file["VTKHDF/Points" if name == "position" else f"VTKHDF/PointData/{name}"]
        wide = len(dataset.shape) == 2 and dataset.shape[1] == 3
        field = Field(dataset, self.dimensions if wide else None)
        field.name = name
        return field

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    @property
    def particles(self) -> int:
        """How many there are in it."""
        return int(self._file["VTKHDF/NumberOfPoints"][0])

    @property
    def units(self) -> Dict[str, str]:
        """Of the fields, by name."""
        return {name: self[name].unit for name in self}

    def select(self, *names: str) -> np.ndarray:
        """Which particles are of these fluids and walls: a mask [n]."""
        all_names = self.fluids + self.walls
        for name in names:
            if name not in all_names:
                raise KeyError(f'there is no fluid or wall "{name}"; there are {", ".join(all_names)}')
        return np.isin(self["phase"][:], [k for k, name in enumerate(all_names) if name in names])

    def array(self, *names: str) -> np.ndarray:
        """These fields, or all, as a structured array [n]."""
        fields = [self[name] for name in names or self]
        table = np.empty(self.particles, dtype=[(f.name, f.dtype, f.shape[1:]) for f in fields])
        for field in fields:
            table[field.name] = field[:]
        return table

    def to_xarray(self, *names: str) -> Any:
        """These fields, or all, as an xarray.Dataset: dimensions particle and, of vectors, axis (x, y, z); units and meanings are the attributes of its variables. Needs xarray."""
        import xarray

        fields = [self[name] for name in names or self]
        variables = {f.name: (("particle", "axis")[: len(f.shape)], f[:], {"units": f.unit, "long_name": f.meaning}) for f in fields}
        about = {"title": self.title, "case": self.case, "time": self.time, "step": self.step, "spacing": self.spacing}
        return xarray.Dataset(variables, coords={"axis": list("xyz"[: self.dimensions])}, attrs=about)

    def plot(self, name: str = "phase", axes: Any = None, across: str = "y") -> Any:
        """Particles in the plane, coloured by a field; of vectors, by their length. Needs matplotlib.

        axes: of matplotlib, to draw into; none: those of a figure of their own. across: in three dimensions, the axis across the
        slice through the middle of the domain, a spacing thick, that is shown. Returns the axes."""
        field, x = self[name], self["position"][:]
        plane = [d for d in range(self.dimensions) if self.dimensions == 2 or "xyz"[d] != across]
        if len(plane) != 2:
            raise ValueError(f'across is "{shown(across)}", and must be x, y or z')
        drawn = np.ones(len(x), dtype=bool)
        if self.dimensions == 3:
            depth = x[:, "xyz".index(across)]
            drawn = np.abs(depth - 0.5 * (depth.min() + depth.max())) <= 0.5 * self.spacing
        if axes is None:
            from matplotlib.figure import Figure

            axes = Figure(figsize=(7, 4), layout="constrained").subplots()
        values = np.linalg.norm(field[:], axis=1) if len(field.shape) == 2 else field[:]
        dots = axes.scatter(x[drawn, plane[0]], x[drawn, plane[1]], c=values[drawn], s=4, linewidths=0)
        axes.set(aspect="equal", xlabel=f"{'xyz'[plane[0]]} [m]", ylabel=f"{'xyz'[plane[1]]} [m]", title=f"t = {self.time:g} s")
        axes.figure.colorbar(dots, ax=axes, label=f"{name} [{field.unit}]" if field.unit not in ("", "1") else name)
        return axes

    def __repr__(self) -> str:
        return f"<Snapshot {shown(self.path.name)}, step {self.step}, time {self.time:g} s, {self.particles} particles: {', '.join(self)}>"


class Snapshots(Sequence[Snapshot]):
    """The snapshots of a run directory in the order of their steps, each opened when it is asked for, and open as long as it is kept."""

    def __init__(self, directory: PathLike) -> None:
        """FileNotFoundError: there is no such directory."""
        check_path("directory", directory)
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise FileNotFoundError(errno.ENOENT, "there is no such directory of a run", str(directory))
        self.refresh()

    def refresh(self) -> None:
        """Look which there are by now."""
        self.paths: List[Path] = sorted(self.directory.glob("snapshot-*.hdf"), key=lambda path: int(path.stem.split("-")[1]))

    def __len__(self) -> int:
        return len(self.paths)

    @overload
    def __getitem__(self, k: int) -> Snapshot: ...

    @overload
    def __getitem__(self, k: slice) -> List[Snapshot]: ...

    def __getitem__(self, k: Union[int, slice]) -> Union[Snapshot, List[Snapshot]]:
        return [Snapshot(path) for path in self.paths[k]] if isinstance(k, slice) else Snapshot(self.paths[k])

    @property
    def times(self) -> np.ndarray:
        """Of all of them [s]."""
        return np.array([snapshot.time for snapshot in self])

    def __repr__(self) -> str:
        return f"<{len(self)} snapshots in {shown(self.directory)}>"


class ProbeSeries(Mapping[str, np.ndarray]):
    """The probes of a run over time, from its probes.hdf: arrays by name, all of the same length.

        series = ProbeSeries("runs/dambreak2d")
        series.time, series["front"], series.units["front"]
        series.array("front", "P05")          # structured, with the fields step and time before those that are named

    Before the run has written anything there are no probes in it. nan: there was nothing to measure. It is pickled as the path of its file.
    """

    def __init__(self, path: PathLike) -> None:
        """path: a run directory, or the file, which may be there later if its directory is. FileNotFoundError: there is neither."""
        check_path("path", path)
        if not Path(path).exists() and (Path(path).name != "probes.hdf" or not Path(path).parent.is_dir()):
            raise FileNotFoundError(errno.ENOENT, "there is no such directory of a run, nor a file", str(path))
        self.path = Path(path) / "probes.hdf" if Path(path).is_dir() else Path(path)
        self._file: Any = None
        self._stamp: Optional[Tuple[int, int, int]] = None
        self._read: Dict[str, np.ndarray] = {}
        self.refresh()

    def refresh(self) -> bool:
        """Take what was written since; was there anything?"""
        try:
            about = os.stat(self.path)
        except FileNotFoundError:
            return False
        stamp = (about.st_ino, about.st_mtime_ns, about.st_size)
        if stamp == self._stamp:
            return False
        file = _open(self.path)
        self.close()
        self._file, self._stamp, self._read = file, stamp, {}
        return True

    def close(self) -> None:
        """Close the file; arrays that were read stay."""
        if self._file:
            self._file.close()
        self._file = None

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.path.absolute(),)

    def __enter__(self) -> ProbeSeries:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def _column(self, name: str) -> np.ndarray:
        if name not in self._read:
            if not self._file:
                return np.empty(0, dtype=np.uint64 if name == "step" else np.float64)
            self._read[name] = self._file[name][:]
        return self._read[name]

    @property
    def step(self) -> np.ndarray:
        """Of each row."""
        return self._column("step")

    @property
    def time(self) -> np.ndarray:
        """Of each row, simulated [s]."""
        return self._column("time")

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names():
            raise KeyError(f'there is no probe "{name}" in {self.path}; there are {", ".join(self) or "none yet"}')
        return self._column(f"probes/{name}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def _names(self) -> List[str]:
        return list(self._file["probes"]) if self._file else []

    @property
    def units(self) -> Dict[str, str]:
        """Of the probes, by name."""
        return {name: _text(self._file[f"probes/{name}"].attrs["unit"]) for name in self}

    def array(self, *names: str) -> np.ndarray:
        """Step, time and these probes, or all, as a structured array."""
        columns = {"step": self.step, "time": self.time, **{name: self[name] for name in names or self}}
        table = np.empty(len(self.time), dtype=[(name, column.dtype) for name, column in columns.items()])
        for name, column in columns.items():
            table[name] = column
        return table

    def to_pandas(self, *names: str) -> Any:
        """These probes, or all, as a pandas.DataFrame with the time as its index; its attrs["units"] has their units. Needs pandas."""
        import pandas

        chosen = names or tuple(self)
        frame = pandas.DataFrame({"step": self.step, **{name: self[name] for name in chosen}}, index=pandas.Index(self.time, name="time"))
        frame.attrs["units"] = {name: self.units[name] for name in chosen}
        return frame

    def __repr__(self) -> str:
        return f"<ProbeSeries {shown(self.path)}, {len(self.time)} rows: {', '.join(self)}>"

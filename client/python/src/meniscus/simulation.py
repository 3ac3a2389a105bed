# SPDX-License-Identifier: BSD-3-Clause
"""A simulation as one speaks of it: its time and state, parameters with unit and bounds, probes as numbers, its files.

Every access to a value asks the daemon; nothing here is remembered but what cannot change during a run.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, List, Mapping, MutableMapping, Optional, Tuple, Union, cast

import numpy as np
import yaml

from . import display
from . import meniscus_pb2 as pb
from .client import Client
from .errors import RefusedError, StateError
from .escapes import shown
from .files import ProbeSeries, Snapshots
from .plot import LivePlot
from .values import Value

Setting = Union[float, int, bool, str, List[Any], None]
Changes = Union[Mapping[str, Any], Iterable[Tuple[str, Any]]]


@dataclass(frozen=True)
class Bounds:
    """The numbers between two; `3 in bounds`. A square bracket in its text includes the bound, a round one does not."""

    minimum: float
    maximum: float
    with_minimum: bool = True
    with_maximum: bool = True

    @classmethod
    def read(cls, text: str) -> Optional[Bounds]:
        """As the daemon writes it: "[0, inf)"; None if there are none."""
        found = re.fullmatch(r"([\[(])\s*([^,\s]+)\s*,\s*([^,\s]+)\s*([\])])", text)
        return cls(float(found[2]), float(found[3]), found[1] == "[", found[4] == "]") if found else None

    def __contains__(self, value: float) -> bool:
        above = value >= self.minimum if self.with_minimum else value > self.minimum
        below = value <= self.maximum if self.with_maximum else value < self.maximum
        return above and below

    def __str__(self) -> str:
        left, right = "(["[self.with_minimum], ")]"[self.with_maximum]
        return f"{left}{self.minimum:g}, {self.maximum:g}{right}"


@dataclass(frozen=True)
class Parameter:
    """An entry of the case that can be set, as it was when it was asked for. float(parameter) is its value."""

    path: str
    value: Setting  # a number, True or False, a word, or a list of formulas; None: not part of this case
    unit: str
    bounds: Optional[Bounds]
    choices: Tuple[str, ...]  # words to choose from
    meaning: str

    def __float__(self) -> float:
        return float(self.value)  # type: ignore[arg-type]

    def __str__(self) -> str:
        return f"{self.value} {self.unit}".rstrip()


def read_parameter(message: pb.Parameter) -> Parameter:
    """From the capabilities of a daemon."""
    words = tuple(word.strip() for word in message.type.split(",")) if "," in message.type else ()
    value: Setting = yaml.safe_load(message.value) if message.HasField("value") else None
    if isinstance(value, str) and not words:
        try:
            value = float(value)  # YAML takes 1e-3 for a word
        except ValueError:
            pass
    bounds = Bounds.read(message.range)
    return Parameter(message.path, value, message.unit, bounds, words, message.meaning)


class Parameters(MutableMapping[str, Any]):
    """What can be set while it runs, by path or by name:

        simulation.parameters["scheme.cfl"] = 0.2
        simulation.parameters.scheme.cfl = 0.2
        simulation.parameters.scheme.cfl.bounds
        simulation.parameters.update({"end_time": 3, "gravity": [0, -1]})      # both at the same step, or neither

    RefusedError, whose path is the entry, when a value is out of bounds: the daemon says what is allowed.
    """

    def __init__(self, client: Client, prefix: str = "") -> None:
        object.__setattr__(self, "_client", client)
        object.__setattr__(self, "_prefix", prefix)

    def _all(self) -> Dict[str, Parameter]:
        n = len(self._prefix)
        messages = self._client.capabilities().parameters
        return {m.path[n:]: read_parameter(m) for m in messages if m.path.startswith(self._prefix)}

    def __getitem__(self, path: str) -> Parameter:
        try:
            return self._all()[path]
        except KeyError:
            raise KeyError(f'"{self._prefix}{path}" cannot be set; there are {", ".join(self)}') from None

    def __setitem__(self, path: str, value: Any) -> None:
        self._client.set({self._prefix + path: value})

    def __delitem__(self, path: str) -> None:
        raise TypeError("parameters cannot be removed, but changed: see rollback()")

    def update(self, changes: Changes = (), /, **words: Setting) -> None:  # type: ignore[override] # one that has keys() alone is not read
        """Change several at the same step, all or none."""
        changes = dict(changes, **words)
        self._client.set({self._prefix + path: value for path, value in changes.items()})

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        known = self._all()
        if name in known:
            return known[name]
        if any(path.startswith(name + ".") for path in known):
            return Parameters(self._client, f"{self._prefix}{name}.")
        raise AttributeError(f'no parameter "{self._prefix}{shown(name)}"; there are {", ".join(known)}')

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value

    def __dir__(self) -> List[str]:
        return [*super().__dir__(), *dict.fromkeys(path.split(".")[0] for path in self)]

    def _ipython_key_completions_(self) -> List[str]:
        return list(self)

    def __repr__(self) -> str:
        return "\n".join(f"{self._prefix}{path} = {parameter}" for path, parameter in self._all().items())

    def _repr_html_(self) -> str:
        rows = [(self._prefix + path, str(p), str(p.bounds or " ".join(p.choices)), p.meaning) for path, p in self._all().items()]
        return display.table(rows, ("parameter", "value", "allowed", "meaning"))


class Probes(Mapping[str, float]):
    """The probes at this moment, as numbers: nan where there is nothing to measure.

        simulation.probes["front"]             # float
        simulation.probes.units["front"]       # "m"
        simulation.probes.now("front", "P05")  # structured, all of one step
    """

    def __init__(self, client: Client) -> None:
        self._client = client

    def __getitem__(self, name: str) -> float:
        try:
            return _number(self._client.query(name)[name])
        except RefusedError as error:
            raise KeyError(error.message) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._client.capabilities().probes)

    def __len__(self) -> int:
        return len(self._client.capabilities().probes)

    @property
    def units(self) -> Dict[str, str]:
        """By name."""
        return {name: value.unit for name, value in self._client.query().items()}

    def now(self, *names: str) -> np.void:
        """These probes, or all, of one step, as a record (np.void) whose fields have their names."""
        values = self._client.query(*names)
        record = np.zeros((), dtype=[(name, np.float64) for name in values])
        for name, value in values.items():
            record[name] = _number(value)
        return cast(np.void, record[()])

    def _ipython_key_completions_(self) -> List[str]:
        return list(self)

    def __repr__(self) -> str:
        return "\n".join(f"{name} = {value.value} {value.unit}".rstrip() for name, value in self._client.query().items())

    def _repr_html_(self) -> str:
        rows = [(name, f"{value.value} {value.unit}") for name, value in self._client.query().items()]
        return display.table(rows, ("probe", "value"))


def _number(value: Value) -> float:
    return float(value.value) if isinstance(value.value, (int, float)) else math.nan


class Simulation(Client):
    """A simulation in a daemon: all commands of Client, and what one reads and writes as attributes.

        with meniscus.Simulation("lab") as simulation:
            simulation.load("dambreak2d", {"resolution": 20})
            simulation.run_until(0.5)
            simulation.parameters.gravity = [0, -2]
            simulation.probes["front"]
            simulation.particles(["velocity"])["velocity"]      # numpy [n][2], in the memory it was received in
            simulation.snapshots[-1]["pressure"][:]             # from the files of the run

    The arguments are those of Client.
    """

    @property
    def state(self) -> str:
        """As in wait()."""
        return self.status().state

    @property
    def time(self) -> float:
        """Simulated [s]; nan without a case."""
        time = self.status().time
        return math.nan if time is None else time

    @property
    def parameters(self) -> Parameters:
        """What can be set, with units and bounds."""
        return Parameters(self)

    @parameters.setter
    def parameters(self, changes: Mapping[str, Any]) -> None:
        self.parameters.update(changes)

    @property
    def probes(self) -> Probes:
        """What is measured, now."""
        return Probes(self)

    @property
    def directory(self) -> Path:
        """Where the files of the run are, on the daemon's machine."""
        path = self.status().run_directory
        if path is None:
            raise StateError("FAILED_PRECONDITION", "there is no run: load() a case first")
        return Path(path)

    @property
    def snapshots(self) -> Snapshots:
        """Those that were written so far; snapshot() writes one more."""
        return Snapshots(self.directory)

    @property
    def series(self) -> ProbeSeries:
        """The probes over time, as far as they were written."""
        return ProbeSeries(self.directory)

    def plot(self, *probes: str, interval: float = 0.2) -> LivePlot:
        """A plot of probes over time, for notebooks; none: the first. plot().follow() draws them as they come. Needs matplotlib."""
        names = probes or tuple(self.capabilities().probes)[:1]
        return LivePlot(self, names, interval)

    def __repr__(self) -> str:
        status = self.status()
        return f"<Simulation {status.case_name or 'without a case'}, {status.state}, step {status.step}, time {status.time} s>"

    def _repr_html_(self) -> str:
        status = self.status()
        return status._repr_html_() + (self.probes._repr_html_() if status.state not in ("EMPTY", "LOADING", "RECOVERING") else "")

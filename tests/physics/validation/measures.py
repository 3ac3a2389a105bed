# SPDX-License-Identifier: BSD-3-Clause
"""Probes of the flows of retelling.py: their units, and what they become in another frame or in a part of the flow."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from validation.runs import Snapshot

Told = dict  # a case, or a part of it, as its file has it


@dataclass(frozen=True)
class Kind:
    """A kind of probe in the plane, where bodies are slabs one metre deep."""

    mass: int
    length: int
    time: int
    scale: str  # its differences are told over this, see scale()
    sums: bool = False  # two alike have twice as much

    def unit(self, mass: float, length: float, time: float) -> float:
        return mass**self.mass * length**self.length * time**self.time


KINDS: dict[str, Kind] = {
    "kinetic_energy": Kind(1, 1, -2, "itself", sums=True),
    "potential_energy": Kind(1, 1, -2, "weight", sums=True),
    "mass": Kind(1, -1, 0, "itself", sums=True),
    "volume": Kind(0, 2, 0, "itself", sums=True),
    "surface_area": Kind(0, 1, 0, "itself", sums=True),
    "momentum": Kind(1, 0, -1, "momentum", sums=True),
    "velocity": Kind(0, 1, -1, "velocity"),
    "mass_centre": Kind(0, 1, 0, "box"),
    "height": Kind(0, 1, 0, "box"),
    "elevation": Kind(0, 1, 0, "box"),
    "extent": Kind(0, 1, 0, "box"),
    "front": Kind(0, 1, 0, "box"),
    "roundness": Kind(0, 0, 0, "itself"),
    "coverage": Kind(0, 0, 0, "itself"),
    "escaped": Kind(0, 0, 0, "one", sums=True),
    "pressure": Kind(1, -1, -2, "pressure"),
    "pressure_jump": Kind(1, -1, -2, "pressure"),
    "pressure_deviation": Kind(1, -1, -2, "pressure"),
}
EXTREMA: dict[str, Kind] = {
    "velocity": Kind(0, 1, -1, "velocity"),
    "pressure": Kind(1, -1, -2, "pressure"),
    "density": Kind(1, -3, 0, "itself"),
}
MOVE_WITH_WALL = ("pressure", "height", "elevation", "coverage", "escaped")


def kind_name(probe: Told) -> str:
    return str(next(key for key in probe if key != "name"))


def kind_of(probe: Told) -> Kind:
    name = kind_name(probe)
    return EXTREMA[probe[name]["field"]] if name == "extremum" else KINDS[name]


# What is summed for one fluid, or for all.
SUMS = ("kinetic_energy", "potential_energy", "mass", "volume")
AXES: tuple[tuple[str, str], ...] = (("momentum", "x"), ("momentum", "y"), ("velocity", "x"), ("velocity", "y"), ("mass_centre", "x"), ("mass_centre", "y"))


def of_fluid(fluid: str | None) -> list[Told]:
    whose, suffix = ({"fluid": fluid}, f"-{fluid}") if fluid else ({}, "")
    return [{"name": f"{kind}{suffix}", kind: dict(whose)} for kind in SUMS] + [
        {"name": f"{kind}-{axis}{suffix}", kind: whose | {"axis": axis}} for kind, axis in AXES]


def of_all(deviation: str) -> list[Told]:
    """Probes of every flow. deviation: a pressure that is not far from the flow's."""
    return of_fluid(None) + [
        {"name": "gauge", "pressure": {"at": [0.81, 0.34]}},
        {"name": "coverage", "coverage": {}},
        {"name": "escaped", "escaped": {}},
        {"name": "deviation", "pressure_deviation": {"from": deviation}},
        {"name": "depth", "height": {"fluid": "water", "at": [0.77], "vertical": "y"}},
    ] + [{"name": f"{which}-{field}", "extremum": {"field": field, "which": which}} for field in EXTREMA for which in ("max", "min")]  # fmt: skip


def of_drop(fluid: str) -> list[Told]:
    """Probes of a fluid with a surface."""
    return of_fluid(fluid) + [
        {"name": "roundness", "roundness": {"fluid": fluid}},
        {"name": "surface", "surface_area": {"fluid": fluid}},
        {"name": "jump", "pressure_jump": {"inside": fluid, "margin": 0.06}},
        {"name": "front", "front": {"fluid": fluid, "axis": "y"}},
        {"name": "top", "elevation": {"fluids": [fluid], "at": [0.41], "vertical": "y", "which": "max"}},
    ] + [{"name": f"extent-{axis}-{which}", "extent": {"fluid": fluid, "axis": axis, "which": which}} for axis in "xy" for which in ("max", "min")]  # fmt: skip


@dataclass
class Seen:
    """The end of a run."""

    snapshot: Snapshot
    probes: dict[str, float]  # by name; what has no counterpart in the other telling is left out


def without(told: Told, *kinds: str) -> Told:
    """The flow without its probes of these kinds, or of these kinds along an axis, as in mass_centre-x."""

    def goes(probe: Told) -> bool:
        kind = kind_name(probe)
        return kind in kinds or f"{kind}-{probe[kind].get('axis')}" in kinds or f"{kind}-{probe[kind].get('field')}" in kinds

    return {**told, "probes": [probe for probe in told["probes"] if not goes(probe)]}


def with_walls(told: Told, wall: str) -> Told:
    """Places of probes move with a wall."""
    new = copy.deepcopy(told)
    for probe in new["probes"]:
        if (kind := kind_name(probe)) in MOVE_WITH_WALL:
            probe[kind]["wall"] = wall
    return new


def of_whole(seen: Seen, told: Told, parts: float, like: float = 1) -> Seen:
    """What there is of a flow that is made of so many parts. like: of these, how many a body's roundness is of."""
    new = {}
    for probe in told["probes"]:
        value = seen.probes[probe["name"]]
        new[probe["name"]] = value * (parts if kind_of(probe).sums else np.sqrt(like) if kind_name(probe) == "roundness" else 1)
    return Seen(seen.snapshot, new)


def framed(seen: Seen, told: Told, x: Sequence[float], v: Sequence[float]) -> Seen:
    """In a frame whose origin is at x and moves at v. Kinetic energies are those of its velocities; places of probes have been moved."""
    new = {}
    for probe in told["probes"]:
        name, kind = probe["name"], kind_name(probe)
        options, value = probe[kind], seen.probes[probe["name"]]
        suffix = f"-{options['fluid']}" if "fluid" in options else ""
        mass = seen.probes[f"mass{suffix}"] if f"mass{suffix}" in seen.probes else np.nan
        axis = "xy".index(options["axis"]) if "axis" in options else 1  # the vertical
        if kind == "kinetic_energy":
            value += sum(0.5 * mass * v[d] ** 2 - v[d] * seen.probes[f"momentum-{'xy'[d]}{suffix}"] for d in range(2))
        value -= {"momentum": mass * v[axis], "velocity": v[axis]}.get(kind, x[axis] if kind in ("mass_centre", "extent", "front", "elevation") else 0)
        new[name] = value
    s = seen.snapshot
    assert s.velocity is not None
    return Seen(Snapshot(s.t, s.spacing, s.x - [*x, 0], s.phase, s.pressure, s.density, s.velocity - [*v, 0], s.acceleration, s.volume), new)


def scale(probe: Told, value: float, of: Seen, length: float = 1) -> float:
    """By which a difference of this probe is divided."""
    assert of.snapshot.velocity is not None and of.snapshot.pressure is not None
    speed, pressure = np.abs(of.snapshot.velocity).max(), np.abs(of.snapshot.pressure).max()
    mass = of.probes["mass"]
    scales = {"itself": abs(value), "one": 1, "box": length, "velocity": speed, "pressure": pressure, "momentum": mass * speed, "weight": mass * length}
    return float(scales[kind_of(probe).scale])

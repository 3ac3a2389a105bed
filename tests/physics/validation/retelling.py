# SPDX-License-Identifier: BSD-3-Clause
"""Flows that metamorphic.py tells twice, and the ways of telling them: in other units, mirrored, turned, moved, with fluids in another order, their tank
in other words."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from validation.runs import Snapshot

Told = dict  # of a case, as its file has it

SCHEMES: dict[str, dict] = {
    "riemann": {},
    "dissipation": {},
    "interfacial": {},
    "incompressible": {"reference_speed": 1},
    "differences": {"reference_speed": 1},
}
SIZE, END = 20, 0.05  # particles along the box; [s]: some fifty steps of sound


# --- flows -------------------------------------------------------------------------------------------------------------------


def names(told: Told) -> list[str]:
    return [fluid["name"] for fluid in told["fluids"]]


def tank(lower: Sequence[float], upper: Sequence[float]) -> list[Told]:
    return [{"outside": True, "box": {"min": list(lower), "max": list(upper)}}]


def plain(scheme: str) -> Told:
    """One liquid that turns in a closed tank under its weight, with no symmetry."""
    return {
        "dimensions": 2,
        "resolution": SIZE,
        "domain": {"min": [0, 0], "max": [1, 1]},
        "gravity": ["0", "-1"],
        "fluids": [{"name": "water", "density": 1024, "viscosity": 1, "sound_speed": 16,
                    "velocity": ["0.5*sin(pi*x)^2*sin(2*pi*y)", "-0.5*sin(2*pi*x)*sin(pi*y)^2"]}],
        "walls": [{"name": "tank", "shape": tank([0, 0], [1, 1])}],
        "scheme": {scheme: dict(SCHEMES[scheme])},
        "end_time": END,
        "probes": [{"name": "kinetic", "kinetic_energy": {}}, {"name": "potential", "potential_energy": {}}],
    }  # fmt: skip


def full(scheme: str) -> Told:
    """Two liquids with tension where the scheme has it, of other viscosities and sounds, in a tank they stick to, whose lid runs."""
    told = plain(scheme)
    told["fluids"].append({"name": "oil", "density": 512, "viscosity": 4, "sound_speed": 8, "velocity": ["0", "0"],
                           "shape": [{"ball": {"centre": [0.375, 0.45], "radius": 0.22}}]})  # fmt: skip
    if scheme != "riemann":
        told["interfaces"] = [{"between": ["water", "oil"], "tension": 8}]
    told["walls"] = [
        {"name": "tank", "slip": "none", "shape": [*tank([0, 0], [1, 2]), {"operation": "subtract", "half_space": {"point": [0, 1], "normal": [0, -1]}}]},
        {"name": "lid", "slip": "none", "shape": [{"half_space": {"point": [0, 1], "normal": [0, -1]}}], "surface_velocity": ["1", "0"]},
    ]
    return told


FLOWS: dict[str, Callable[[str], Told]] = {"plain": plain, "full": full}


# --- the same in other places and units --------------------------------------------------------------------------------------


@dataclass
class Change:
    """x' = turn (length x) + shift; times and masses by factors."""

    turn: np.ndarray = field(default_factory=lambda: np.eye(2))  # a permutation of the axes, with signs
    shift: np.ndarray = field(default_factory=lambda: np.zeros(2))  # [m'], of new axes
    length: float = 1
    time: float = 1
    mass: float = 1

    def point(self, x: Sequence[float]) -> list[float]:
        return (self.length * self.turn @ np.asarray(x, float) + self.shift).tolist()

    def box(self, told: Told) -> Told:
        a, b = self.point(told["min"]), self.point(told["max"])
        return {"min": np.minimum(a, b).tolist(), "max": np.maximum(a, b).tolist()}

    def old(self, text: str) -> str:
        """A formula of the old places, of the new ones."""
        back = {}
        for k, name in enumerate("xy"):
            j = int(np.argmax(np.abs(self.turn[:, k])))
            sign = self.turn[j, k]
            back[name] = f"({sign:g}*({'xy'[j]}-({self.shift[j]:.17g}))/{self.length:.17g})"
        back["t"] = f"(t/{self.time:.17g})"
        return re.sub(r"\b[xyt]\b", lambda m: back[m[0]], text)

    def vector(self, told: Sequence[str], unit: float) -> list[str]:
        new = []
        for row in self.turn:
            j = int(np.argmax(np.abs(row)))
            new.append(f"{row[j] * unit:.17g}*({self.old(told[j])})")
        return new

    def part(self, told: Told) -> Told:
        new = dict(told)
        if "box" in told:
            new["box"] = self.box(told["box"])
        if "ball" in told:
            new["ball"] = {"centre": self.point(told["ball"]["centre"]), "radius": self.length * told["ball"]["radius"]}
        if "half_space" in told:
            new["half_space"] = {"point": self.point(told["half_space"]["point"]), "normal": (self.turn @ told["half_space"]["normal"]).tolist()}
        return new

    def __call__(self, told: Told) -> Told:
        new = copy.deepcopy(told)
        L, T, M = self.length, self.time, self.mass
        new["reference_length"] = L * told.get("reference_length", 1)
        new["domain"] |= self.box(told["domain"])
        new["gravity"] = self.vector(told["gravity"], L / T**2)
        for fluid in new["fluids"]:
            fluid["density"] *= M / L**3
            fluid["viscosity"] *= M / (L * T)
            fluid["sound_speed"] *= L / T
            fluid["velocity"] = self.vector(fluid["velocity"], L / T)
            if "shape" in fluid:
                fluid["shape"] = [self.part(part) for part in fluid["shape"]]
        for interface in new.get("interfaces", []):
            interface["tension"] *= M / T**2
        for wall in new["walls"]:
            wall["shape"] = [self.part(part) for part in wall["shape"]]
            if "surface_velocity" in wall:
                wall["surface_velocity"] = self.vector(wall["surface_velocity"], L / T)
        for options in new["scheme"].values():
            if "reference_speed" in options:
                options["reference_speed"] *= L / T
        new["end_time"] *= T
        return new

    def back(self, s: Snapshot) -> Snapshot:
        """What is seen there, as it would be here."""
        x = np.zeros_like(s.x)
        v = np.zeros_like(s.velocity)
        x[:, :2] = (s.x[:, :2] - self.shift) @ self.turn / self.length
        v[:, :2] = s.velocity[:, :2] @ self.turn * (self.time / self.length)
        p = s.pressure * (self.length * self.time**2 / self.mass)
        return Snapshot(s.t / self.time, s.spacing / self.length, x, s.phase, p, None, v)


MIRROR, QUARTER, EXCHANGE = np.diag([-1.0, 1.0]), np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[0.0, 1.0], [1.0, 0.0]])
CHANGES: dict[str, tuple[Change, ...]] = {
    "units scaled by powers of two": (Change(length=4, time=0.5, mass=8),),
    "mirror image": (Change(MIRROR, np.array([1.0, 0.0])),),
    "quarter turns": (Change(QUARTER, np.array([1.0, 0.0])), Change(QUARTER @ QUARTER, np.array([1.0, 1.0]))),
    "axes exchanged": (Change(EXCHANGE),),
    "shift of the origin": (Change(shift=np.array([0.7, -0.3])),),
}


# --- the same in other words -------------------------------------------------------------------------------------------------


def order(told: Told) -> Told:
    return {**told, "fluids": told["fluids"][::-1]}


def sides(told: Told) -> Iterator[Told]:
    """The tank as four half spaces, as four boxes, and as everything less its inside."""
    planes = [([0, 0], [1, 0]), ([1, 0], [-1, 0]), ([0, 0], [0, 1]), ([0, 1], [0, -1])]
    for shape in (
        [{"half_space": {"point": point, "normal": normal}} for point, normal in planes],
        [{"box": {"min": a, "max": b}} for a, b in (([-9, -9], [0, 9]), ([1, -9], [9, 9]), ([-9, -9], [9, 0]), ([-9, 1], [9, 9]))],
        [{"box": {"min": [-9, -9], "max": [9, 9]}}, {"operation": "subtract", "box": {"min": [0, 0], "max": [1, 1]}}],
    ):
        yield {**told, "walls": [{"name": "tank", "shape": shape}]}

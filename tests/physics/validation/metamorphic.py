# SPDX-License-Identifier: BSD-3-Clause
"""What must come out the same when the same flow is told in another way: in other units, mirrored, turned, moved, seen by who moves, with its fluids
in another order. No reference is needed, and no scheme may know the difference.

Each row is the largest difference of the fields at the end over their largest value, of places over the size of the box; particles of the two
runs are matched by their places, those of a fluid among themselves."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from validation.metrics import Metric
from validation.runs import BUILD, Snapshot, run_file

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


# --- the same of another kind ------------------------------------------------------------------------------------------------


def endless(scheme: str, drop: bool) -> Told:
    """Vortices without walls or weight, and a drop among them."""
    told = full(scheme) if drop else plain(scheme)
    told["domain"]["periodic"] = ["x", "y"]
    told["walls"], told["gravity"] = [], ["0", "0"]
    for fluid in told["fluids"]:
        fluid["velocity"] = ["0.5*sin(2*pi*x)*cos(2*pi*y)", "-0.5*cos(2*pi*x)*sin(2*pi*y)"]
    return told


def balls(told: Told, offsets: Sequence[tuple[float, float]]) -> None:
    """The drop at these offsets from where it is."""
    for fluid in told["fluids"]:
        for part in fluid.get("shape", [])[:1]:
            (x, y), radius = part["ball"]["centre"], part["ball"]["radius"]
            fluid["shape"] = [{"ball": {"centre": [x + dx, y + dy], "radius": radius}} for dx, dy in offsets]


def view(s: Snapshot, keep: np.ndarray | slice = slice(None), x: Sequence[float] = (0, 0), v: Sequence[float] = (0, 0)) -> Snapshot:
    """Some of the particles, in a frame whose origin is at x and moves at v."""
    return Snapshot(s.t, s.spacing, s.x[keep] - [*x, 0], s.phase[keep], s.pressure[keep], None, s.velocity[keep] - [*v, 0])


def across(scheme: str, drop: bool) -> float:
    """The same half a period on, with the drop on both sides."""
    told = endless(scheme, drop)
    other = copy.deepcopy(told)
    balls(other, [(0.5, 0), (-0.5, 0)])
    for fluid in other["fluids"]:
        fluid["velocity"] = Change(shift=np.array([0.5, 0.0])).vector(fluid["velocity"], 1)
    return apart(last(told), view(last(other), x=(0.5, 0)), names(told), names(told), period=1)


def two_periods(scheme: str, drop: bool) -> float:
    told = endless(scheme, drop)
    other = copy.deepcopy(told)
    other["domain"]["max"] = [2, 1]
    balls(other, [(0, 0), (1, 0)])
    here, there = last(told), last(other)
    return apart(here, view(there, there.x[:, 0] < 1), names(told), names(told), period=1)


def moving_frame(scheme: str, drop: bool) -> float:
    told, U = endless(scheme, drop), (1.0, 0.5)
    other = copy.deepcopy(told)
    for fluid in other["fluids"]:
        fluid["velocity"] = [f"{u} + {text}" for u, text in zip(U, fluid["velocity"], strict=True)]
    return apart(last(told), view(last(other), x=[END * u for u in U], v=U), names(told), names(told), period=1)


def split(scheme: str, drop: bool) -> float:
    """A part of the water has another name."""
    told = full(scheme) if drop else plain(scheme)
    other = copy.deepcopy(told)
    water = copy.deepcopy(told["fluids"][0]) | {"name": "more", "shape": [{"half_space": {"point": [0.75, 0], "normal": [-1, 0]}}]}
    other["fluids"].append(water)
    for interface in list(other.get("interfaces", [])):
        other["interfaces"].append({"between": ["more", "oil"], "tension": interface["tension"]})
    there = last(other)
    there.phase = np.where(there.phase == len(other["fluids"]) - 1, 0, there.phase)
    return apart(last(told), there, names(told), names(told))


def shaken(scheme: str, drop: bool) -> float:
    """The tank goes to and fro; or gravity does."""
    told = full(scheme) if drop else plain(scheme)
    far, often = 0.004, 10.0
    other = copy.deepcopy(told)
    for wall in other["walls"]:
        wall["motion"] = {"one_minus_cosine": {"amplitude": [far, 0], "frequency": often}}
    turn = 2 * np.pi * often
    told["gravity"] = [f"-{far * turn**2:.17g}*cos({turn:.17g}*t)", "-1"]
    x, v = far * (1 - np.cos(turn * END)), far * turn * np.sin(turn * END)
    return apart(last(told), view(last(other), x=(x, 0), v=(v, 0)), names(told), names(told))


def half(scheme: str, drop: bool) -> float:
    """A flow that is its own mirror image, in walls that let it slip, and half of it."""
    told = full(scheme) if drop else plain(scheme)
    told["walls"] = [{"name": "tank", "shape": tank([0, 0], [1, 1])}]
    for fluid in told["fluids"]:
        fluid["velocity"] = ["0.25*sin(2*pi*x)*cos(pi*y)", "-0.5*cos(2*pi*x)*sin(pi*y)"]
    balls(told, [(0.125, 0)])
    other = copy.deepcopy(told)
    other["domain"]["min"] = [0.5, 0]
    other["walls"] = [{"name": "tank", "shape": tank([0.5, 0], [1, 1])}]
    there, here = last(other), last(told)
    return apart(there, view(here, here.x[:, 0] > 0.5), names(told), names(told))


def extruded(scheme: str, drop: bool) -> float:
    """In space, endless along z."""
    told = plain(scheme)
    other = copy.deepcopy(told)
    deep = 8 / SIZE
    other["dimensions"] = 3
    other["domain"] = {"min": [0, 0, 0], "max": [1, 1, deep], "periodic": ["z"]}
    other["gravity"] = [*told["gravity"], "0"]
    for fluid in other["fluids"]:
        fluid["velocity"] = [*fluid["velocity"], "0"]
    other["walls"] = [{"name": "tank", "shape": [{"outside": True, "box": {"min": [0, 0, -9], "max": [1, 1, 9]}}]}]
    here, there = last(told), last(other)
    worst = 0.0
    for z in np.unique(np.round(there.x[:, 2] / deep * 8 - 0.5)):
        layer = np.round(there.x[:, 2] / deep * 8 - 0.5) == z
        s = view(there, layer)
        s.x[:, 2] = 0
        worst = max(worst, apart(here, s, names(told), names(told)))
    return worst


OTHERS: dict[str, tuple[Callable[[str, bool], float], float]] = {
    "half of it beside a slip wall": (half, 1e-2),
    "shift across periodic sides": (across, 1e-4),
    "two periods for one": (two_periods, 1e-4),
    "seen from a moving frame": (moving_frame, 1e-2),
    "a tank that is shaken, and gravity in its frame": (shaken, 3e-2),
    "liquid split into two alike": (split, 6e-2),
}


# --- scores ------------------------------------------------------------------------------------------------------------------


def last(told: Told) -> Snapshot:
    text = json.dumps({**told, "output": {"snapshot_interval": told["end_time"], "fields": ["velocity", "pressure"]}}, indent=1)
    name = "metamorphic-" + hashlib.sha256(text.encode()).hexdigest()[:16]
    path = BUILD / "validate" / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return run_file(path, name).last(len(told["fluids"]))


def apart(a: Snapshot, b: Snapshot, names_a: Sequence[str], names_b: Sequence[str], period: float = 0) -> float:
    """The largest difference, infinite where particles have no partner of their own. period: of both directions; 0: not periodic."""
    from scipy.spatial import cKDTree  # python3-scipy

    worst = 0.0
    for name in names_a:
        mine, its = a.phase == names_a.index(name), b.phase == names_b.index(name)
        if mine.sum() != its.sum():
            return np.inf
        x, y = (q[:, :2] % period % period if period else q for q in (a.x[mine], b.x[its]))
        away, partner = cKDTree(y, boxsize=period or None).query(x)
        if len(set(partner)) != len(partner):
            return np.inf
        worst = max(worst, float(away.max()))
        for of in ("velocity", "pressure"):
            one, other = getattr(a, of)[mine], getattr(b, of)[its][partner]
            scale = np.abs(getattr(a, of)).max()
            worst = max(worst, float(np.abs(one - other).max() / scale))
    return worst


def names(told: Told) -> list[str]:
    return [fluid["name"] for fluid in told["fluids"]]


def bound(relation: str, scheme: str) -> float:
    if relation.startswith("units"):
        return 1e-13 if scheme == "incompressible" else 0
    if relation.startswith(("fluids", "the tank")):
        return 1e-4 if scheme == "differences" else 0
    if relation.startswith(("shift", "the plane")):
        return 1e-4
    return 1e-4 if scheme == "differences" else 1e-7


def metamorphic(paper: bool) -> Iterator[Metric]:
    case = "metamorphic"
    for scheme in SCHEMES:
        for flow, make in FLOWS.items():
            told = make(scheme)
            here = last(told)
            found: dict[str, float] = {}
            for relation, changes in CHANGES.items():
                found[relation] = max(apart(here, change.back(last(change(told))), names(told), names(told)) for change in changes)
            if flow == "full":
                other = order(told)
                found["fluids in another order"] = apart(here, last(other), names(told), names(other))
            else:
                found["the tank told in four ways"] = max(apart(here, last(other), names(told), names(told)) for other in sides(told))
                found["the plane in space, endless along z"] = extruded(scheme, False)
            for relation, value in found.items():
                yield Metric(case, f"{scheme}, {flow}: {relation}", value, high=bound(relation, scheme))
            for relation, (difference, most) in OTHERS.items():
                if difference is split and scheme == "differences" and flow == "full":
                    continue  # which is for two fluids at most
                yield Metric(case, f"{scheme}, {flow}: {relation}", difference(scheme, flow == "full"), high=most)

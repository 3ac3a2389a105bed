# SPDX-License-Identifier: BSD-3-Clause
"""Flows that metamorphic.py tells twice, and the ways of telling them: in other units, mirrored, turned, moved, with fluids in another order, their tank
in other words."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from validation import measures
from validation.measures import Seen, Told
from validation.runs import Snapshot

SIZE, END = 20, 0.05  # particles along the box; [s]: some fifty steps of sound
SOUND = ("riemann", "dissipation", "interfacial")  # schemes that follow it; they alone have free surfaces

# Options of the plain flow and, besides, of the full one.
FILL = {"reference_speed": 1}
SCHEMES: dict[str, Told] = {"riemann": {}, "dissipation": {}, "interfacial": {}, "incompressible": FILL, "differences": FILL}
FEATURES: dict[str, Told] = {
    "riemann": {"background_pressure": 4, "heavy_background_pressure": 0.5, "transport_stress": True},
    "dissipation": {"repulsion": 0.04, "background_pressure": 256, "gradient_correction": True},
    "interfacial": {"repulsion": 0.04, "background_pressure": 256, "gradient_correction": True},
    "incompressible": {"gauge": "mean", "mobility": "unit"},
    "differences": {"diffusion": "conservative", "buoyant_in": "oil", "zero_pressure": [0.81, 0.34]},
}


# --- flows -------------------------------------------------------------------------------------------------------------------


def names(told: Told) -> list[str]:
    return [fluid["name"] for fluid in told["fluids"]]


def tank(lower: Sequence[float], upper: Sequence[float]) -> list[Told]:
    return [{"outside": True, "box": {"min": list(lower), "max": list(upper)}}]


def side(point: Sequence[float], normal: Sequence[float]) -> Told:
    return {"half_space": {"point": list(point), "normal": list(normal)}}


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
        "probes": measures.of_all("1024*(1-y)"),
    }  # fmt: skip


def pair(scheme: str) -> Told:
    """With a drop in it, for what needs two fluids."""
    told = plain(scheme)
    told["fluids"].append({"name": "oil", "density": 512, "viscosity": 1, "sound_speed": 16, "velocity": ["0", "0"],
                           "shape": [{"ball": {"centre": [0.375, 0.45], "radius": 0.22}}]})  # fmt: skip
    told["probes"] += measures.of_drop("oil")
    return told


def full(scheme: str) -> Told:
    """All at once that the scheme has: two liquids of other viscosities and sounds, and a gas where it may be a third fluid, with tension; a tank they
    stick to, a lid that runs, a body on its way past which they slip; gravity that changes; rows of particles that are no lattice."""
    told = plain(scheme)
    told["domain"]["displacement"] = ["0.002*sin(2*pi*x)*sin(4*pi*y)", "-0.002*cos(2*pi*x)*sin(2*pi*y)^2"]
    told["gravity"] = ["0.25*sin(40*t)", "-1 - 0.25*sin(30*t)"]
    stirred = ["0.5*sin(pi*x)^2*sin(2*pi*y/0.75)", "-0.375*sin(2*pi*x)*sin(pi*y/0.75)^2"]
    gas = scheme != "differences"
    told["fluids"] = [
        {"name": "water", "density": 1024, "viscosity": 1, "sound_speed": 16, "pressure": "1024*(0.75-y)",
         "velocity": stirred if gas else told["fluids"][0]["velocity"]},
        {"name": "oil", "density": 512, "viscosity": 4, "sound_speed": 16 if scheme == "dissipation" else 8, "velocity": stirred,
         "pressure": "1024*(0.75-y)", "shape": [{"ball": {"centre": [0.375, 0.4], "radius": 0.2}}]},
    ]  # fmt: skip
    told["interfaces"] = [{"between": ["water", "oil"], "tension": 8}]
    if gas:
        light = 128 if scheme == "incompressible" else 2  # of which this scheme holds tension up to a ratio of 10
        told["fluids"].append({"name": "gas", "density": light, "viscosity": 0.0625, "sound_speed": 16, "velocity": ["0", "0"],
                               "shape": [side([0, 0.75], [0, -1])]})  # fmt: skip
        told["interfaces"].append({"between": ["water", "gas"], "tension": 4})
    if scheme == "riemann":
        told["interfaces"] = []
    above = {"operation": "subtract", **side([0, 1], [0, -1])}
    told["walls"] = [
        {"name": "tank", "slip": "none", "shape": [*tank([0, 0], [1, 2]), above]},
        {"name": "lid", "slip": "none", "shape": [side([0, 1], [0, -1])], "surface_velocity": ["1 + 0.5*sin(40*t)", "0"]},
        {"name": "body", "shape": [{"ball": {"centre": [0.7, 0.3], "radius": 0.0875}}], "motion": setting_out([0.2, 0.1])},
    ]  # fmt: skip
    told["scheme"] = {scheme: SCHEMES[scheme] | FEATURES[scheme]}
    told["probes"] += measures.of_drop("oil")
    return told


def setting_out(v: Sequence[float]) -> Told:
    """From rest to this velocity at the end, and on."""
    points = [(0, 0, 0), (END, END / 2, 1), (2 * END, 1.5 * END, 1)]
    return {"table": {"points": [{"t": t, "x": [x * u for u in v], "v": [share * u for u in v]} for t, x, share in points]}}


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
        return list((self.length * self.turn @ np.asarray(x, float) + self.shift).tolist())

    def arrow(self, v: Sequence[float], unit: float) -> list[float]:
        return list((unit * self.turn @ np.asarray(v, float)).tolist())

    def axis(self, old: int) -> tuple[int, float]:
        """Which axis it becomes, and its sign."""
        new = int(np.argmax(np.abs(self.turn[:, old])))
        return new, self.turn[new, old]

    def box(self, told: Told) -> Told:
        a, b = self.point(told["min"]), self.point(told["max"])
        return {"min": np.minimum(a, b).tolist(), "max": np.maximum(a, b).tolist()}

    def old(self, text: str) -> str:
        """A formula of the old places, of the new ones."""
        back = {}
        for k, name in enumerate("xy"):
            j, sign = self.axis(k)
            back[name] = f"({sign:g}*({'xy'[j]}-({self.shift[j]:.17g}))/{self.length:.17g})"
        back["t"] = f"(t/{self.time:.17g})"
        return re.sub(r"\b[xyt]\b", lambda m: back[m[0]], text)

    def number(self, text: str, unit: float) -> str:
        return f"{unit:.17g}*({self.old(text)})"

    def vector(self, told: Sequence[str], unit: float) -> list[str]:
        new = []
        for row in self.turn:
            j = int(np.argmax(np.abs(row)))
            new.append(self.number(told[j], row[j] * unit))
        return new

    def part(self, told: Told) -> Told:
        new = dict(told)
        if "box" in told:
            new["box"] = self.box(told["box"])
        if "ball" in told:
            new["ball"] = {"centre": self.point(told["ball"]["centre"]), "radius": self.length * told["ball"]["radius"]}
        if "half_space" in told:
            new["half_space"] = {"point": self.point(told["half_space"]["point"]), "normal": self.arrow(told["half_space"]["normal"], 1)}
        return new

    def motion(self, told: Told) -> Told:
        L, T = self.length, self.time
        if "table" in told:
            points = [{"t": T * p["t"], "x": self.arrow(p["x"], L), "v": self.arrow(p["v"], L / T)} for p in told["table"]["points"]]
            return {"table": {"points": points}}
        return {kind: {**how, "amplitude": self.arrow(how["amplitude"], L), "frequency": how["frequency"] / T} for kind, how in told.items()}

    def probe(self, told: Told) -> Told | None:
        """None where it has no counterpart: the way up a line that is turned over leads down."""
        kind = measures.kind_name(told)
        options = copy.deepcopy(told[kind])
        new, sign = self.axis("xy".index(options.get("axis", options.get("vertical", "y"))))
        if kind == "elevation" and sign < 0:
            return None
        if kind == "pressure":
            options["at"] = self.point(options["at"])
        elif "at" in options:
            options["at"] = [self.point([options["at"][0], 0])[1 - new]]
        for key in ("axis", "vertical"):
            if key in options:
                options[key] = "xy"[new]
        if kind == "extent" and sign < 0:
            options["which"] = {"max": "min", "min": "max"}[options["which"]]
        if kind == "front" and sign < 0:
            options["backwards"] = not options.get("backwards", False)
        if "within" in options:
            options["within"] = self.box(options["within"])
        if "margin" in options:
            options["margin"] *= self.length
        if "from" in options:
            options["from"] = self.number(options["from"], self.mass / (self.length * self.time**2))
        return {"name": told["name"], kind: options}

    def fluid(self, told: Told) -> Told:
        L, T, M = self.length, self.time, self.mass
        new = told | {"density": told["density"] * M / L**3, "viscosity": told["viscosity"] * M / (L * T), "sound_speed": told["sound_speed"] * L / T,
                      "velocity": self.vector(told["velocity"], L / T)}  # fmt: skip
        if "pressure" in told:
            new["pressure"] = self.number(told["pressure"], M / (L * T**2))
        if "shape" in told:
            new["shape"] = [self.part(part) for part in told["shape"]]
        return new

    def wall(self, told: Told) -> Told:
        new = told | {"shape": [self.part(part) for part in told["shape"]]}
        if "surface_velocity" in told:
            new["surface_velocity"] = self.vector(told["surface_velocity"], self.length / self.time)
        if "motion" in told:
            new["motion"] = self.motion(told["motion"])
        return new

    def options(self, scheme: str, told: Told) -> Told:
        new = dict(told)
        if "reference_speed" in told:
            new["reference_speed"] = told["reference_speed"] * self.length / self.time
        if "background_pressure" in told and scheme != "riemann":  # of riemann it is over rho c^2
            new["background_pressure"] = told["background_pressure"] * self.mass / (self.length * self.time**2)
        if "zero_pressure" in told:
            new["zero_pressure"] = self.point(told["zero_pressure"])
        return new

    def __call__(self, told: Told) -> Told:
        new = copy.deepcopy(told)
        L, T, M = self.length, self.time, self.mass
        new["reference_length"] = L * told.get("reference_length", 1)
        new["domain"] |= self.box(told["domain"])
        if "displacement" in told["domain"]:
            new["domain"]["displacement"] = self.vector(told["domain"]["displacement"], L)
        if "periodic" in told["domain"]:
            new["domain"]["periodic"] = ["xy"[self.axis("xy".index(axis))[0]] for axis in told["domain"]["periodic"]]
        new["gravity"] = self.vector(told["gravity"], L / T**2)
        new["fluids"] = [self.fluid(fluid) for fluid in told["fluids"]]
        new["walls"] = [self.wall(wall) for wall in told["walls"]]
        new["interfaces"] = [{**between, "tension": between["tension"] * M / T**2} for between in told.get("interfaces", [])]
        new["scheme"] = {key: self.options(key, how) if isinstance(how, dict) else how for key, how in told["scheme"].items()}
        new["end_time"] *= T
        new["probes"] = [probe for probe in map(self.probe, told["probes"]) if probe]
        return new

    def back(self, seen: Seen, told: Told) -> Seen:
        """What is seen there, as it would be here. told: the flow as it is told here."""
        s, L, T, M = seen.snapshot, self.length, self.time, self.mass

        assert s.pressure is not None and s.density is not None and s.volume is not None

        def arrows(there: np.ndarray | None, unit: float) -> np.ndarray:
            assert there is not None
            here = np.zeros_like(there)
            here[:, :2] = there[:, :2] @ self.turn / unit
            return here

        x = arrows(s.x - [*self.shift, 0], L)
        here = Snapshot(s.t / T, s.spacing / L, x, s.phase, s.pressure * (L * T**2 / M), s.density * (L**3 / M), arrows(s.velocity, L / T),
                        arrows(s.acceleration, L / T**2), s.volume / L**2)  # fmt: skip
        values = {probe["name"]: self.value(probe, seen, told) for probe in told["probes"] if probe["name"] in seen.probes}
        return Seen(here, values)

    def value(self, probe: Told, seen: Seen, told: Told) -> float:
        kind, value = measures.kind_name(probe), seen.probes[probe["name"]]
        options = probe[kind]
        new, sign = self.axis("xy".index(options.get("axis", options.get("vertical", "y"))))
        if kind in ("mass_centre", "extent", "front", "elevation"):
            value -= self.shift[new]
        if kind in ("mass_centre", "extent", "front", "elevation", "velocity", "momentum"):
            value *= sign
        if kind == "potential_energy":  # which is counted from the origin
            gravity = np.array([at(formula, told["end_time"]) for formula in told["gravity"]]) @ self.turn.T * self.length / self.time**2
            mass = seen.probes[f"mass-{options['fluid']}" if "fluid" in options else "mass"]
            value += mass * gravity @ self.shift
        return value / measures.kind_of(probe).unit(self.mass, self.length, self.time)


def at(formula: str, t: float) -> float:
    """The value of one of our own formulas of the time."""
    return float(eval(formula.replace("^", "**"), {"sin": np.sin, "cos": np.cos, "pi": np.pi, "t": t}))  # noqa: S307


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
    """The tank as half spaces, as boxes, as everything less its inside, and in two pieces; a lid above it stays as it is."""
    lid = any(wall["name"] == "lid" for wall in told["walls"])
    above = [{"operation": "subtract", **side([0, 1], [0, -1])}] if lid else []
    planes = [([0, 0], [1, 0]), ([1, 0], [-1, 0]), ([0, 0], [0, 1]), ([0, 1], [0, -1])]

    def tanks(*shapes: list[Told]) -> Told:
        walls = []
        for wall in told["walls"]:
            walls += [wall | {"name": f"tank-{k}", "shape": shape} for k, shape in enumerate(shapes)] if wall["name"] == "tank" else [wall]
        return {**told, "walls": walls}

    yield tanks([*(side(point, normal) for point, normal in planes), *above])
    yield tanks([*({"box": {"min": a, "max": b}} for a, b in (([-9, -9], [0, 9]), ([1, -9], [9, 9]), ([-9, -9], [9, 0]), ([-9, 1], [9, 9]))), *above])
    yield tanks([{"box": {"min": [-9, -9], "max": [9, 9]}}, {"operation": "subtract", "box": {"min": [0, 0], "max": [1, 1]}}, *above])
    whole = next(wall["shape"] for wall in told["walls"] if wall["name"] == "tank")
    yield tanks(*([*whole, {"operation": "subtract", **side([0.5, 0], normal)}] for normal in ([-1, 0], [1, 0])))


# --- the same for who moves --------------------------------------------------------------------------------------------------

Path = Callable[[float], tuple[np.ndarray, np.ndarray]]  # place and velocity at a time


def carried(told: Told, path: Path, times: Sequence[float]) -> Told:
    """All walls go this way besides, by points of a table: exact at these times, and in between where it is cubic."""
    new = copy.deepcopy(told)
    for wall in new["walls"]:
        own = wall["motion"]["table"]["points"] if "motion" in wall else []
        points = []
        for t in times:
            (x, v), mine = path(t), own_motion(own, t)
            points.append({"t": t, "x": (x + mine[0]).tolist(), "v": (v + mine[1]).tolist()})
        wall["motion"] = {"table": {"points": points}}
    return new


def own_motion(points: Sequence[Told], t: float) -> tuple[np.ndarray, np.ndarray]:
    """By a table that begins at rest: place and velocity at a time not after its last."""
    if not points or t <= points[0]["t"]:
        return np.zeros(2), np.zeros(2)
    a, b = next((a, b) for a, b in pairwise(points) if t <= b["t"])
    h = b["t"] - a["t"]
    s = (t - a["t"]) / h
    xa, va, xb, vb = (np.array(p[key], float) for p in (a, b) for key in ("x", "v"))
    x = (1 + 2 * s) * (1 - s) ** 2 * xa + s * (1 - s) ** 2 * h * va + s**2 * (3 - 2 * s) * xb + s**2 * (s - 1) * h * vb
    v = 6 * s * (s - 1) / h * (xa - xb) + (1 - s) * (1 - 3 * s) * va + s * (3 * s - 2) * vb
    return x, v

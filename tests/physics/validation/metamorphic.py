# SPDX-License-Identifier: BSD-3-Clause
"""What must come out the same when the same flow is told in another way: in other units, mirrored, turned, moved, seen by who moves, with its fluids
in another order. No reference is needed, and no scheme may know the difference.

Each row is the largest difference of the fields at the end over their largest value, of places over the size of the box; particles of the two
runs are matched by their places, those of a fluid among themselves."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from validation.metrics import Metric
from validation.retelling import CHANGES, END, FLOWS, SCHEMES, Change, Told, full, names, order, plain, sides, tank
from validation.runs import BUILD, Snapshot, run_file

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


def with_short_steps(told: Told) -> Told:
    """Schemes that project are of first order in the time step, and their step depends on the speed, which differs between frames."""
    for scheme, options in told["scheme"].items():
        if "reference_speed" in options:
            told["scheme"] = {scheme: options, "cfl": 0.05}
    return told


def moving_frame(scheme: str, drop: bool) -> float:
    told, U = with_short_steps(endless(scheme, drop)), (1.0, 0.5)
    other = copy.deepcopy(told)
    for fluid in other["fluids"]:
        fluid["velocity"] = [f"{u} + {text}" for u, text in zip(U, fluid["velocity"], strict=True)]
    here, there = last(told), view(last(other), x=[END * u for u in U], v=U)
    for s in (here, there):
        s.pressure = s.pressure - s.pressure.mean()  # a constant means nothing where nothing is open
    return apart(here, there, names(told), names(told), period=1)


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
    told = with_short_steps(full(scheme) if drop else plain(scheme))
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
    deep = 8 / told["resolution"]
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


def bound(relation: str, scheme: str) -> float:
    if relation.startswith("units"):
        return 1e-13 if scheme == "incompressible" else 0
    if relation.startswith(("fluids", "the tank")):
        return 1e-4 if scheme == "differences" else 0
    if relation.startswith(("shift", "the plane")):
        return 1e-4
    return 1e-4 if scheme == "differences" else 1e-7


SOUND = ("riemann", "dissipation", "interfacial")
KERNEL = "the 3D kernel integrated along a line is not the 2D kernel"
WIDER: dict[str, tuple[tuple[tuple[str, ...], float, str], ...]] = {
    "the plane in space, endless along z": (
        (SOUND, 0.02, f"{KERNEL}: 0.010 to 0.014 with 20 particles along a side, 0.009 to 0.010 with 40"),
        (("incompressible",), 0.002, f"{KERNEL}, presumably: 0.0009 with 20 particles along a side, 0.0017 with 40"),
        (("differences",), 0.006, f"{KERNEL}, presumably: 0.0045 with 20, 0.0021 with 40"),
    ),
    "seen from a moving frame": (
        (("incompressible",), 0.05, "a projection leaves some of the divergence to the next: velocities differ by 0.004 at most, pressures of single particles by 0.042"),
    ),
}  # fmt: skip


def scored(scheme: str, flow: str, relation: str, value: float, high: float) -> Metric:
    """By the bound that is asked for, or a wider one with its cause."""
    for schemes, wider, cause in WIDER.get(relation, ()):
        if scheme in schemes:
            return Metric("metamorphic", f"{scheme}, {flow}: {relation} (asked: {high:g}; {cause})", value, high=wider)
    return Metric("metamorphic", f"{scheme}, {flow}: {relation}", value, high=high)


def metamorphic(paper: bool) -> Iterator[Metric]:
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
                yield scored(scheme, flow, relation, value, bound(relation, scheme))
            for relation, (difference, most) in OTHERS.items():
                if difference is split and scheme == "differences" and flow == "full":
                    continue  # which is for two fluids at most
                yield scored(scheme, flow, relation, difference(scheme, flow == "full"), most)

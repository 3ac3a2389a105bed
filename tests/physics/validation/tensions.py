# SPDX-License-Identifier: BSD-3-Clause
"""Surface tension against exact answers: curvatures, drops at rest, ripples, drops that swing; each under all schemes that have tension."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from validation import jobs
from validation.capillary import drop_damping, drop_frequency, standing_wave
from validation.made import made, written
from validation.metrics import Metric
from validation.runs import BUILD, Run, Snapshot

# What each is allowed: jump, over Laplace's; speed times viscosity over tension at ratio 1; root mean square of a ripple, over its height, at 16, 32, 64 spacings.
SCHEMES = {
    "dissipation": (0.01, 5e-4, (0.03, 0.015, 0.008)),
    "interfacial": (0.01, 5e-4, (0.05, 0.02, 0.02)),
    "incompressible": (0.01, 1e-3, (0.03, 0.015, 0.008)),
    "differences": (0.02, 3e-3, (0.08, 0.08, 0.08)),
}
PROJECTS = ("incompressible", "differences")


def options(scheme: str, speed: float, background: float) -> dict:
    """By the rules of schemes/README.md. speed: of the flow [m/s]; background: half of rho c^2/exponent of the softest fluid [Pa]."""
    if scheme in PROJECTS:
        return {scheme: {"reference_speed": speed}}
    if scheme == "dissipation":
        return {scheme: {"background_pressure": background, "pair_average": "density", "repulsion": 0}}
    return {scheme: {"background_pressure": background}}


# --- curvature ----------------------------------------------------------------------------------------------------------------


# Of the lattice's cells, where the middle of a body is: means over these tell more than one.
PLACES = ((0.13, 0.07, 0.03), (0.31, 0.44, 0.19), (0.49, 0.22, 0.37), (0.02, 0.35, 0.28))


def round_body(scheme: str, dim: int, across: int, disorder: float, place: tuple[float, ...]) -> dict:
    """A body of radius 1, and as much around it as it feels."""
    side = 1 + 6 / across
    low, high = [-side] * dim, [side] * dim
    return {
        "dimensions": dim, "reference_length": 1, "resolution": across, "domain": {"min": low, "max": high, "disorder": disorder},
        "fluids": [
            {"name": "body", "density": 1, "sound_speed": 10, "shape": [{"ball": {"centre": [x / across for x in place[:dim]], "radius": 1}}]},
            {"name": "around", "density": 1, "sound_speed": 10},
        ],
        "interfaces": [{"between": ["body", "around"], "tension": 1}],
        "walls": [{"name": "box", "slip": "free", "shape": [{"outside": True, "box": {"min": low, "max": high}}]}],
        "scheme": options(scheme, 0.3, 0), "end_time": 1, "output": {"probe_interval": 1},
    }  # fmt: skip


def curvature_of(scheme: str, dim: int, across: int, disorder: float) -> tuple[float, float]:
    """Mean and standard deviation over the pairs across the surface, over (dim - 1)/R; means of the places."""
    found = []
    for place in PLACES:
        path = written(f"curvature-{scheme}", round_body(scheme, dim, across, disorder, place))
        with jobs.program([str(BUILD / "tests/physics/curvature"), str(path)], stdout=subprocess.PIPE, text=True) as process:
            found.append([float(x) for x in process.communicate()[0].split()])
    mean, deviation = np.mean(found, axis=0)
    return float(mean), float(deviation)


def curvature(paper: bool) -> Iterator[Metric]:
    """Of circles and balls as they start, cut from a lattice, and from one in disorder."""
    case = "curvature"
    for scheme in SCHEMES:
        for dim, sizes in ((2, (5, 10, 20, 40)), (3, (5, 10, 20) if paper else (5, 10))):
            off = {}
            for across in sizes:
                for disorder in (0, 0.05):
                    mean, deviation = curvature_of(scheme, dim, across, disorder)
                    where = f"{scheme}, {dim} dimensions, R = {across} dx{', in disorder' if disorder else ''}: curvature over (dim - 1)/R"
                    off[across, disorder] = abs(mean - 1)
                    scored = 10 <= across <= (20 if disorder else 40)
                    yield Metric(case, where, mean, 1, 0.02) if scored else Metric(case, where, mean)
                    yield Metric(case, f"{where}, standard deviation", deviation)
            order = float(np.log2(off[5, 0] / max(off[10, 0], 1e-6)))
            yield Metric(case, f"{scheme}, {dim} dimensions: order of convergence from R = 5 to 10 dx", order)


# --- a drop at rest -----------------------------------------------------------------------------------------------------------


OFF = (0.013, 0.007)  # of a radius, off the lattice's symmetry


def resting(scheme: str, La: float, ratio: float, across: int, centre: tuple[float, float] = (0, 0)) -> tuple[dict, float]:
    """A drop of radius 1 and tension 1 in a periodic box of 2.5 radii; what is around it is `ratio` times as light and as viscous. Returns the viscosity too."""
    mu = float(np.sqrt(2 / La))
    sound = [10.0, max(10.0 if ratio == 1 else 0.0, 0.6 * float(np.sqrt(ratio)))]
    softest = min(sound[0] ** 2, sound[1] ** 2 / ratio) / 7
    return {
        "dimensions": 2, "reference_length": 1, "resolution": across,
        "domain": {"min": [-1.25, -1.25], "max": [1.25, 1.25], "periodic": ["x", "y"]},
        "fluids": [
            {"name": "drop", "density": 1, "viscosity": mu, "sound_speed": sound[0], "pressure": "laplace", "shape": [{"ball": {"centre": list(centre), "radius": 1}}]},
            {"name": "around", "density": 1 / ratio, "viscosity": mu / ratio, "sound_speed": sound[1]},
        ],
        "interfaces": [{"between": ["drop", "around"], "tension": 1}],
        "scheme": options(scheme, 0.3, 0.5 * softest), "end_time": 8,
        "probes": [
            {"name": "jump", "pressure_jump": {"inside": "drop"}},
            {"name": "volume", "volume": {"fluid": "drop"}},
            {"name": "x", "mass_centre": {"fluid": "drop", "axis": "x"}}, {"name": "y", "mass_centre": {"fluid": "drop", "axis": "y"}},
            {"name": "inside", "extremum": {"field": "velocity", "fluid": "drop"}}, {"name": "outside", "extremum": {"field": "velocity", "fluid": "around"}},
        ],
        "output": {"probe_interval": 0.05},
    }, mu  # fmt: skip


def score_resting(scheme: str, La: float, ratio: float, across: int, centre: tuple[float, float] = (0, 0)) -> Iterator[Metric]:
    off = ", off the lattice" if centre == OFF else ""
    case, where = "drop-at-rest", f"{scheme}, La {La:g}, ratio {ratio:g}, {across} to the radius{off}: "
    setup, mu = resting(scheme, La, ratio, across, centre)
    r = made(f"{case}-{scheme}-{La:g}-{ratio:g}-{across}{'-off' if off else ''}", setup)
    if r is None:
        yield Metric(case, f"{where}runs that came to their end", 0, low=1)
    else:
        yield from score_rest(case, where, scheme, ratio, across, mu, r)


def score_rest(case: str, where: str, scheme: str, ratio: float, across: int, mu: float, r: Run) -> Iterator[Metric]:
    """Over the last half."""
    of_jump, of_speed, _ = SCHEMES[scheme]
    late = r.t > 4
    due = 1 / np.sqrt(np.mean(r.probes["volume"][late]) / np.pi)  # Laplace's, of the drop's own radius
    yield Metric(case, f"{where}jump of the pressure, over Laplace's of its own radius", r.mean("jump", 4, 8) / due, 1, 0.015 if ratio > 1 and of_jump < 0.02 else of_jump)
    inside, outside = (float(np.max(r.probes[name][late])) * mu for name in ("inside", "outside"))
    yield Metric(case, f"{where}largest speed in the drop, times viscosity over tension", inside, high=1e-3 if ratio > 1 else of_speed)
    yield Metric(case, f"{where}largest speed around it, times the drop's viscosity over tension", outside, high=5e-3 if ratio > 1 else of_speed)
    drift = np.hypot(r.probes["x"] - r.probes["x"][0], r.probes["y"] - r.probes["y"][0])
    yield Metric(case, f"{where}drift [spacings]", float(np.max(drift)) * across, high=0.02)


def drop_at_rest(paper: bool) -> Iterator[Metric]:
    """From the middle of a lattice, where what is wrong on one side is so on the other too; and from a start without symmetry, which shows how far a drop goes as its
    curvatures are not that of a closed surface."""
    for scheme in SCHEMES:
        for across in (16, 32) if paper else (16,):
            for La in (12, 1200, 120000):
                yield from score_resting(scheme, La, 1, across)
            for La in (12, 1200, 12000, 120000) if paper else (12000,):
                yield from score_resting(scheme, La, 1000, across)
            yield from score_resting(scheme, 1200, 1, across, OFF)


# --- a drop on a floor --------------------------------------------------------------------------------------------------------


def standing(scheme: str, across: int) -> dict:
    """Half a drop of radius and tension 1 on a floor where fluid sticks, in a gas a tenth as dense and as viscous. It begins with the angle that it is to keep."""
    low, high = [-2, 0], [2, 2]
    background = {"dissipation": 4, "interfacial": 2}.get(scheme, 0)
    return {
        "dimensions": 2, "reference_length": 1, "resolution": across, "domain": {"min": low, "max": high},
        "fluids": [
            {"name": "drop", "density": 1, "viscosity": 0.2, "sound_speed": 10, "shape": [{"ball": {"centre": [0, 0], "radius": 1}}]},
            {"name": "gas", "density": 0.1, "viscosity": 0.02, "sound_speed": 10},
        ],
        "interfaces": [{"between": ["drop", "gas"], "tension": 1}],
        "walls": [{"name": "box", "slip": "none", "shape": [{"outside": True, "box": {"min": low, "max": high}}]}],
        "scheme": options(scheme, 0.5, background), "end_time": 6,
        "probes": [
            {"name": "right", "extent": {"fluid": "drop", "axis": "x"}}, {"name": "left", "extent": {"fluid": "drop", "axis": "x", "which": "min"}},
            {"name": "top", "extent": {"fluid": "drop", "axis": "y"}},
        ],
        "output": {"probe_interval": 0.05},
    }  # fmt: skip


def score_standing(case: str, where: str, across: int, r: Run) -> Iterator[Metric]:
    """Over the last half: the angle of the circle that is as high and as wide, whatever the spacing."""
    wide, high = 0.5 * (r.mean("right", 3, 6) - r.mean("left", 3, 6)), r.mean("top", 3, 6)
    yield Metric(case, f"{where}angle of contact [degrees]", float(np.degrees(2 * np.arctan2(high, wide))), 90, 3)


def each(case: str, schemes: Iterable[str], sizes: Iterable[int], setup: Callable[[str, int], dict],
         score: Callable[[str, str, int, Run], Iterator[Metric]]) -> Iterator[Metric]:  # fmt: skip
    """The metrics of a case under each scheme with so many particles to the radius, or that it did not come to its end."""
    for scheme in schemes:
        for across in sizes:
            where = f"{scheme}, {across} to the radius: "
            r = made(f"{case}-{scheme}-{across}", setup(scheme, across))
            yield from score(case, where, across, r) if r else [Metric(case, f"{where}runs that came to their end", 0, low=1)]


def drop_on_floor(paper: bool) -> Iterator[Metric]:
    yield from each("drop-on-floor", SCHEMES, (8, 16) if paper else (8,), standing, score_standing)


# --- a lens -------------------------------------------------------------------------------------------------------------------

# Of the area of a circle of radius 1 between two liquids, all three tensions alike: two segments whose arcs meet their chord at 60 degrees.
LENS_ARC = float(np.sqrt(np.pi / (2 * (np.pi / 3 - np.sqrt(3) / 4))))
LENS_WIDE, LENS_HIGH = LENS_ARC * np.sqrt(3) / 2, LENS_ARC / 2


def floating(scheme: str, across: int) -> dict:
    """A round drop between two liquids that are as it is, which becomes a lens."""
    ends = [{"half_space": {"point": [0, -2.5], "normal": [0, 1]}}, {"half_space": {"point": [0, 2.5], "normal": [0, -1]}}]
    fluids = [{"name": name, "density": 1, "viscosity": 0.3, "sound_speed": 10} for name in ("lens", "below", "above")]
    fluids[0]["shape"] = [{"ball": {"centre": [0, 0], "radius": 1}}]
    fluids[1]["shape"] = [{"formula": "y < 0 and x^2 + y^2 >= 1"}]
    return {
        "dimensions": 2, "reference_length": 1, "resolution": across, "domain": {"min": [-4, -2.5], "max": [4, 2.5], "periodic": ["x"]}, "fluids": fluids,
        "interfaces": [{"between": pair, "tension": 1} for pair in (["lens", "below"], ["lens", "above"], ["below", "above"])],
        "walls": [{"name": "ends", "shape": ends}], "scheme": options(scheme, 0.5, {"dissipation": 4, "interfacial": 2}.get(scheme, 0)), "end_time": 8,
        "probes": [
            {"name": "volume", "volume": {"fluid": "lens"}},
            *({"name": name, "extent": {"fluid": "lens", "axis": axis, "which": which}}
              for name, axis, which in (("right", "x", "max"), ("left", "x", "min"), ("top", "y", "max"), ("bottom", "y", "min"))),
        ],
        "output": {"probe_interval": 0.1},
    }  # fmt: skip


def score_floating(case: str, where: str, across: int, r: Run) -> Iterator[Metric]:
    """Over the last half, scaled to the circle's area; within a spacing, as the tips are wedges that lattices do not fill."""
    radius = np.sqrt(r.mean("volume", 4, 8) / np.pi)
    for name, low, high, due in (("half its width", "left", "right", LENS_WIDE), ("half its height", "bottom", "top", LENS_HIGH)):
        yield Metric(case, f"{where}{name}", 0.5 * (r.mean(high, 4, 8) - r.mean(low, 4, 8)) / radius, due, 1 / across)


def lens(paper: bool) -> Iterator[Metric]:
    """Where three fluids meet. `differences` has two fluids at most."""
    yield from each("lens", (s for s in SCHEMES if s != "differences"), (8, 16) if paper else (8,), floating, score_floating)


# --- a ripple -----------------------------------------------------------------------------------------------------------------

HEIGHT = 0.01  # of a ripple, over its length


def rippling(scheme: str, spacings: int) -> tuple[dict, float, float]:
    """Of length 1, between liquids alike, La 3000, as S. Popinet's (2009), but from a flat surface that swings through: a lattice cannot begin with a height of a part
    of a spacing. There is no background pressure: two liquids alike do not need it, and it would be 16 times the ripple's own. Returns omega_0 and nu."""
    k, mu = 2 * np.pi, float(np.sqrt(1 / 3000))
    omega = float(np.sqrt(k**3 / 2))
    sound = 10 * float(np.sqrt(k))
    half = 1.5

    def flow(side: int) -> list[str]:
        return [f"{-side * HEIGHT * omega}*sin(2*pi*x)*exp({side * k}*y)", f"{HEIGHT * omega}*cos(2*pi*x)*exp({side * k}*y)"]

    return {
        "dimensions": 2, "reference_length": 1, "resolution": spacings,
        "domain": {"min": [0, -half], "max": [1, half], "periodic": ["x"]},
        "fluids": [
            {"name": "below", "density": 1, "viscosity": mu, "sound_speed": sound, "velocity": flow(1), "shape": [{"half_space": {"point": [0, 0], "normal": [0, 1]}}]},
            {"name": "above", "density": 1, "viscosity": mu, "sound_speed": sound, "velocity": flow(-1)},
        ],
        "interfaces": [{"between": ["below", "above"], "tension": 1}],
        "walls": [{"name": "ends", "slip": "free", "shape": [{"half_space": {"point": [0, -half], "normal": [0, 1]}}, {"half_space": {"point": [0, half], "normal": [0, -1]}}]}],
        "scheme": options(scheme, HEIGHT * omega, 0), "end_time": 25 / omega,
        "probes": [{"name": "crest", "elevation": {"fluids": ["below"], "at": [0]}}, {"name": "trough", "elevation": {"fluids": ["below"], "at": [0.5]}}],
        "output": {"probe_interval": 0.1 / omega},
    }, omega, mu  # fmt: skip


def score_ripple(case: str, where: str, allowed: float, omega: float, nu: float, r: Run) -> Iterator[Metric]:
    """Against A. Prosperetti's solution; the height is half of the difference of crest and trough."""
    mine = 0.5 * (r.probes["crest"] - r.probes["trough"])
    exact = standing_wave(np.maximum(r.t, 1e-9), 2 * np.pi, nu, 1, 1, 1, 0, HEIGHT * omega)
    off = float(np.sqrt(np.mean((mine - mine[0] - exact) ** 2))) / HEIGHT
    yield Metric(case, f"{where}rms distance from Prosperetti's, over the height", off, high=allowed)


def ripple(paper: bool) -> Iterator[Metric]:
    case = "ripple"
    for scheme, (_, _, allowed) in SCHEMES.items():
        for level, spacings in enumerate((16, 32, 64) if paper else (16,)):
            setup, omega, nu = rippling(scheme, spacings)
            r = made(f"{case}-{scheme}-{spacings}", setup)
            where = f"{scheme}, {spacings} to the length: "
            if r is None:
                yield Metric(case, f"{where}runs that came to their end", 0, low=1)
            else:
                yield from score_ripple(case, where, allowed[level], omega, nu, r)


# --- a drop that swings -------------------------------------------------------------------------------------------------------

SWING = 0.05  # height of a swing, over the radius
PERIODS = {2: 4, 3: 1}  # by dimensions


def around(dim: int, n: int, speed: float) -> tuple[list[str], list[str]]:
    """Velocities in and around a round drop of radius 1 that swings through, without vorticity: in the plane u - i v = speed z^(n - 1), and speed/z^(n + 1)
    outside; in space n = 2, of r^2 P2/2 and, outside, -P2/(3 r^3)."""
    if dim == 3:
        r2, form = "max(x^2 + y^2 + z^2, 0.5)", "(z^2 - 0.5*(x^2 + y^2))"
        inside = [f"{-0.5 * speed}*x", f"{-0.5 * speed}*y", f"{speed}*z"]
        side = [f"{speed / 3}*{axis}*(1 + 5*{form}/{r2})/{r2}^2.5" for axis in "xy"]
        return inside, [*side, f"{speed / 3}*z*(-2 + 5*{form}/{r2})/{r2}^2.5"]
    powers = {1: ("x", "y"), 2: ("(x^2 - y^2)", "2*x*y"), 3: ("(x^3 - 3*x*y^2)", "(3*x^2*y - y^3)"), 4: ("(x^4 - 6*x^2*y^2 + y^4)", "(4*x^3*y - 4*x*y^3)")}
    real, imaginary = powers[n - 1]
    out_real, out_imaginary = powers[n + 1]
    far = f"/max(x^2 + y^2, 0.5)^{n + 1}"
    return [f"{speed}*{real}", f"{-speed}*{imaginary}"], [f"{speed}*{out_real}{far}", f"{speed}*{out_imaginary}{far}"]


def swinging(scheme: str, dim: int, n: int, across: int, ratio: float) -> tuple[dict, float, float]:
    """A drop of radius, density and tension 1 in a gas `ratio` times as light and as viscous. It begins round, as a lattice cannot
    begin with a height of a part of a spacing. Returns Lamb's frequency and damping."""
    nu, box = 0.01, 2.5
    omega = drop_frequency(n, dim, 1, 1, 1, 1 / ratio)
    damping = drop_damping(n, dim, nu, omega, 1 / ratio)
    inside, outside = around(dim, n, SWING * omega)
    sound = [20.0, max(10.0, 0.6 * float(np.sqrt(ratio)))]
    low, high = [-box] * dim, [box] * dim
    return {
        "dimensions": dim, "reference_length": 1, "resolution": across, "domain": {"min": low, "max": high},
        "fluids": [
            {"name": "drop", "density": 1, "viscosity": nu, "sound_speed": sound[0], "pressure": "laplace", "velocity": inside, "shape": [{"ball": {"centre": [0] * dim, "radius": 1}}]},
            {"name": "gas", "density": 1 / ratio, "viscosity": nu / ratio, "sound_speed": sound[1], "velocity": outside},
        ],
        "interfaces": [{"between": ["drop", "gas"], "tension": 1}],
        "walls": [{"name": "box", "slip": "none", "shape": [{"outside": True, "box": {"min": low, "max": high}}]}],
        "scheme": options(scheme, 0.2, 0.5 * sound[1] ** 2 / ratio / 7), "end_time": PERIODS[dim] * 2 * np.pi / omega,
        "probes": [{"name": "kinetic", "kinetic_energy": {"fluid": "drop"}}], "output": {"probe_interval": 0.1 / omega, "snapshot_interval": 0.1 / omega, "fields": ["velocity"]},
    }, omega, damping  # fmt: skip


def lobes(s: Snapshot, dim: int, n: int) -> float:
    """How far a drop is drawn out: the mean of r^n cos n theta, in space of r^2 P2. Lattices of squares and of cubes have none of these themselves."""
    x, y, z = (s.x[s.phase == 0] - np.mean(s.x[s.phase == 0], axis=0)).T
    return float(np.mean(z**2 - 0.5 * (x**2 + y**2) if dim == 3 else np.real((x + 1j * y) ** n)))


def found_swing(r: Run, dim: int, n: int) -> tuple[float, float]:
    """Period and damping of the swing, which begins with its greatest speed: the damped sine nearest to it."""
    from scipy.optimize import curve_fit  # python3-scipy

    shots = r.snapshots(2)
    t, height = np.array([s.t for s in shots]), np.array([lobes(s, dim, n) for s in shots])

    def damped(t, size, damping, omega, phase):
        return size * np.exp(-damping * t) * np.sin(omega * t + phase)

    start = (np.max(np.abs(height)), 0.05, drop_frequency(n, dim, 1, 1, 1, 0), 0.0)
    (_, damping, omega, _), _ = curve_fit(damped, t, height, start)
    return 2 * np.pi / float(omega), float(damping)


def score_swing(scheme: str, dim: int, n: int, across: int, ratio: float) -> Iterator[Metric]:
    case, where = "drop-that-swings", f"{scheme}, {dim} dimensions, n = {n}: "
    setup, omega, damping = swinging(scheme, dim, n, across, ratio)
    r = made(f"{case}-{scheme}-{dim}-{n}", setup)
    if r is None:
        yield Metric(case, f"{where}runs that came to their end", 0, low=1)
    else:
        yield from score_swing_of(case, where, scheme, dim, n, omega, damping, r)


def score_swing_of(case: str, where: str, scheme: str, dim: int, n: int, omega: float, damping: float, r: Run) -> Iterator[Metric]:
    period, mine = found_swing(r, dim, n)
    yield Metric(case, f"{where}period", period, 2 * np.pi / omega, 0.02, relative=True)
    note = "not scored: no tolerance is given" if scheme == "differences" else ""
    yield Metric(case, f"{where}damping [1/s]", mine, damping, 0.15 if scheme == "incompressible" else 0.4, relative=True, note=note)


def drop_that_swings(paper: bool) -> Iterator[Metric]:
    for scheme in SCHEMES:
        for n in (2, 3):
            yield from score_swing(scheme, 2, n, 12, 1000)
        if paper:
            yield from score_swing(scheme, 3, 2, 8, 100)

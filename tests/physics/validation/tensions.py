# SPDX-License-Identifier: BSD-3-Clause
"""Surface tension against exact answers: drops at rest, drops that swing, ripples; each under all schemes that have tension."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from validation.capillary import drop_frequency, standing_wave
from validation.made import made
from validation.metrics import Metric
from validation.series import peaks

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


# --- a drop at rest -----------------------------------------------------------------------------------------------------------


def resting(scheme: str, La: float, ratio: float, across: int) -> tuple[dict, float]:
    """A drop of radius 1 and tension 1 in a periodic box of 2.5 radii; what is around it is `ratio` times as light and as viscous. Returns the viscosity too."""
    mu = float(np.sqrt(2 / La))
    sound = [10.0, max(10.0 if ratio == 1 else 0.0, 0.6 * float(np.sqrt(ratio)))]
    softest = min(sound[0] ** 2, sound[1] ** 2 / ratio) / 7
    return {
        "dimensions": 2, "reference_length": 1, "resolution": across,
        "domain": {"min": [-1.25, -1.25], "max": [1.25, 1.25], "periodic": ["x", "y"]},
        "fluids": [
            {"name": "drop", "density": 1, "viscosity": mu, "sound_speed": sound[0], "pressure": "laplace", "shape": [{"ball": {"centre": [0.013, 0.007], "radius": 1}}]},
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


def score_resting(scheme: str, La: float, ratio: float, across: int) -> Iterator[Metric]:
    case, where = "drop-at-rest", f"{scheme}, La {La:g}, ratio {ratio:g}, {across} to the radius: "
    setup, mu = resting(scheme, La, ratio, across)
    r = made(f"{case}-{scheme}-{La:g}-{ratio:g}-{across}", setup)
    if r is None:
        yield Metric(case, f"{where}runs that came to their end", 0, low=1)
        return
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
    for scheme in SCHEMES:
        for across in (16, 32) if paper else (16,):
            for La in (12, 1200, 120000):
                yield from score_resting(scheme, La, 1, across)
            yield from score_resting(scheme, 12000, 1000, across)


# --- a ripple -----------------------------------------------------------------------------------------------------------------

HEIGHT = 0.01  # of a ripple, over its length


def rippling(scheme: str, spacings: int) -> tuple[dict, float, float]:
    """Of length 1, between liquids alike, La 3000, as S. Popinet's (2009), but from a flat surface that swings through: a height of a part of a spacing is none that
    a lattice could begin with. A background pressure, which
    liquids alike do not need, is of 16 times the ripple's own and would be felt. Returns omega_0 and nu."""
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


def ripple(paper: bool) -> Iterator[Metric]:
    """Prosperetti's solution; the height is half of the difference of crest and trough."""
    case = "ripple"
    for scheme, (_, _, allowed) in SCHEMES.items():
        for level, spacings in enumerate((16, 32, 64) if paper else (16,)):
            setup, omega, nu = rippling(scheme, spacings)
            r = made(f"{case}-{scheme}-{spacings}", setup)
            where = f"{scheme}, {spacings} to the length: "
            if r is None:
                yield Metric(case, f"{where}runs that came to their end", 0, low=1)
                continue
            mine = 0.5 * (r.probes["crest"] - r.probes["trough"])
            exact = standing_wave(np.maximum(r.t, 1e-9), 2 * np.pi, nu, 1, 1, 1, 0, HEIGHT * omega)
            yield Metric(case, f"{where}rms distance from Prosperetti's, over the height", float(np.sqrt(np.mean((mine - mine[0] - exact) ** 2))) / HEIGHT, high=allowed[level])


# --- a drop that swings -------------------------------------------------------------------------------------------------------

SWING = 0.05  # height of a swing, over the radius


def around(n: int, speed: float) -> tuple[list[str], list[str]]:
    """Velocities in and around a round drop of radius 1 that swings through, without vorticity: u - i v = speed z^(n - 1), and speed/z^(n + 1) outside."""
    powers = {1: ("x", "y"), 2: ("(x^2 - y^2)", "2*x*y"), 3: ("(x^3 - 3*x*y^2)", "(3*x^2*y - y^3)"), 4: ("(x^4 - 6*x^2*y^2 + y^4)", "(4*x^3*y - 4*x*y^3)")}
    real, imaginary = powers[n - 1]
    out_real, out_imaginary = powers[n + 1]
    far = f"/max(x^2 + y^2, 0.5)^{n + 1}"
    return [f"{speed}*{real}", f"{-speed}*{imaginary}"], [f"{speed}*{out_real}{far}", f"{speed}*{out_imaginary}{far}"]


def swinging(scheme: str, n: int, across: int) -> tuple[dict, float, float]:
    """A drop of radius, density and tension 1 in a gas a thousand times as light. It begins round, as a height of a part of a spacing is none that a lattice could
    begin with. Returns Lamb's frequency and damping."""
    nu, box, ratio = 0.01, 2.5, 1000.0
    omega = drop_frequency(n, 2, 1, 1, 1, 1 / ratio)
    # H. Lamb's of the drop; the boundary layer of the gas adds a hundredth of that
    damping = 2 * n * (n - 1) * nu
    inside, outside = around(n, SWING * omega)
    sound = [20.0, 0.6 * float(np.sqrt(ratio))]
    return {
        "dimensions": 2, "reference_length": 1, "resolution": across, "domain": {"min": [-box, -box], "max": [box, box]},
        "fluids": [
            {"name": "drop", "density": 1, "viscosity": nu, "sound_speed": sound[0], "pressure": "laplace", "velocity": inside, "shape": [{"ball": {"centre": [0, 0], "radius": 1}}]},
            {"name": "gas", "density": 1 / ratio, "viscosity": nu / ratio, "sound_speed": sound[1], "velocity": outside},
        ],
        "interfaces": [{"between": ["drop", "gas"], "tension": 1}],
        "walls": [{"name": "box", "slip": "none", "shape": [{"outside": True, "box": {"min": [-box, -box], "max": [box, box]}}]}],
        "scheme": options(scheme, 0.2, 0.5 * sound[1] ** 2 / ratio / 7), "end_time": 4 * 2 * np.pi / omega,
        "probes": [{"name": "kinetic", "kinetic_energy": {"fluid": "drop"}}],
        "output": {"probe_interval": 0.02 / omega},
    }, omega, damping  # fmt: skip


def drop_that_swings(paper: bool) -> Iterator[Metric]:
    """By the peaks of the kinetic energy, two of them in a period."""
    case = "drop-that-swings"
    for scheme in SCHEMES:
        for n in (2, 3):
            setup, omega, damping = swinging(scheme, n, 12)
            r = made(f"{case}-{scheme}-{n}", setup)
            where = f"{scheme}, n = {n}: "
            t, energy = peaks(r.t, r.probes["kinetic"]) if r else ([], [])
            if len(t) < 4:
                yield Metric(case, f"{where}runs that came to their end", 0, low=1)
                continue
            yield Metric(case, f"{where}period", 2 * float(np.polyfit(np.arange(len(t)), t, 1)[0]), 2 * np.pi / omega, 0.02, relative=True)
            mine = -0.5 * float(np.polyfit(t, np.log(energy), 1)[0])
            yield Metric(case, f"{where}damping", mine, damping, 0.15 if scheme == "incompressible" else 0.4, relative=True)

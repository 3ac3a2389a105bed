# SPDX-License-Identifier: BSD-3-Clause
"""Viscosity where a liquid is free: what it takes from a disc that strains, shears or turns, and from waves under a free surface.

Each has an exact answer of its own: the work of a uniform strain, and the roots of the linear problem of a wave."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from validation.made import made
from validation.metrics import Metric
from validation.runs import Run
from validation.series import peaks

SCHEMES = ("dissipation", "interfacial", "riemann")  # those that have free surfaces

# --- a disc ------------------------------------------------------------------------------------------------------------------

RATE, MU = 1.0, 0.1  # [1/s], [Pa s]; the disc has a radius of 1 m and a density of 1 kg/m^3
STEP = 1e-4  # [s], one step: far below all limits
# Velocity, and the power of the stress over mu A of a disc of the area A.
STRAINS = {
    "stretched": ((f"{RATE}*x", f"{-RATE}*y"), -4 * RATE**2),
    "sheared": ((f"{RATE}*y", "0"), -(RATE**2)),
    "turned": ((f"{-RATE}*y", f"{RATE}*x"), 0.0),
}


def disc(scheme: str, flow: tuple[str, str], mu: float, across: int) -> dict:
    return {
        "dimensions": 2, "reference_length": 1, "resolution": across, "domain": {"min": [-1.5, -1.5], "max": [1.5, 1.5]},
        "fluids": [{"name": "liquid", "density": 1, "viscosity": mu, "sound_speed": 20, "velocity": list(flow), "shape": [{"ball": {"centre": [0, 0], "radius": 1}}]}],
        "scheme": {scheme: {}}, "end_time": STEP,
        "probes": [{"name": "kinetic", "kinetic_energy": {}}, {"name": "volume", "volume": {"fluid": "liquid"}}], "output": {"probe_interval": STEP},
    }  # fmt: skip


def power(scheme: str, name: str, across: int) -> float:
    """Of viscosity alone, over mu and the disc's area: what one step loses more than without it."""
    flow, _ = STRAINS[name]
    with_it, without = (made(f"disc-{scheme}-{name}-{across}-{mu:g}", disc(scheme, flow, mu, across)) for mu in (MU, 0))
    lost = with_it.probes["kinetic"][-1] - without.probes["kinetic"][-1]
    return float(lost / (with_it.t[-1] * MU * with_it.probes["volume"][0]))


def free_disc(paper: bool) -> Iterator[Metric]:
    """First order: pairs that the surface cuts off are missing."""
    case = "free-disc"
    for scheme in SCHEMES:
        for across, allowed in ((20, 0.07), (40, 0.035)):
            for name, (_, due) in STRAINS.items():
                found, where = power(scheme, name, across), f"{scheme}, {name}: power of viscosity over mu A, {across} to the radius"
                yield Metric(case, where, found, due, allowed, relative=True) if due else Metric(case, where, found, 0, 10 * STEP**2)


# --- a wave ------------------------------------------------------------------------------------------------------------------

LENGTH, DEPTH, GRAVITY, STEEP = 1.0, 0.5, 1.0, 0.03  # [m], [m], [m/s^2], height over length
REYNOLDS = (250, 1000)  # sqrt(g L) L/nu
KERNEL = {"riemann": {"smoothing": 1.6}}  # by the table of schemes/README.md, as there is a free surface


def root(nu: float) -> complex:
    """n of exp(n t) of a standing wave of liquid over a floor that it glides along, by the linearized equations: with the stream function sinh m (y + h),
    m^2 = k^2 + n/nu, which takes the shear off the surface,  (n + 2 nu k^2)^2 + g k tanh kh = 4 nu^2 k^3 m tanh kh/tanh mh.
    H. Lamb, Hydrodynamics, art. 349, has it of deep water."""
    k = 2 * np.pi / LENGTH
    shallow = np.tanh(k * DEPTH)

    def residual(n: complex) -> complex:
        m = np.sqrt(k * k + n / nu + 0j)
        return (n + 2 * nu * k * k) ** 2 + GRAVITY * k * shallow - 4 * nu**2 * k**3 * m * shallow / np.tanh(m * DEPTH)

    n, small = complex(-2 * nu * k * k, np.sqrt(GRAVITY * k * shallow)), 1e-6
    for _ in range(50):
        n -= residual(n) * 2 * small / (residual(n + small) - residual(n - small))
    return n


def wave(scheme: str, nu: float, across: int, periods: float) -> dict:
    """Half a length of it, from a flat surface that swings through: a lattice cannot begin with a height of a part of a spacing."""
    k, n = 2 * np.pi / LENGTH, root(nu)
    speed, under = STEEP * n.imag / np.sinh(k * DEPTH), f"{k}*(y + {DEPTH})"
    cosh, sinh = (f"0.5*(exp({under}) {sign} exp(-{under}))" for sign in "+-")
    return {
        "dimensions": 2, "reference_length": LENGTH, "resolution": across, "domain": {"min": [0, -DEPTH], "max": [LENGTH / 2, 0.25 * LENGTH]}, "gravity": [0, -GRAVITY],
        "fluids": [{"name": "water", "density": 1, "viscosity": nu, "sound_speed": 10, "pressure": "hydrostatic",
                    "velocity": [f"{-speed}*sin({k}*x)*({cosh})", f"{speed}*cos({k}*x)*({sinh})"], "shape": [{"half_space": {"point": [0, 0], "normal": [0, 1]}}]}],
        "walls": [{"name": "tank", "slip": "free", "shape": [{"outside": True, "box": {"min": [0, -DEPTH], "max": [LENGTH / 2, LENGTH]}}]}],
        "scheme": {scheme: {}} | KERNEL.get(scheme, {}), "end_time": periods * 2 * np.pi / n.imag,
        "probes": [{"name": "crest", "elevation": {"fluids": ["water"], "at": [0.0]}}, {"name": "trough", "elevation": {"fluids": ["water"], "at": [LENGTH / 2]}},
                   {"name": "centre", "mass_centre": {"fluid": "water", "axis": "y"}}],
        "output": {"probe_interval": 0.02 / n.imag},
    }  # fmt: skip


PERIODS = 4


def swing(r: Run) -> tuple[float, float]:
    """Damping and angular frequency [1/s], from all that follows the first quarter: times and heights of crests and troughs."""
    height = 0.5 * (r.probes["crest"] - r.probes["trough"])
    tops, bottoms = peaks(r.t, height), peaks(r.t, -height)
    t, size = (np.concatenate([a, b]) for a, b in zip(tops, bottoms, strict=True))
    order = np.argsort(t)
    t, size = t[order], size[order]
    large = size > 0.02 * size.max()
    t, size = t[large], size[large]
    return -float(np.polyfit(t, np.log(size), 1)[0]), float(np.pi / np.polyfit(np.arange(len(t)), t, 1)[0])


def score_wave(case: str, where: str, n: complex, r: Run) -> Iterator[Metric]:
    damping, omega = swing(r)
    yield Metric(case, f"{where}damping [1/s]", damping, -n.real, 0.06, relative=True)
    yield Metric(case, f"{where}period [s]", 2 * np.pi / omega, 2 * np.pi / n.imag, 0.015, relative=True)
    level = 2 * (r.mean("centre", 0.75 * r.t[-1], r.t[-1]) - r.probes["centre"][0])
    yield Metric(case, f"{where}mean level, last period, from the start [m]", level, 0, 0.005 * DEPTH)


def free_wave(paper: bool) -> Iterator[Metric]:
    case = "free-wave"
    for scheme, reynolds, across in itertools.product(SCHEMES, REYNOLDS, (40, 80) if paper else (40,)):
        nu = np.sqrt(GRAVITY * LENGTH) * LENGTH / reynolds
        n, r = root(nu), made(f"{case}-{scheme}-{reynolds}-{across}", wave(scheme, nu, across, PERIODS))
        where = f"{scheme}, Re {reynolds}, {across} to the length: "
        if r is None:
            yield Metric(case, f"{where}runs that came to their end", 0, low=1)
        else:
            yield from score_wave(case, where, n, r)

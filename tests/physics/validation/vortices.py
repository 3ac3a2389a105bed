# SPDX-License-Identifier: BSD-3-Clause
"""What schemes make of viscosity in liquids that fill their space: a cavity with a lid, how fast vortices die, and flows between plates.

References: U. Ghia, K. N. Ghia and C. T. Shin, J. Comput. Phys. 48 (1982) 387-411, tables I and II, on 129^2 points; Taylor-Green vortices are
exact, and their energy decays as exp(-16 pi^2 nu t) in a box of side 1. Tolerances are what particles of these sizes can have in each scheme, a
wall and its corners included, and not what they have today."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from validation.differences import by, layers, profile_error
from validation.metrics import Metric
from validation.runs import Run, Snapshot, attempt, run, slope

# --- the cavity --------------------------------------------------------------------------------------------------------------

# Least u on the vertical line through the middle, greatest and least v on the horizontal one; the speed of the lid is 1.
GHIA = {100: (-0.21090, 0.17527, -0.24533), 400: (-0.32726, 0.30203, -0.44993)}
EXTREMES = ("least u on the vertical centre line", "greatest v on the horizontal centre line", "least v on the horizontal centre line")
SCHEMES = {
    "dissipation": ("scheme={dissipation: {gradient_correction: true}}",),
    "interfacial": ("scheme={interfacial: {gradient_correction: true}}",),
    "riemann": (),
    "incompressible": ("scheme={incompressible: {reference_speed: 1, gauge: mean}}",),
    "differences": ("scheme={differences: {reference_speed: 1}}",),
}
TOLERANCES = {100: {"incompressible": 0.04}, 400: {"riemann": 0.05, "interfacial": 0.06}}
OTHERS = {100: 0.03, 400: 0.1}
STEADY = {100: 8, 400: 16}  # from when on means are taken [s]: later ones are within their scatter
LATE = {(400, "incompressible"): 30}  # it is steady later
SHOTS, INTERVAL = 20, 0.5  # [s]: of twenty within two seconds the means scatter by 4 %, within ten by 1 or 2


def line(shots: Sequence[Snapshot], along: int) -> tuple[np.ndarray, np.ndarray]:
    """Places on the centre line along an axis, and the mean velocity across it there: the parabola nearest to all particles within two and a half
    spacings, of all snapshots, as a mean would cut crests off."""
    from scipy.spatial import cKDTree  # python3-scipy

    dx = shots[0].spacing
    x, v = np.concatenate([s.x[:, :2] for s in shots]), np.concatenate([s.velocity[:, 1 - along] for s in shots])
    at = np.arange(2 * dx, 1 - 2 * dx, 0.25 * dx)
    points = np.full((len(at), 2), 0.5)
    points[:, along] = at
    values = []
    for point, near in zip(points, cKDTree(x).query_ball_point(points, 2.5 * dx), strict=True):
        a, b = ((x[near] - point) / dx).T
        weight = 1 - (a * a + b * b) / 2.5**2
        terms = np.column_stack([np.ones_like(a), a, b, a * a, a * b, b * b])
        values.append(np.linalg.lstsq(terms * weight[:, None], v[near] * weight, rcond=None)[0][0])
    return at, np.array(values)


def top(at: np.ndarray, value: np.ndarray, sign: int) -> float:
    """Of the parabola through what is beside the greatest value (sign 1) or the least."""
    k = int(np.clip(np.argmax(sign * value), 2, len(at) - 3))
    a, b, c = np.polyfit(at[k - 2 : k + 3] - at[k], value[k - 2 : k + 3], 2)
    return float(c - b * b / (4 * a)) if sign * a < 0 else float(value[k])


def extremes(shots: Sequence[Snapshot]) -> tuple[float, float, float]:
    u, v = line(shots, 1), line(shots, 0)
    return top(*u, -1), top(*v, 1), top(*v, -1)


def steady_from(reynolds: int, scheme: str) -> float:
    """When the flow of this scheme is steady [s]."""
    return LATE.get((reynolds, scheme), STEADY[reynolds])


def until(reynolds: int, scheme: str, shots: int = SHOTS) -> float:
    """The end of a run that has all the snapshots that means are taken of [s]."""
    return steady_from(reynolds, scheme) + INTERVAL * (shots - 1)


def steady(r: Run, reynolds: int, scheme: str, shots: int = SHOTS) -> list[Snapshot]:
    """Snapshots that means are taken of."""
    return [s for s in r.snapshots(1) if s.t > steady_from(reynolds, scheme) - 1e-9][:shots]


def score_cavity(case: str, reynolds: int, scheme: str, r: Run) -> Iterator[Metric]:
    tolerance = TOLERANCES[reynolds].get(scheme, OTHERS[reynolds])
    for name, found, reference in zip(EXTREMES, extremes(steady(r, reynolds, scheme)), GHIA[reynolds], strict=True):
        yield Metric(case, f"Re {reynolds}, {scheme}: {name}", found, reference, tolerance, relative=True)


def cavity2d(_: bool) -> Iterator[Metric]:
    """By all schemes."""
    case, n = "cavity2d", 40
    for reynolds in (100, 400):
        same = (f"fluids[0].viscosity={1 / reynolds:g}", f"resolution={n}", f"output.snapshot_interval={INTERVAL}")
        for scheme, settings in SCHEMES.items():
            r = attempt(case, *settings, *same, f"end_time={until(reynolds, scheme):g}")
            if r is None:
                yield Metric(case, f"Re {reynolds}, {scheme}: runs that came to their end", 0, low=1)
            else:
                yield from score_cavity(case, reynolds, scheme, r)


# --- vortices ----------------------------------------------------------------------------------------------------------------

PROBES = "probes=[{name: kinetic, kinetic_energy: {}}]"  # the case's own ask for solves
VISCOSITY = 0.0025
# Settings, and the tolerance of the effective viscosity.
DAMPED = {
    "dissipation": ("dissipation", 0.1),
    "dissipation, gradients corrected": ("{dissipation: {gradient_correction: true}}", 0.1),
    "interfacial": ("interfacial", 0.1),
    "interfacial, gradients corrected": ("{interfacial: {gradient_correction: true}}", 0.1),
    "riemann": ("riemann", 0.15),
    "riemann, reconstruction both": ("{riemann: {reconstruction: both}}", 0.03),
}
BEGIN, END = 0.5, 2.5  # [s]: after the lattice has settled; while two fifths of the energy are left


def effective_viscosity(r: Run) -> float:
    """By which the kinetic energy decays, over what was told."""
    return -slope(r.t, np.log(r.probes["kinetic"]), BEGIN, END) / (16 * np.pi**2 * VISCOSITY)


def score_damping(case: str, name: str, n: int, r: Run) -> Iterator[Metric]:
    yield Metric(case, f"{name}: effective viscosity over that told, {n} particles a side", effective_viscosity(r), 1, DAMPED[name][1])


def taylor_green2d_damping(paper: bool) -> Iterator[Metric]:
    """The vortices of P4 3.1 at Re 400 under the schemes that are weakly compressible."""
    case = "taylor-green2d-damping"
    for n in (40, 80) if paper else (40,):
        for name, (scheme, _) in DAMPED.items():
            r = run("taylor-green2d", f"scheme={scheme}", "fluids[0].sound_speed=10", f"fluids[0].viscosity={VISCOSITY}", f"resolution={n}",
                    f"end_time={END}", PROBES)
            yield from score_damping(case, name, n, r)


# --- between plates ----------------------------------------------------------------------------------------------------------

SOUND = ("fluids[0].sound_speed=5", "fluids[1].sound_speed=5")  # ten times the fastest flow
PLATES = {
    "dissipation": ("scheme=dissipation", *SOUND),
    "interfacial": ("scheme=interfacial", *SOUND),
    "riemann": ("scheme=riemann", *SOUND),
    "incompressible": ("scheme={incompressible: {reference_speed: 0.5}}",),
    "differences, divtau": (),
    "differences, conservative": (by("conservative"),),
}


def poiseuille_schemes(_: bool) -> Iterator[Metric]:
    """One liquid, and two of which one is five times as viscous, under each scheme."""
    case = "poiseuille-schemes"
    for ratio, tolerance in ((1, 0.01), (5, 0.02)):
        for scheme, settings in PLATES.items():
            r = run("poiseuille-two-phase", *settings, *layers(ratio))
            yield Metric(case, f"{scheme}, ratio of viscosities {ratio}: relative error of the profile", profile_error(ratio, r.last()), high=tolerance)

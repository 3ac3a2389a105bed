# SPDX-License-Identifier: BSD-3-Clause
"""What must be the same for one who moves past it: vortices that die, a drop at rest, a cavity with a lid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from validation import tensions, vortices
from validation.made import made
from validation.metrics import Metric
from validation.runs import Run, Snapshot, attempt, run

FRAME = 1.0  # [m/s], the speed of vortices and lid too

# --- vortices ----------------------------------------------------------------------------------------------------------------

VORTICES = {
    "dissipation": ("scheme={dissipation: {gradient_correction: true}}", "fluids[0].sound_speed=20"),
    "interfacial": ("scheme=interfacial", "fluids[0].sound_speed=20"),
    "riemann": ("scheme=riemann", "fluids[0].sound_speed=20"),
    "incompressible": (),
    "differences": ("scheme={differences: {reference_speed: 1}}",),
}
PROBES = "probes=[{name: kinetic, kinetic_energy: {}}, {name: momentum_x, momentum: {axis: x}}, {name: mass, mass: {}}]"
END = 1.5  # [s]


def left(r: Run) -> float:
    """Of the energy of what moves within the fluid."""
    own = r.probes["kinetic"] - 0.5 * r.probes["momentum_x"] ** 2 / r.probes["mass"]
    return float(own[-1] / own[0])


def score_vortices(case: str) -> Iterator[Metric]:
    """At equal steps: without sound they are as long as the largest speed lets them be, and that is twice as large in motion. Energies go with the step by 2 %."""
    for scheme, settings in VORTICES.items():
        step = ("scheme.cfl=0.125",) if scheme in tensions.PROJECTS else ()
        still, moving = (left(run("taylor-green2d", *settings, *more, f"constants[1].value={drift:g}", f"end_time={END}", PROBES))
                         for drift, more in ((0, step), (FRAME, ())))
        yield Metric(case, f"Taylor-Green, {scheme}: energy that is left, as seen in motion", moving, still, 0.01, relative=True)


# --- a drop ------------------------------------------------------------------------------------------------------------------


def score_drops(case: str) -> Iterator[Metric]:
    for scheme in tensions.SCHEMES:
        jumps = []
        for drift in (0.0, 0.3):
            setup, _ = tensions.resting(scheme, 1200, 1, 16)
            for fluid in setup["fluids"]:
                fluid["velocity"] = [f"{drift}", f"{0.5 * drift}"]
            r = made(f"{case}-drop-{scheme}-{drift:g}", setup)
            jumps.append(r.mean("jump", 4, 8) if r else np.nan)
        yield Metric(case, f"drop at rest, {scheme}: jump of the pressure, as seen in motion", jumps[1], jumps[0], 0.01, relative=True)


# --- a cavity ----------------------------------------------------------------------------------------------------------------


def carried(end: float) -> tuple[str, ...]:
    """Settings that move walls and liquid along at half the speed of the lid."""
    motion = f"{{table: {{points: [{{t: 0, x: [0, 0], v: [0, {FRAME / 2}]}}, {{t: {end:g}, x: [0, {FRAME / 2 * end:g}], v: [0, {FRAME / 2}]}}]}}}}"
    return (f"walls[0].motion={motion}", f"walls[1].motion={motion}", f"fluids[0].velocity=['0', '{FRAME / 2}']")


def at_home(s: Snapshot, speed: float) -> Snapshot:
    """As one sees it who moves along."""
    along = np.array([0.0, speed, 0.0])
    return replace(s, x=s.x - s.t * along, velocity=s.velocity - along)


SHOTS = 2 * vortices.SHOTS  # the means of half as many are 1 to 3.5 % off each other in one and the same frame


def score_cavities(case: str, n: int) -> Iterator[Metric]:
    reynolds = 100
    same = (f"fluids[0].viscosity={1 / reynolds:g}", f"resolution={n}", f"output.snapshot_interval={vortices.INTERVAL}")
    for scheme, settings in vortices.SCHEMES.items():
        end = vortices.until(reynolds, scheme, SHOTS)
        found = []
        for extra in ((), carried(end)):
            r = attempt("cavity2d", *settings, *same, f"end_time={end:g}", *extra)
            speed = FRAME / 2 if extra else 0
            found.append(vortices.extremes([at_home(s, speed) for s in vortices.steady(r, reynolds, scheme, SHOTS)]) if r else (np.nan,) * 3)
        for name, still, moving in zip(vortices.EXTREMES, *found, strict=True):
            yield Metric(case, f"cavity2d, Re {reynolds}, {n} a side, {scheme}: {name}, as seen in motion", moving, still, 0.02, relative=True)


def frames(paper: bool) -> Iterator[Metric]:
    case = "moving-frame"
    yield from score_vortices(case)
    yield from score_drops(case)
    yield from score_cavities(case, 40 if paper else 24)

# SPDX-License-Identifier: BSD-3-Clause
"""Fluids that must stay as they are: at rest in layers, under a flat interface, or drifting through a periodic box."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from validation.common import hygiene
from validation.metrics import Metric
from validation.runs import Run, run


def score_rest(case: str, r: Run) -> Iterator[Metric]:
    """Water under something lighter."""
    depth, g, rho = 0.5, 9.81, 1000
    scale = rho * g * depth**2 / 2  # energy of the water over the floor, per metre of width and depth
    yield Metric(case, "rms pressure error / (rho g H)", r.probes["error"][-1] / (rho * g * depth), high=0.03)
    yield Metric(case, "largest kinetic energy / potential scale", float(r.probes["kinetic"].max()) / scale, high=1e-3)


def hydrostatic(paper: bool) -> Iterator[Metric]:
    """Water under air at rest, ratio 1000, after 5 sqrt(H/g)."""
    case, r = "hydrostatic", run("hydrostatic", f"resolution={80 if paper else 40}")
    yield from score_rest(case, r)
    yield from hygiene(case, r, void=False)


def hydrostatic4(paper: bool) -> Iterator[Metric]:
    """Four liquids at rest in a closed tank, mercury below, after 3 s."""
    case, r = "hydrostatic4", run("hydrostatic4", f"resolution={80 if paper else 40}", "end_time=3")
    floor = 9.81 * 0.25 * (13500 + 1000 + 800 + 700)
    energy = 9.81 * 0.25 * (13500 * 0.125 + 1000 * 0.375 + 800 * 0.625 + 700 * 0.875)
    yield Metric(case, "rms pressure error / pressure on the floor", r.probes["error"][-1] / floor, high=0.03)
    yield Metric(case, "largest kinetic energy / potential energy", float(r.probes["kinetic"].max()) / energy, high=1e-3)
    for name, centre in (("mercury", 0.125), ("water", 0.375), ("oil", 0.625), ("petrol", 0.875)):
        yield Metric(case, f"mass centre of {name} [m]", float(r.probes[f"centre_{name}"][-1]), centre, 0.005)
    yield from hygiene(case, r, void=False)


def score_drift(case: str, r: Run) -> Iterator[Metric]:
    scale = abs(r.probes["momentum_x"][0])
    for axis in "xy":
        p = r.probes[f"momentum_{axis}"]
        yield Metric(case, f"momentum {axis}: largest change / start", float(np.max(np.abs(p - p[0])) / scale), high=1e-11)


def drop_periodic(_: bool) -> Iterator[Metric]:
    """Nothing outside acts on a periodic box: momentum changes by rounding only."""
    yield from score_drift("drop-periodic2d", run("drop-periodic2d"))


def score_flat(case: str, r: Run, spacing: float) -> Iterator[Metric]:
    """The interface is where it was, and what moves is slow beside the speed that the tension would give, 1 N/m / 0.2 Pa s."""
    h = np.array([r.probes[f"h{k}"] for k in range(5)])
    late = r.t >= 0.5 * r.t[-1]
    yield Metric(case, "largest difference of heights / dx", float((h.max(0) - h.min(0)).max() / spacing), high=0.25)
    sunk = float((h.mean(0)[-1] - 0.1) / spacing)
    yield Metric(case, "mean height at the end, from 0.1 m, / dx", sunk, low=-0.25, high=0.25)
    capillary = 0.2 * float(r.probes["speed"][late].max()) / 1
    yield Metric(case, "capillary number of the liquid, second half", capillary, high=1e-2)
    yield Metric(case, "largest speed in the gas, second half [m/s]", float(r.probes["speed_gas"][late].max()))


def flat_interface(paper: bool) -> Iterator[Metric]:
    """A liquid under a gas, ratio 1000, with either scheme that has tension; in disorder, as columns of a lattice are all alike."""
    case, n = "flat-interface2d", 100 if paper else 50
    other = ["scheme.dissipation={pair_average: density, background_pressure: 70, repulsion: 0}",
             "scheme.kernel=truncated-gaussian", "scheme.smoothing=1.1"]
    schemes: dict[str, list[str]] = {"interfacial": [], "dissipation": other}
    for scheme, settings in schemes.items():
        r = run(case, f"resolution={n}", "domain.disorder=0.1", *settings)
        for m in (*score_flat(case, r, 0.2 / n), *hygiene(case, r)):
            yield replace(m, name=f"{scheme}: {m.name}")

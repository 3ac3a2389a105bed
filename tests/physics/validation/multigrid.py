# SPDX-License-Identifier: BSD-3-Clause
"""What multigrid takes for a pressure of few and of many particles: vortices in a periodic box, in two dimensions and, as columns, in three;
and two liquids between walls, from a start in disorder.

No paper has it. More than 1.5 times the iterations for a hundred times the particles, and the method would not be one for large cases."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from validation.metrics import Metric
from validation.runs import run

STEPS = 12
BEGINNING = 3  # steps from the start, which have no pressure to begin from
SCHEMES = {"incompressible": "taylor-green2d", "differences": "taylor-green2d-differences"}
IN_SPACE = ("dimensions=3", "domain={min: [0, 0, 0], max: [1, 1, 1], periodic: [x, y, z], disorder: 0.1}",
            'fluids[0].velocity=["-U*cos(2*pi*x)*sin(2*pi*y)", "U*sin(2*pi*x)*cos(2*pi*y)", "0"]')


def iterations(scheme: str, dim: int, n: int) -> float:
    """Of a step, in the mean, for n^dim particles. The viscosity goes with the spacing, and so does the length of a step."""
    found = run(SCHEMES[scheme], f"resolution={n}", f"fluids[0].viscosity={1 / n:.6g}", f"end_time={0.2 * STEPS / n:.6g}",
                f"scheme.{scheme}.solver=amg", "probes=[{name: iterations, solver: {}}]", "output.probe_interval=1e-7",
                "output.snapshot_interval=1", *(IN_SPACE if dim == 3 else ()))
    return float(np.mean(found.probes["iterations"][1 + BEGINNING:]))


# In the plane 2 n^2 particles of two liquids that overturn in a closed box; in space n^3 of a liquid under another, a thousandth as dense, both
# stirred: at rest there is the less to solve for the longer it is, and coarse particles have come farther in as many steps.
STIRRED = '["sin(pi*x)*cos(pi*y)", "-cos(pi*x)*sin(pi*y)", "0"]'
BETWEEN_WALLS = {
    2: ("rayleigh-taylor2d-isph", 0.5, 0.13, ("domain.disorder=0.1",)),
    3: ("hydrostatic-isph", 1, 0.22, ("dimensions=3", "domain={min: [0, 0, 0], max: [1, 1, 1], disorder: 0.1}", "gravity=[0, -1, 0]",
                                      "fluids[0].shape[0].box.min=[0, 0, 0]", "fluids[0].shape[0].box.max=[1, 0.5, 1]",
                                      "walls[0].shape[0].box.min=[0, 0, 0]", "walls[0].shape[0].box.max=[1, 1, 1]",
                                      f"fluids[0].velocity={STIRRED}", f"fluids[1].velocity={STIRRED}")),
}


def walled_iterations(scheme: str, dim: int, n: int) -> float:
    """The same of what has walls on all sides."""
    case, speed, step, settings = BETWEEN_WALLS[dim]
    found = run(case, f"resolution={n}", f"scheme={{{scheme}: {{solver: amg, reference_speed: {speed}}}}}", *settings,
                f"end_time={step * STEPS / n:.6g}", "probes=[{name: iterations, solver: {}}]", "output.probe_interval=1e-7",
                "output.snapshot_interval=1")
    return float(np.mean(found.probes["iterations"][1 + BEGINNING:]))


def multigrid(paper: bool) -> Iterator[Metric]:
    """10^4 and 10^5 particles; at the size of a paper 10^4 and 10^6."""
    for scheme in SCHEMES:
        for dim, few, many in ((2, 100, 1000 if paper else 316), (3, 22, 100 if paper else 46)):
            sizes = few**dim, many**dim
            first, last = iterations(scheme, dim, few), iterations(scheme, dim, many)
            what = f"{scheme}, {dim} dimensions: iterations a step of"
            yield Metric("multigrid", f"{what} {sizes[0]} particles", first)
            yield Metric("multigrid", f"{what} {sizes[1]} particles, over those", last / first, high=1.5)
        for dim, few, many in ((2, 71, 707 if paper else 224), (3, 22, 100 if paper else 46)):
            sizes = [2 * n**2 if dim == 2 else n**3 for n in (few, many)]
            first, last = walled_iterations(scheme, dim, few), walled_iterations(scheme, dim, many)
            what = f"{scheme}, {dim} dimensions, between walls: iterations a step of"
            yield Metric("multigrid", f"{what} {sizes[0]} particles", first)
            yield Metric("multigrid", f"{what} {sizes[1]} particles, over those", last / first, high=1.5)

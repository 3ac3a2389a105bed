# SPDX-License-Identifier: BSD-3-Clause
"""What multigrid takes for a pressure of few and of many particles: vortices in a periodic box, in two dimensions and, as columns, in three;
and two liquids between walls, from a start in disorder.

No paper has it. More than 1.5 times the iterations for a hundred times the particles, and the method would not be one for large cases."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from validation.metrics import Metric
from validation.runs import run

STEPS = 20
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


def walled_iterations(scheme: str, n: int) -> float:
    """The same for 2 n^2 particles of two liquids that overturn in a closed box."""
    found = run("rayleigh-taylor2d-isph", f"resolution={n}", f"scheme={{{scheme}: {{solver: amg, reference_speed: 0.5}}}}", "domain.disorder=0.1",
                f"end_time={0.13 * STEPS / n:.6g}", "probes=[{name: iterations, solver: {}}]", "output.probe_interval=1e-7",
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
        few, many = 71, 707 if paper else 224
        first, last = walled_iterations(scheme, few), walled_iterations(scheme, many)
        what = f"{scheme}, between walls: iterations a step of"
        yield Metric("multigrid", f"{what} {2 * few**2} particles", first)
        yield Metric("multigrid", f"{what} {2 * many**2} particles, over those", last / first, high=1.5)

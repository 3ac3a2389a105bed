# SPDX-License-Identifier: BSD-3-Clause
"""What is asked of every run: nothing lost, no voids, the fluids where they belong."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from validation.metrics import Metric
from validation.runs import Run, Snapshot


LONG_STEPS = "scheme.cfl=0.4"  # 1.6 times as long as a case's, where that moves nothing, or less than one start differs from another


def hygiene(case: str, r: Run, void: bool = True) -> Iterator[Metric]:
    """No particle outside, mass exact, no energy of nothing, no void."""
    yield Metric(case, "escaped particles", float(np.nanmax(r.probes["escaped"])), high=0)
    for name in sorted(r.probes, reverse=True):
        if name.startswith("mass_"):
            m = r.probes[name]
            yield Metric(case, f"{name}: largest change", float(np.max(np.abs(m - m[0])) / m[0]), high=1e-13)
    yield from energy(case, r)
    if void:
        yield Metric(case, "smallest sum of W V", float(np.nanmin(r.probes["coverage"])), low=0.75)


def energy(case: str, r: Run, where: str = "") -> Iterator[Metric]:
    if (excess := r.summary.get("energy_excess")) is not None:  # null: the run has no energy account
        yield Metric(case, f"{where}energy made of nothing, over the largest of kinetic energy and change of potential energy", excess, high=0.01)


def converges(case: str, what: str, coarse: float, fine: float, exact: float = 0) -> Metric:
    """Finer particles are nearer to it: of a quantity, or of its errors."""
    return Metric(case, f"{what}: error of the finer over that of the coarser", abs(fine - exact) / abs(coarse - exact), high=1)


def sharpness(r: Run, fluids: int = 2) -> tuple[float, ...]:
    """Share of each fluid in single particles lost in the others, in the last snapshot.

    A particle counts as lost if fewer than one in ten of the particles within the kernel's support are of its own fluid.
    """
    from scipy.spatial import cKDTree  # python3-scipy

    s = r.last(fluids)
    near = cKDTree(s.x).query_ball_point(s.x, 2.6 * s.spacing)
    own = np.array([np.count_nonzero(s.phase[k] == s.phase[i]) - 1 for i, k in enumerate(near)])
    others = np.array([len(k) - 1 for k in near])
    lost = own < 0.1 * others
    return tuple(float(np.mean(lost[s.phase == a])) for a in range(fluids))


NEAR = 12  # in two dimensions those within two spacings


def grain(s: Snapshot, phase: int) -> float:
    """What of the pressure in a fluid, in a plane, changes from particle to particle: rms distance from the linear field through the
    nearest of the same fluid, but of those that have few about them [Pa]."""
    from scipy.spatial import cKDTree  # python3-scipy

    x, p = s.x[s.phase == phase, :2] / s.spacing, s.pressure[s.phase == phase]
    distance, near = cKDTree(x).query(x, NEAR + 1)
    near = near[distance[:, -1] < 3, 1:]
    own = np.flatnonzero(distance[:, -1] < 3)
    places = np.concatenate([np.ones((*near.shape, 1)), x[near] - x[own, None]], axis=2)
    at_own = np.linalg.pinv(places)[:, 0]  # the constant of the linear field, as weights of the neighbours
    return float(np.sqrt(np.mean((p[own] - np.sum(at_own * p[near], axis=1)) ** 2)))


def interface_roughness(s: Snapshot, phase: int) -> float:
    """Of an interface in a plane: rms distance of the outermost particles of a fluid from the parabola through those of them within
    four spacings, in spacings. Outermost are those with another fluid within one and a half."""
    from scipy.spatial import cKDTree  # python3-scipy

    own, others = (s.x[m, :2] / s.spacing for m in (s.phase == phase, s.phase != phase))
    rim = own[np.isfinite(cKDTree(others).query(own, distance_upper_bound=1.5)[0])]
    squares = []
    for at, near in zip(rim, cKDTree(rim).query_ball_point(rim, 4), strict=True):
        points = rim[near] - rim[near].mean(0)
        if len(points) < 5:  # of a crumb
            continue
        axes = np.linalg.svd(points, full_matrices=False)[2]  # along the interface, and across
        fit = np.polyfit(*(points @ axes.T).T, 2)
        along, across = axes @ (at - rim[near].mean(0))
        squares.append((across - np.polyval(fit, along)) ** 2)
    return float(np.sqrt(np.mean(squares)))

# SPDX-License-Identifier: BSD-3-Clause
"""What is asked of every run: nothing lost, no voids, the fluids where they belong."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from validation.metrics import Metric
from validation.runs import Run


def hygiene(case: str, r: Run, void: bool = True) -> Iterator[Metric]:
    """No particle outside, mass exact, no void."""
    yield Metric(case, "escaped particles", float(np.nanmax(r.probes["escaped"])), high=0)
    for name in sorted(r.probes, reverse=True):
        if name.startswith("mass_"):
            m = r.probes[name]
            yield Metric(case, f"{name}: largest change", float(np.max(np.abs(m - m[0])) / m[0]), high=1e-13)
    if void:
        yield Metric(case, "smallest sum of W V", float(np.nanmin(r.probes["coverage"])), low=0.75)


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

# SPDX-License-Identifier: BSD-3-Clause
"""Drops that their tension draws round, and one that is round already: P2 4.2."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from validation.common import converges, energy, hygiene
from validation.metrics import Metric
from validation.runs import Run, Snapshot, attempt, run
from validation.series import extremum, peaks, row, table

MIDDLE, TENSION, VISCOSITY, DENSITY = 0.1, 1.0, 0.2, 1000.0


def laplace(case: str) -> tuple[float, float]:
    """Radius and pressure at rest."""
    line = row("P2/laplace.csv", case)
    return float(line["R_eq"]), float(line["dp"])


def radius(s: Snapshot, dimensions: int) -> float:
    """Of the drop, from the mean square distance of its particles from the middle of the box."""
    x = s.x[s.phase == 0][:, :dimensions] - MIDDLE
    return float(np.sqrt((1 + 2 / dimensions) * np.mean(np.sum(x**2, axis=1))))


def noise(s: Snapshot, dimensions: int) -> float:
    """Standard deviation of the pressure in the drop, away from its surface [Pa]."""
    x = s.x[:, :dimensions] - MIDDLE
    inner = (s.phase == 0) & (np.sum(x**2, axis=1) < (0.6 * radius(s, dimensions)) ** 2)
    return float(np.std(s.pressure[inner]))


def jump(r: Run) -> float:
    """Of the pressure, over the last tenth of a second."""
    return r.mean("jump", r.t[-1] - 0.1, r.t[-1])


def score_drop(case: str, key: str, dimensions: int, r: Run, full: bool) -> Iterator[Metric]:
    size, dp = laplace(key)
    yield Metric(case, "pressure jump, last 0.1 s [Pa]", jump(r), dp, 0.02 if full else 0.08, relative=True)
    yield Metric(case, "radius at the end [m]", radius(r.last(), dimensions), size, 0.005 if full else 0.02, relative=True)


def swing(r: Run) -> tuple[float, float]:
    """Period and decay rate of the mode of four lobes: the kinetic energy has two peaks in a period, and decays twice as fast as the
    shape."""
    t, energy = peaks(r.t, r.probes["kinetic"])
    inside = (t > 0.01) & (t < 0.35)
    t, energy = t[inside], energy[inside]
    if len(t) < 3:
        return np.nan, np.nan
    return 2 * float(np.polyfit(np.arange(len(t)), t, 1)[0]), -0.5 * float(np.polyfit(t, np.log(energy), 1)[0])


def score_swings(case: str, sizes: Sequence[int], runs: Sequence[Run]) -> Iterator[Metric]:
    """Waves on the drop are as long as the band in which the tension acts is wide, at l/50: they swing slower there."""
    mode = row("common/droplet2d_modes.csv", "P2 2D square drop", n="4")
    exact = float(mode["T_viscous"]), float(mode["decay_rate"])
    found = [swing(r) for r in runs]
    note = "not scored: the reference has no tolerance for it"
    for n, of in zip(sizes, found, strict=True):
        yield Metric(case, f"period of the swing at l/{n} [s]", of[0], exact[0], note=note)
        yield Metric(case, f"decay of the swing at l/{n} [1/s]", of[1], exact[1], note=note)
    yield converges(case, "period of the swing", *(of[0] for of in found), exact[0])
    if sizes[0] == 50:
        coarse, fine = (abs(of[0] / exact[0] - 1) for of in found)
        yield Metric(case, "period of the swing at l/50, off by", coarse, high=0.17)
        yield Metric(case, "period of the swing, error at l/100 over that at l/50", fine / coarse, high=0.4)


def score_calm(case: str, r: Run) -> Iterator[Metric]:
    kinetic = r.probes["kinetic"]
    yield Metric(case, "kinetic energy at 2 s / its largest", float(kinetic[-1] / kinetic.max()), high=1e-3)


def square_drop2d(paper: bool) -> Iterator[Metric]:
    """P2 4.2 at two resolutions, and how particles are shifted."""
    case, sizes, end = "square-drop2d", (100, 200) if paper else (50, 100), 2 if paper else 0.5
    dp = laplace("2D")[1]
    runs = [run(case, f"resolution={n}", f"end_time={end}") for n in sizes]
    scored = runs[1] if paper else runs[0]
    yield from score_drop(case, "2D", 2, scored, paper)
    yield from score_swings(case, sizes, runs)
    if paper:
        yield from score_calm(case, scored)
    for n, r in zip(sizes, runs, strict=True):
        of_its_own = jump(r) * radius(r.last(), 2) / TENSION
        yield Metric(case, f"pressure jump / Laplace's of its own radius at l/{n}", of_its_own, 1, 0.04)
        yield Metric(case, f"noise of the pressure inside / Laplace's jump at l/{n}", noise(r.last(), 2) / dp)
    yield converges(case, "pressure jump", *(jump(r) for r in runs), dp)
    for shifting in ("off", "original"):
        other = attempt(case, f"resolution={sizes[0]}", f"end_time={end}", f"scheme.interfacial.shifting={shifting}")
        value = jump(other) / dp if other else np.inf
        yield Metric(case, f"shifting {shifting}: pressure jump / Laplace's at l/{sizes[0]}", value)
    yield from hygiene(case, scored)


NARROW = ("domain={min: [0.04, 0.04, 0.04], max: [0.16, 0.16, 0.16]}", "walls[0].shape[0].box.min=[0.04, 0.04, 0.04]",
          "walls[0].shape[0].box.max=[0.16, 0.16, 0.16]")


def crest_and_trough(t: np.ndarray, half: np.ndarray) -> list[tuple[float, float]]:
    """Of the half width across the faces: when it is largest first, and then smallest, which is half a swing later, of one and a half times the
    reference's length on coarse particles; and how large."""
    crest = extremum(t, half, 0.06, 0.03, 1, 0.01)
    return [crest, extremum(t, half, crest[0] + 0.055, 0.045, -1, 0.01)]


def score_cube(case: str, sizes: Sequence[int], runs: Sequence[Run]) -> Iterator[Metric]:
    """How the cube swings: slower the coarser, as the square."""
    ref = table("P2/cubic_droplet3d_vof.csv")
    exact = crest_and_trough(ref["t_s"], ref["x_extent"])
    found = [crest_and_trough(r.t, 0.5 * (r.probes["right"] - r.probes["left"])) for r in runs]
    note = "not scored: the reference has no tolerance for it"
    for k, name in enumerate(("first largest", "next smallest")):
        for n, swing in zip(sizes, found, strict=True):
            yield Metric(case, f"half width, {name}, at l/{n} [m]", swing[k][1], exact[k][1], note=note)
            yield Metric(case, f"half width, {name}, at l/{n}, when [s]", swing[k][0], exact[k][0], note=note)
        yield converges(case, f"time of the half width's {name}", *(swing[k][0] for swing in found), exact[k][0])


def cube_drop3d(paper: bool) -> Iterator[Metric]:
    """P2 4.2 in three dimensions; reduced, in a narrower box. At two resolutions. A drop of l/30 is 7 spacings wide, and nothing in it is a kernel's support, 3.2 of
    them, away from its surface."""
    case, sizes = "cube-drop3d", (30, 50)
    part = ["end_time=0.5"] if paper else ["end_time=0.3", *NARROW]
    runs = [run(case, f"resolution={n}", *part, f"probes[0].pressure_jump.margin={2 * 0.2 / n:.4g}") for n in sizes]
    yield from score_drop(case, "3D", 3, runs[-1], paper)
    yield from score_cube(case, sizes, runs)
    for n, r in zip(sizes, runs, strict=True):
        yield Metric(case, f"pressure jump at l/{n} [Pa]", jump(r))
    yield converges(case, "pressure jump", *(jump(r) for r in runs), laplace("3D")[1])
    yield from hygiene(case, runs[-1])


def score_static(case: str, r: Run, spacing: float) -> Iterator[Metric]:
    """What must be zero: speeds, noise in the pressure."""
    size = radius(r.last(), 2)  # that of its particles, 2 % less than the drop's at l/50
    dp = TENSION / size
    late = r.t >= 0.5 * r.t[-1]
    capillary = VISCOSITY * float(r.probes["speed"][late].max()) / TENSION
    where = f"l/{round(0.2 / spacing)}"
    yield Metric(case, f"capillary number of what moves at {where}, second half", capillary, high=1e-2)
    yield Metric(case, f"noise of the pressure inside / Laplace's jump at {where}", noise(r.last(), 2) / dp, high=0.05)
    yield Metric(case, f"pressure jump, last 0.1 s, at {where} [Pa]", jump(r), dp, 0.08, relative=True)


def drift(r: Run) -> float:
    """Largest momentum of the drop, over its mass at the speed of its tension."""
    scale = r.probes["mass_drop"][0] * np.sqrt(TENSION / (DENSITY * radius(r.last(), 2)))
    return max(float(np.abs(r.probes[f"momentum_{axis}"]).max()) for axis in "xy") / scale


def score_drift(case: str, r: Run, n: int) -> Iterator[Metric]:
    yield Metric(case, f"in disorder, largest momentum / M sqrt(tension / (rho R)) at l/{n}", drift(r), high=1e-2)


def static_drop2d(_: bool) -> Iterator[Metric]:
    """The drop of P2 4.2, round from the start, at two resolutions; with corrected gradients. On a lattice it has no momentum by
    symmetry, so that is seen from a start in disorder: curvature times normal is no sum over pairs, and adds up to zero only as far as
    both are right."""
    case, sizes = "static-drop2d", (50, 100)
    runs = [run(case, f"resolution={n}") for n in sizes]
    for n, r in zip(sizes, runs, strict=True):
        yield from score_static(case, r, 0.2 / n)
    yield converges(case, "pressure jump over Laplace's", *(jump(r) * radius(r.last(), 2) / TENSION for r in runs), 1)
    corrected = run(case, f"resolution={sizes[0]}", "scheme.interfacial.gradient_correction=true")
    yield Metric(case, f"gradients corrected: pressure jump over Laplace's at l/{sizes[0]}", jump(corrected) * radius(corrected.last(), 2) / TENSION)
    stirred = [run(case, f"resolution={n}", "domain.disorder=0.1") for n in sizes]
    for n, r in zip(sizes, stirred, strict=True):
        yield from score_drift(case, r, n)
    yield converges(case, "in disorder, momentum", *(drift(r) for r in stirred))
    yield from energy(case, runs[0], f"at l/{sizes[0]}, as it ships: ")
    yield from hygiene(case, runs[-1])


def score_growth(case: str, where: str, r: Run) -> Iterator[Metric]:
    """Of what moves, over the last half of a run: its line, from the first to the last of it, over its mean."""
    first, last = 0.5 * r.t[-1], r.t[-1]
    growth = r.slope("kinetic", first, last) * (last - first) / r.mean("kinetic", first, last)
    yield Metric(case, f"{where}: growth of the kinetic energy over the last half, over its mean", growth, high=0.0)


def static_drop2d_water(paper: bool) -> Iterator[Metric]:
    """The same drop with the viscosities of water and air."""
    case = "static-drop2d-water"
    for n, tolerance in ((50, 0.04), (100, 0.03)) if paper else ((50, 0.04),):
        r = attempt("static-drop2d", f"resolution={n}", "fluids[0].viscosity=1e-3", "fluids[1].viscosity=1.8e-5", "end_time=1")
        if r is None:
            yield Metric(case, f"l/{n}: runs that came to their end", 0, low=1)
            continue
        found = r.mean("jump", 0.5, 1) * radius(r.last(), 2) / TENSION
        yield Metric(case, f"l/{n}: pressure jump, mean of the last half, over Laplace's of its own radius", found, 1, tolerance)
        yield from score_growth(case, f"l/{n}", r)

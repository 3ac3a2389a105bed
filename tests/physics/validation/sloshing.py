# SPDX-License-Identifier: BSD-3-Clause
"""Liquids in shaken tanks: P3 3.2, P1 4.1."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from validation.common import LONG_STEPS, converges, hygiene
from validation.metrics import Metric
from validation.runs import Run, run
from validation.series import crossings, extremum, smooth, table


def sloshing2d(paper: bool) -> Iterator[Metric]:
    """P3 3.2 against a finite-volume computation of the closed tank.

    Wet means a pressure above 150 Pa, the head of 15 mm, in both; pressures are relative to the air under the roof.
    """
    case = "sloshing2d"
    r = run(case, f"resolution={260 if paper else 130}", f"end_time={6 if paper else 1.65}", "output.probe_interval=0.005")
    ref, wet = table("P3/sloshing_vof2d.csv"), 150
    p1 = smooth(r.t, r.probes["P1"] - r.probes["roof"], 0.04)
    mine = crossings(r.t, p1, wet)
    theirs = crossings(ref["t_s"], ref["P1"], wet)
    events = (("wet", 0.48), ("dry", 1.50), ("wet", 2.56), ("dry", 3.24), ("wet", 4.42))
    for name, nominal in ((name, nominal) for name, nominal in events if nominal < r.t[-1]):
        reference = theirs[np.argmin(np.abs(theirs - nominal))]
        value = mine[np.argmin(np.abs(mine - nominal))]
        yield Metric(case, f"P1 {name} near {nominal} s [s]", float(value), float(reference), 0.05 if paper else 0.08)
    first, first_ref = (r.t > 0.8) & (r.t < 1.4), (ref["t_s"] > 0.8) & (ref["t_s"] < 1.4)  # the crest that does not break
    crest, crest_ref = r.probes["h_right"][first] - 0.18, ref["eta_right20"][first_ref]
    reference = float(crest_ref.max())
    yield Metric(case, "first crest, 20 mm from the wall [m]", float(crest.max()), reference, 0.05 if paper else 0.1, relative=True)
    when, when_ref = r.t[first][crest.argmax()], ref["t_s"][first_ref][crest_ref.argmax()]
    yield Metric(case, "its time [s]", float(when), float(when_ref), 0.05 if paper else 0.08)
    windows = [((0.4, 1.6), 0.05 if paper else 0.1)] + ([((2.5, 3.4), 0.25), ((4.4, 5.6), 0.25)] if paper else [])
    for (first, last), tolerance in windows:
        for name in ("P1", "P2", "P3"):
            m, mr = (r.t >= first) & (r.t <= last), (ref["t_s"] >= first) & (ref["t_s"] <= last)
            value = np.trapz(np.nan_to_num(r.probes[name] - r.probes["roof"])[m], r.t[m])
            reference = np.trapz(ref[name][mr], ref["t_s"][mr])
            metric = f"impulse {name}, {first}-{last} s [Pa s]"
            yield Metric(case, metric, float(value), float(reference), tolerance, relative=True)
    yield from hygiene(case, r)


# --- P1 4.1.1: one layer ---------------------------------------------------------------------------------------------------

CRESTS = (1.10, 2.08, 3.12, 4.14, 5.18)  # [s], at the gauge 20 mm from the left wall
TROUGHS = (1.58, 2.62, 3.66, 4.68)
STILL = 0.15  # [m]


Extremum = tuple[float, float]


def extreme(case: str, name: str, mine: Extremum, theirs: Extremum, amplitude: float, phase: float, note: str = "") -> Iterator[Metric]:
    """A crest or trough, (time, value), against another."""
    yield Metric(case, f"{name} [m]", mine[1], theirs[1], amplitude, relative=True, note=note)
    yield Metric(case, f"time of {name} [s]", mine[0], theirs[0], phase, note=note)


def score_one_layer(case: str, r: Run, full: bool) -> Iterator[Metric]:
    ref, linear = table("P1/sloshing_single_vof2d.csv"), table("P1/sloshing_single_linear.csv")
    eta = smooth(r.t, r.probes["left"] - STILL, 0.04)
    amplitude, phase = (0.08, 0.02) if full else (0.12, 0.03)
    for sign, kind, times in ((1, "crest", CRESTS), (-1, "trough", TROUGHS)):
        for t in times:
            if t + 0.05 > r.t[-1]:
                continue
            mine, theirs = (extremum(*series, t, 0.2, sign) for series in ((r.t, eta), (ref["t_s"], ref["left20mm"])))
            yield from extreme(case, f"{kind} near {t} s", mine, theirs, amplitude, phase)
    early = r.t <= 1.2
    theory = np.interp(r.t[early], linear["t_s"], linear["left20mm_impulsive"])
    error = np.sqrt(np.mean((eta[early] - theory) ** 2)) / np.abs(theory).max()
    yield Metric(case, "rms distance from linear theory / its amplitude, t < 1.2 s", float(error), high=0.05 if full else np.inf)


def third_crest(r: Run) -> float:
    return extremum(r.t, r.probes["left"] - STILL, 3.12, 0.2, 1)[1]


def record_error(r: Run) -> float:
    """Of all that the gauge writes, from finite volumes: rms over the reference's own [1]."""
    ref = table("P1/sloshing_single_vof2d.csv")
    mine, theirs = (smooth(r.t, eta, 0.04) for eta in (r.probes["left"] - STILL, np.interp(r.t, ref["t_s"], ref["left20mm"])))
    return float(np.sqrt(np.mean((mine - theirs) ** 2) / np.mean(theirs**2)))


def sloshing2d_single(paper: bool) -> Iterator[Metric]:
    """P1 4.1.1 in a slice; two resolutions, the finer one scored. They are compared by all of the record: a single crest is nearer or farther by a
    twentieth of a spacing, which is chance."""
    case, sizes = "sloshing2d-single", (30, 60) if paper else (15, 30)
    runs = [run(case, f"resolution={n}", f"end_time={5.3 if paper else 3.2}") for n in sizes]
    yield from score_one_layer(case, runs[-1], paper)
    for n, r in zip(sizes, runs, strict=True):
        yield Metric(case, f"crest near 3.12 s at h/{n} [m]", third_crest(r))
        yield Metric(case, f"rms distance of the record from the reference / its rms at h/{n}", record_error(r))
    yield converges(case, "record", *(record_error(r) for r in runs))
    yield from hygiene(case, runs[-1], void=False)


def sloshing3d_single(paper: bool) -> Iterator[Metric]:
    """P1 4.1.1; reduced, up to the second crest, in steps 1.6 times as long, which move the first two crests of the slice by less than 0.1 mm."""
    case, settings = "sloshing3d-single", ("resolution=60", "end_time=5.3") if paper else ("resolution=15", "end_time=2.2", LONG_STEPS)
    r = run(case, *settings)
    yield from score_one_layer(case, r, paper)
    yield from hygiene(case, r, void=False)


# --- P1 4.1.2: three layers ------------------------------------------------------------------------------------------------

REST = {"wd": 0.2, "cw": 0.4, "fs": 0.6}  # [m]


def score_layers_slice(case: str, r: Run, full: bool) -> Iterator[Metric]:
    ref = table("P1/three_layer_vof2d_xonly.csv")
    amplitude, phase = (0.08, 0.03) if full else (0.12, 0.05)
    for name, t in (("fs_xp", 1.16), ("fs_xm", 1.92), ("cw_xm", 1.92)):
        eta = smooth(r.t, r.probes[name] - REST[name[:2]], 0.04)
        mine, theirs = extremum(r.t, eta, t, 0.25, 1), extremum(ref["t_s"], ref[name], t, 0.25, 1)
        yield from extreme(case, f"crest of {name} near {t} s", mine, theirs, amplitude, phase)


def sloshing2d_three_layers(paper: bool) -> Iterator[Metric]:
    """P1 4.1.2 in a slice, along x only, at two resolutions."""
    case, sizes = "sloshing2d-three-layers", (10, 20) if paper else (5, 10)
    runs = [run(case, f"resolution={n}", "end_time=2.1") for n in sizes]
    yield from score_layers_slice(case, runs[-1], paper)
    crests = [extremum(r.t, r.probes["fs_xm"] - REST["fs"], 1.92, 0.25, 1)[1] for r in runs]
    for n, crest in zip(sizes, crests, strict=True):
        yield Metric(case, f"crest of fs_xm near 1.92 s at {n} per layer [m]", crest)
    ref = table("P1/three_layer_vof2d_xonly.csv")
    yield converges(case, "crest of fs_xm near 1.92 s", *crests, extremum(ref["t_s"], ref["fs_xm"], 1.92, 0.25, 1)[1])
    yield from hygiene(case, runs[-1], void=False)


AMPLITUDE = 0.00425  # of the tank in sloshing2d-three-layers-resonance [m]
MODE = {"omega": 4.0883311, "cw": 0.5589286, "wd": 0.23827605}  # P1/three_layer_natural_frequencies.csv, along x, the third of n = 1


def swing(r: Run, level: str) -> np.ndarray:
    """Of the two ends against each other: what is even along the tank drops out [m]."""
    return 0.5 * (r.probes[f"{level}_xm"] - r.probes[f"{level}_xp"])


def period(r: Run) -> float:
    """From where the surface passes its rest, a straight line through all times of it [s]."""
    zeros = crossings(r.t, smooth(r.t, swing(r, "fs"), 0.04), 0)
    zeros = zeros[zeros > 0.3]
    return 2 * float(np.polyfit(np.arange(len(zeros)), zeros, 1)[0])


def share(r: Run, level: str) -> float:
    """How much an interface swings for each metre of the surface, by least squares."""
    surface = swing(r, "fs")
    return float(np.sum(swing(r, level) * surface) / np.sum(surface**2))


def score_layers_free(case: str, r: Run, full: bool) -> Iterator[Metric]:
    """Period and shape of the mode."""
    exact = 2 * np.pi / MODE["omega"]
    yield Metric(case, "period of the surface [s]", period(r), exact, 0.01)  # a third of what one liquid would be off
    for level in ("cw", "wd"):
        yield Metric(case, f"swing of {level} over that of the surface", share(r, level), MODE[level], 0.08 if full else 0.12, relative=True)


def sloshing2d_three_layers_free(paper: bool) -> Iterator[Metric]:
    """The first mode of the surface left alone, at two resolutions."""
    case, sizes = "sloshing2d-three-layers-free", (10, 20) if paper else (5, 10)
    runs = [run(case, f"resolution={n}") for n in sizes]
    yield from score_layers_free(case, runs[-1], paper)
    exact = 2 * np.pi / MODE["omega"]
    for n, one in zip(sizes, runs, strict=True):
        yield Metric(case, f"period at {n} per layer, from the theory's [s]", period(one) - exact)
    yield Metric(case, "period of one liquid 0.6 m deep, which the paper takes, from the theory's [s]", 2 * np.pi / 4.179 - exact)
    yield from hygiene(case, runs[-1], void=False)


def forced(omega: float, amplitude: float, times: np.ndarray) -> np.ndarray:
    """Surface 20 mm before the left wall of three layers in a tank moved along x, by linear theory [m].

    Each odd mode of the tank by itself, M eta'' + K eta = f(t) for its three interfaces, M and K as in the head of
    P1/three_layer_natural_frequencies.csv. Against an acceleration a of the tank the levels strive for -(a/g) (x - L/2), of which cos(k x) has
    -4 L / (n pi)^2.
    """
    from scipy.linalg import eigh  # python3-scipy

    length, depth, g, rho = 1.5, 0.2, 9.81, np.array([1300.0, 1000.0, 780.0, 0.0])
    dt = 1e-3
    t = np.arange(0, times[-1] + dt, dt)
    total = np.zeros_like(t)
    for n in range(1, 40, 2):
        k = n * np.pi / length
        coth, csch = 1 / np.tanh(k * depth), 1 / np.sinh(k * depth)
        mass = np.diag((rho[:3] * coth + rho[1:] * coth) / k)
        for a in range(2):
            mass[a, a + 1] = mass[a + 1, a] = -rho[a + 1] * csch / k
        stiffness = g * (rho[:3] - rho[1:])
        square, shape = eigh(np.diag(stiffness), mass)
        # In gravity (-B w^2 cos w t, -g) levels strive for -(B w^2 / g) cos w t times (x - L/2).
        push = shape.T @ stiffness * (4 * length / (n * np.pi) ** 2) * amplitude * omega**2 / g
        for m in range(3):
            w = np.sqrt(square[m])
            # q'' + w^2 q = push cos(omega t), at rest at first.
            q = push[m] * (t * np.sin(w * t) / (2 * w) if abs(w - omega) < 1e-6 else (np.cos(omega * t) - np.cos(w * t)) / (w**2 - omega**2))
            total += shape[2, m] * q * np.cos(k * 0.02)
    return np.interp(times, t, total)


def score_layers_resonance(case: str, r: Run, full: bool) -> Iterator[Metric]:
    """Crests and the trough of the left end against linear theory."""
    theory, amplitude, phase = forced(MODE["omega"], AMPLITUDE, r.t), 0.08 if full else 0.12, 0.03 if full else 0.05
    eta = smooth(r.t, r.probes["fs_xm"] - REST["fs"], 0.04)
    for t, sign in ((1.92, 1), (2.69, -1), (3.46, 1)):
        kind = "crest" if sign > 0 else "trough"
        yield from extreme(case, f"{kind} of fs_xm near {t} s", extremum(r.t, eta, t, 0.25, sign), extremum(r.t, theory, t, 0.25, sign), amplitude, phase)


def driven_crest(t: np.ndarray, eta: np.ndarray) -> float:
    return extremum(t, eta, 3.46, 0.25, 1)[1]


def sloshing2d_three_layers_resonance(paper: bool) -> Iterator[Metric]:
    """Driven at the frequency of its first mode, at two resolutions.

    Crests grow beyond linear theory with the square of the amplitude, by as much as a resolution is off. So each is run with half of the
    amplitude too, and what is compared with the theory is the crest of an amplitude that goes to 0, for as much of the amplitude.
    """
    case, sizes = "sloshing2d-three-layers-resonance", (10, 20) if paper else (5, 10)
    runs = [run(case, f"resolution={n}") for n in sizes]
    yield from score_layers_resonance(case, runs[-1], paper)
    small = []
    for n, one in zip(sizes, runs, strict=True):
        half = run(case, f"resolution={n}", f"constants[1].value={AMPLITUDE / 2}")
        crest, twice = driven_crest(one.t, one.probes["fs_xm"] - REST["fs"]), 2 * driven_crest(half.t, half.probes["fs_xm"] - REST["fs"])
        small.append((4 * twice - crest) / 3)
        yield Metric(case, f"crest of fs_xm near 3.46 s at {n} per layer [m]", crest)
        yield Metric(case, f"the same of small amplitudes at {n} per layer [m]", small[-1])
    theory = driven_crest(runs[-1].t, forced(MODE["omega"], AMPLITUDE, runs[-1].t))
    yield converges(case, "crest of small amplitudes", *small, theory)
    yield from hygiene(case, runs[-1], void=False)


CORNERS = {"mm": "x-y-", "mp": "x-y+", "pm": "x+y-", "pp": "x+y+"}
OPPOSITE = (("mm", "pp"), ("mp", "pm"))


def first_extreme(case: str, what: str, t: np.ndarray, eta: np.ndarray, theory: np.ndarray, tolerance: tuple[float, float], note: str = "") -> Iterator[Metric]:
    """The largest crest or trough of 0.2 s < t < 0.8 s, as long as linear theory holds."""
    times = table("P1/three_layer_forced_linear.csv")["t_s"]
    early = (times > 0.2) & (times < 0.8)
    k = np.flatnonzero(early)[np.argmax(np.abs(theory[early]))]
    when, sign = float(times[k]), 1 if theory[k] > 0 else -1
    mine, theirs = extremum(t, smooth(t, eta, 0.04), when, 0.15, sign), extremum(times, theory, when, 0.15, sign)
    yield from extreme(case, f"{'crest' if sign > 0 else 'trough'} of {what} near {when:.2g} s", mine, theirs, *tolerance, note)


def score_layers(case: str, r: Run, full: bool, note: str = "") -> Iterator[Metric]:
    """Each corner, and half of the difference of opposite ones: what both have alike linear theory has not, and a gauge sees no less than half a
    particle."""
    ref = table("P1/three_layer_forced_linear.csv")
    tolerance = (0.08, 0.03) if full else (0.12, 0.05)
    for level in ("fs", "cw"):
        for a, b in OPPOSITE:
            eta, theory = (0.5 * (of[f"{level}_{x}"] - of[f"{level}_{y}"]) for of, x, y in ((r.probes, a, b), (ref, CORNERS[a], CORNERS[b])))
            yield from first_extreme(case, f"{level} at {CORNERS[a]} less {CORNERS[b]}, half,", r.t, eta, theory, tolerance)
    for level in ("fs", "cw"):
        for corner, name in CORNERS.items():
            yield from first_extreme(case, f"{level} at {name}", r.t, r.probes[f"{level}_{corner}"] - REST[level], ref[f"{level}_{name}"], (0.08, 0.03), note)


LINEAR = ("end_time=0.9", LONG_STEPS)  # in the slice the longer steps move no level by 0.01 mm


def sloshing3d_three_layers(paper: bool) -> Iterator[Metric]:
    """P1 4.1.2; reduced, as long as linear theory holds."""
    case, settings = "sloshing3d-three-layers", ("resolution=20",) if paper else ("resolution=5", *LINEAR)
    r = run(case, *settings)
    yield from score_layers(case, r, paper, "" if paper else "not scored: five particles to a layer")
    yield from hygiene(case, r, void=False)


def sloshing3d_three_layers_linear(paper: bool) -> Iterator[Metric]:
    """As long as linear theory holds, with twice as many particles to a layer: for who asks, as an hour has no room for it."""
    if paper:
        case, r = "sloshing3d-three-layers-linear", run("sloshing3d-three-layers", "resolution=10", *LINEAR)
        yield from score_layers(case, r, True)
        yield from hygiene(case, r, void=False)

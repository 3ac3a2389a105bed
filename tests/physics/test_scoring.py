#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What scores the cases: series that are made of the reference pass, and for each metric there is one that misses.

Nothing is run. The series are sampled as a run samples them; what a case asks of snapshots is made up, too.
"""

from __future__ import annotations

import sys
import tempfile
import unittest
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from validation import (  # noqa: E402
    bubbles, capillary, common, dam_breaks, differences, drops, incompressible, interfaces, rest, series, sloshing, tensions, vortices, waves)
from validation.metrics import Metric, Report  # noqa: E402
from validation.runs import Run, Snapshot  # noqa: E402

Scoring = Callable[[Run], Iterable[Metric]]
Change = Callable[[Run], Run]


class Made(Run):
    """A run that never was, with the snapshots it is given."""

    shots: tuple[Snapshot, ...] = ()

    def snapshots(self, fluids: int = 2) -> list[Snapshot]:
        return list(self.shots)

    def last(self, fluids: int = 2) -> Snapshot:
        return self.shots[-1]


def made(t: np.ndarray, shots: Iterable[Snapshot] = (), **probes: np.ndarray) -> Made:
    r = Made(Path(), {"energy_excess": 0.0}, t, {name: np.broadcast_to(np.asarray(value, float), t.shape).copy() for name, value in probes.items()})
    r.shots = tuple(shots)
    return r


def samples(end: float, interval: float) -> np.ndarray:
    return np.arange(0, end + 0.5 * interval, interval)


def changed(name: str, f: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Change:
    """The run with another series for a probe: a function of times and values."""

    def change(r: Run) -> Run:
        other = replace(r, probes=r.probes | {name: f(r.t, r.probes[name])})
        if isinstance(r, Made):
            other.shots = r.shots
        return other

    return change


def wasteful(r: Run) -> Run:
    """The run with energy that its scheme has made."""
    other = replace(r, summary=r.summary | {"energy_excess": 0.02})
    if isinstance(r, Made):
        other.shots = r.shots
    return other


def scaled(name: str, factor: float, about: float = 0.0) -> Change:
    return changed(name, lambda t, v: about + factor * (v - about))


def moved(name: str, by: float) -> Change:
    return changed(name, lambda t, v: v + by)


def late(name: str, by: float) -> Change:
    return changed(name, lambda t, v: np.interp(t - by, t, v))


def shown(change: Callable[[Snapshot], Snapshot]) -> Change:
    def apply(r: Run) -> Run:
        other = replace(r)
        other.shots = tuple(change(s) for s in r.shots)
        return other

    return apply


class Scored(unittest.TestCase):
    def check(self, good: Run, scoring: Scoring, *changes: Change) -> None:
        """All pass of what is good, and each misses after one of the changes."""
        metrics = list(scoring(good))
        wanted = {m.name for m in metrics if m.scored}
        self.assertTrue(wanted)
        for m in metrics:
            self.assertTrue(m.passed, f"{m.columns()}")
            self.assertEqual(len(m.columns()), 6)
        missed = {m.name for change in (*changes, wasteful) for m in scoring(change(good)) if not m.passed}
        self.assertEqual(wanted - missed, set(), "these pass whatever is done to the series")
        self.assertEqual(missed - wanted, set())


class Table(unittest.TestCase):
    def test_a_bound_a_tolerance_and_a_note_each_give_their_verdict(self):
        self.assertTrue(Metric("c", "m", 1.05, 1, 0.06).passed)
        self.assertFalse(Metric("c", "m", 1.07, 1, 0.06).passed)
        self.assertTrue(Metric("c", "m", 210, 200, 0.06, relative=True).passed)
        self.assertFalse(Metric("c", "m", -213, -200, 0.06, relative=True).passed)
        self.assertFalse(Metric("c", "m", np.nan, 1, 0.06).passed)
        self.assertFalse(Metric("c", "m", np.inf, high=1).passed)
        self.assertFalse(Metric("c", "m", np.nan, high=1).passed)
        self.assertTrue(Metric("c", "m", np.inf, 1, 0.06, note="not scored").passed)
        self.assertEqual(Metric("c", "m", np.inf).columns()[-1], "-")

    def test_hygiene_sees_loss_escape_and_void(self):
        t = samples(1, 0.1)
        good = made(t, escaped=0, mass_water=2, coverage=0.9)
        Scored().check(good, lambda r: common.hygiene("c", r), moved("escaped", 1), scaled("coverage", 0.5),
                         changed("mass_water", lambda t, v: v * (1 + 1e-6 * t)))

    def test_a_parabola_gives_crests_between_samples(self):
        t = samples(2, 0.1)
        when, value = series.extremum(t, 3 - (t - 1.03) ** 2, 1.1, 0.3, 1)
        self.assertAlmostEqual(when, 1.03)
        self.assertAlmostEqual(value, 3)


class Roughness(unittest.TestCase):
    def test_a_rough_interface_is_told_from_a_curved_one(self):
        """Of nine particles a parabola, which has three numbers, takes a third of the squares for its own."""
        x, y = (a.ravel() for a in np.meshgrid(np.arange(40) + 0.5, np.arange(20) + 0.5))
        rows = np.column_stack([x, y + 0.002 * (x - 20) ** 2, 0 * x])
        for rough in (0, 0.2):
            shaken = rows + rough * np.column_stack([0 * x, np.where(x % 2 < 1, 1, -1), 0 * x]) * (np.abs(y - 10) < 1)[:, None]
            found = common.interface_roughness(Snapshot(0, 1, shaken, (y > 10).astype(int), np.zeros(len(x))), 1)
            self.assertAlmostEqual(found, rough * np.sqrt(1 - 3 / 9), delta=0.01)


class Sloshing(Scored):
    def test_one_layer(self):
        ref = series.table("P1/sloshing_single_vof2d.csv")
        for full, end in ((False, 3.2), (True, 5.3)):
            t = samples(end, 0.01)
            good = made(t, left=0.15 + np.interp(t, ref["t_s"], ref["left20mm"]))
            self.check(good, lambda r, full=full: sloshing.score_one_layer("c", r, full),
                       scaled("left", 0.8, 0.15), late("left", 0.05), scaled("left", -1, 0.15))

    def test_record(self):
        ref = series.table("P1/sloshing_single_vof2d.csv")
        t = samples(3.2, 0.01)
        for factor in (1, 1.1, 0.8):
            r = made(t, left=0.15 + factor * np.interp(t, ref["t_s"], ref["left20mm"]))
            self.assertAlmostEqual(sloshing.record_error(r), abs(factor - 1), delta=0.004)

    def test_three_layers_in_a_slice(self):
        ref = series.table("P1/three_layer_vof2d_xonly.csv")
        t = samples(2.1, 0.01)
        good = made(t, **{n: sloshing.REST[n[:2]] + np.interp(t, ref["t_s"], ref[n]) for n in ("fs_xp", "fs_xm", "cw_xm")})
        for full in (False, True):
            self.check(good, lambda r, full=full: sloshing.score_layers_slice("c", r, full),
                       *(change for n in ("fs_xp", "fs_xm", "cw_xm") for change in (scaled(n, 0.8, sloshing.REST[n[:2]]), late(n, 0.07))))

    def test_three_layers_left_to_swing(self):
        t, mode = samples(3.9, 0.01), sloshing.MODE
        swing = 0.02 * np.sin(mode["omega"] * t)
        good = made(t, **{f"{level}_x{end}": sloshing.REST[level] + sign * mode.get(level, 1) * swing
                          for level in ("fs", "cw", "wd") for end, sign in (("m", 1), ("p", -1))})
        for full in (False, True):
            self.check(good, lambda r, full=full: sloshing.score_layers_free("c", r, full),
                       changed("fs_xm", lambda t, v: np.interp(1.02 * t, t, v)), scaled("cw_xm", 0.7, 0.4), scaled("wd_xp", 0.7, 0.2))

    def test_three_layers_in_resonance(self):
        t = samples(4, 0.01)
        good = made(t, fs_xm=0.6 + sloshing.forced(sloshing.MODE["omega"], 0.00425, t))
        for full in (False, True):
            self.check(good, lambda r, full=full: sloshing.score_layers_resonance("c", r, full), scaled("fs_xm", 0.8, 0.6), late("fs_xm", 0.07))

    def test_linear_theory_is_that_of_the_reference(self):
        ref = series.table("P1/three_layer_forced_linear.csv")
        early = ref["t_s"] < 0.8
        mine = sloshing.forced(4.18, 0.0425, ref["t_s"])[early]
        self.assertLess(np.abs(mine - ref["fs_xm"][early]).max(), 0.02 * np.abs(mine).max())

    def test_three_layers_in_the_corners(self):
        ref = series.table("P1/three_layer_forced_linear.csv")
        t, probes = samples(2.83, 0.01), {}
        for level in ("fs", "cw"):
            for corner, name in sloshing.CORNERS.items():
                probes[f"{level}_{corner}"] = sloshing.REST[level] + np.interp(t, ref["t_s"], ref[f"{level}_{name}"])
        for full, larger, behind in ((False, 1.26, 0.12), (True, 1.18, 0.08)):
            self.check(made(t, **probes), lambda r, full=full: sloshing.score_layers("c", r, full),
                       *(change for n in probes for change in (scaled(n, larger, sloshing.REST[n[:2]]), late(n, behind))))


class DamBreaks(Scored):
    def two(self, end: float) -> Made:
        ref = series.table("P3/dam_break_vof_W2H_H95.csv")
        t = samples(end, 0.005)
        # The toe of the reference is behind early; a run is between the exact layer and the exact toe.
        early = series.table("P3/dam_break_early.csv")
        front = 2 + np.where(t < 0.6, np.interp(t, early["t"], early["h_40"]), np.interp(t, ref["t"], ref["toe_from_dam"]))
        return made(t, front=np.minimum(front, 5.366), P20=np.interp(t, ref["t"], ref["p_0.20"]), roof=0)

    def test_the_long_column(self):
        good = self.two(6.85)
        for full in (False, True):
            self.check(good, lambda r, full=full: dam_breaks.score_interfacial("c", r, 30, full),
                       scaled("front", 0.9, 2), late("front", 0.2), scaled("P20", 0.8), late("P20", 0.3))

    def test_units_are_those_of_the_depth(self):
        good = self.two(3.5)
        unit = np.sqrt(0.3 / 9.81)
        metres = replace(good, t=good.t * unit, probes={
            "front": good.probes["front"] * 0.3, "roof": good.probes["roof"] + 70.0,
            "P20": good.probes["P20"] * 1000 * 9.81 * 0.3 + 70})
        back = dam_breaks.in_depths(metres)
        np.testing.assert_allclose(back.probes["front"], good.probes["front"])
        np.testing.assert_allclose(back.probes["P20"], good.probes["P20"], atol=1e-12)
        np.testing.assert_allclose(back.t, good.t)

    def test_the_square_column(self):
        ref = series.table("P3/dam_break_vof_WH1_H95.csv")
        t = samples(3.2, 0.005)
        for full in (False, True):
            self.check(made(t, front=1 + np.interp(t, ref["t"], ref["toe_from_dam"])),
                       lambda r, full=full: dam_breaks.score_square("c", r, full), scaled("front", 0.92, 1))


class Reports(unittest.TestCase):
    def test_what_was_not_run_is_told_with_what_it_takes(self):
        with tempfile.TemporaryDirectory() as directory:
            report = Report(True, Path(directory), {"a": 7200, "b": 30, "none": 0, "c": 3600})
            report.add(Metric("a", "x", 1.0))
            report.write()
            self.assertIn("\nNot run at this size, with what they would take on one processor: b (30 s), c (1 h).\n", report.path.read_text())
            for case in ("c", "b"):
                report.add(Metric(case, "x", 1.0))
            report.write()
            text = report.path.read_text()
            self.assertNotIn("Not run", text)
            self.assertEqual([line.split(" | ")[0] for line in text.splitlines() if line[:2] == "| "][1:], ["| a", "| b", "| c"])


class Bubbles(Scored):
    def test_a_single_bubble(self):
        ref = series.table("P1/bubble_single_vof3d.csv")
        t = samples(0.16, 0.001)
        z = np.interp(t, ref["t_s"], ref["z_centroid"])
        good = made(t, centre=z, top=z + 0.0024, bottom=z - 0.0024, right=0.00735, left=-0.00735)
        for full in (False, True):
            self.check(good, lambda r, full=full: bubbles.score_single("c", r, full),
                       scaled("centre", 0.85, 0.025), moved("top", 6e-4))

    def test_the_spread_over_delta(self):
        t = samples(0.14, 0.001)

        def rising(speed: float, swing: float = 1e-4) -> Made:
            volume = 1 + swing * np.sin(150 * t)
            return made(t, centre=0.025 + speed * t, velocity=speed + swing * np.sin(150 * t), volume=volume)

        near = [rising(s) for s in (0.207, 0.208, 0.209, 0.21)]
        far = [rising(s, w) for s, w in ((0.2, 0.01), (0.22, 0.03), (0.18, 0.06), (0.25, 0.1))]

        def scored(with_, without):
            return list(bubbles.score_correction("c", {"with": with_, "without": without}, (0.08, 0.14)))

        def missed(with_, without):
            return [m.name for m in scored(with_, without) if not m.passed]

        all_four = "with the volume correction, delta 0.125, 0.5, 1, 3: spread of the speed"
        factor = [f"delta {delta}: the same without it, over that" for delta in ("0.125", "0.5", "1", "3")]
        ratio, ends = "spread of the curves, with over without", "with the volume correction: runs that came to their end, with delta "
        self.assertEqual(missed(near, far), [])
        self.assertEqual(missed(near, [*far[:3], None]), [])
        damped = "the same, delta 0.5, 1, 3"
        self.assertEqual(missed(far, near), [all_four, damped, *factor, ratio])
        self.assertEqual(missed(far, [*near[:3], None]), [all_four, damped, *factor[:3], ratio])
        self.assertEqual(missed([*near[:3], None], far), [f"{ends}0.125, 0.5, 1"])
        self.assertEqual(missed(near, [None, None, None, far[3]]), ["deltas with which both forms come to their end"])

    def shots(self, apart: Callable[[float], float]) -> list[Snapshot]:
        """Two balls of gas whose distance is a function of time, in snapshots 5 ms apart."""
        dx = 5e-4
        axis = np.arange(-0.005 + dx / 2, 0.005, dx)
        ball = np.array(np.meshgrid(axis, axis, axis)).reshape(3, -1).T
        ball = ball[np.sum(ball**2, axis=1) < 0.005**2]
        shots = []
        for t in samples(0.2, 0.005):
            x = np.concatenate([ball, ball + [0, 0, apart(t)]])
            shots.append(Snapshot(float(t), dx, x, np.ones(len(x), int), np.zeros(len(x))))
        return shots

    def test_two_bubbles(self):
        ref = series.table("P1/bubble_double_vof3d.csv")
        t = samples(0.2, 0.001)
        shots = self.shots(lambda t: 0.0099 + 0.1 * max(0, 0.164 - t))
        good = made(t, shots, centre=np.interp(t, ref["t_s"], ref["z_centroid"]))
        for full in (False, True):
            self.check(good, lambda r, full=full: bubbles.score_double("c", r, full),
                       changed("centre", lambda t, v: 0.0175 + 0.18 * t), shown(lambda s: self.shots(lambda _: 0.012)[0]))

    def test_sussman(self):
        ref, unit = series.table("P2/bubble_sussman_vof_R64.csv"), np.sqrt(0.025 / 9.81)
        t = samples(0.165, 0.001)

        def of(column: str) -> np.ndarray:
            return 0.025 * np.interp(t / unit, ref["t"], ref[column])

        good = made(t, centre=of("y_c"), right=0.075 + of("half_width"), left=0.075 - of("half_width"),
                    film=of("y_axis_high") - of("y_axis_low"))
        for full in (False, True):
            self.check(good, lambda r, full=full: bubbles.score_sussman("c", r, full),
                       moved("centre", 0.1 * 0.025), moved("right", 0.2 * 0.025), moved("film", 0.1 * 0.025))

    def test_hysing(self):
        t = samples(3, 0.01)
        # As the benchmark's: up to 0.2417 at 0.92, falling to 0.19 afterwards; the centre ends at 1.081.
        velocity = np.where(t < 0.92, 0.2417 * np.sin(np.pi / 2 * t / 0.92), 0.1933 + 0.0484 * np.exp(-((t - 0.92) / 0.6) ** 2))
        centre = 0.5 + np.concatenate([[0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * 0.01)])
        centre = 0.5 + (centre - 0.5) * 0.581 / (centre[-1] - 0.5)
        good = made(t, velocity=velocity, centre=centre, roundness=1 - 0.099 * np.exp(-((t - 1.9) / 0.8) ** 2))
        for full in (False, True):
            self.check(good, lambda r, full=full: bubbles.score_hysing("c", r, full),
                       moved("centre", 0.03), scaled("velocity", 0.92), moved("roundness", 0.02))


class Drops(Scored):
    def shot(self, dimensions: int, factor: float = 1, ripple: float = 0) -> Snapshot:
        """A drop of the size at rest, on a fine lattice, in its gas."""
        size, dp = drops.laplace(f"{dimensions}D")
        dx = 5e-4 if dimensions == 2 else 1e-3
        axis = np.arange(-0.03 + dx / 2, 0.03, dx)
        x = np.array(np.meshgrid(*[axis] * dimensions)).reshape(dimensions, -1).T
        phase = (np.sum(x**2, axis=1) > (factor * size) ** 2).astype(int)
        pressure = np.where(phase == 0, dp * (1 + ripple * np.cos(5000 * x[:, 0])), 0)
        places = np.full((len(x), 3), 0.0)
        places[:, :dimensions] = x + drops.MIDDLE
        return Snapshot(0.5, dx, places, phase, pressure)

    def test_at_rest_at_the_end(self):
        t = samples(0.5, 0.002)
        for dimensions in (2, 3):
            key = f"{dimensions}D"
            good = made(t, [self.shot(dimensions)], jump=drops.laplace(key)[1] * (1 - np.exp(-20 * t)))
            for full in (False, True):
                self.check(good, lambda r, key=key, d=dimensions, full=full: drops.score_drop("c", key, d, r, full),
                           scaled("jump", 0.5), shown(lambda _, d=dimensions: self.shot(d, 1.03)))

    def test_the_swing(self):
        ref = series.table("P2/square_droplet2d_vof.csv")
        t = samples(2, 0.002)
        # Through the samples of the reference, which are 10 ms apart, the swing cannot be seen: theory's instead.
        def swinging(period: float) -> Made:
            return made(t, kinetic=0.008 * np.exp(-2 * 8.4255 * t) * np.sin(2 * np.pi * t / period) ** 2)

        good, slow = swinging(0.0893), swinging(0.12)
        self.check(good, lambda r: drops.score_calm("c", r), moved("kinetic", 1e-4))
        period, decay = drops.swing(good)
        self.assertAlmostEqual(period, 0.0893, delta=0.001)
        self.assertAlmostEqual(decay, 8.43, delta=0.3)
        at_50 = "period of the swing at l/50, off by"
        self.check(good, lambda r: (m for m in drops.score_swings("c", (50, 100), (swinging(0.1), r)) if m.name != at_50), lambda _: slow)
        self.check(swinging(0.1), lambda r: (m for m in drops.score_swings("c", (50, 100), (r, good)) if m.name == at_50), lambda _: slow)
        self.assertLess(ref["KE"][-1] / ref["KE"].max(), 1e-3)

    def test_the_swing_of_a_cube(self):
        ref = series.table("P2/cubic_droplet3d_vof.csv")
        t = samples(0.3, 0.002)

        def swinging(slower: float) -> Made:
            half = np.interp(t / slower, ref["t_s"], ref["x_extent"])
            return made(t, right=half, left=-half)

        self.check(swinging(1.1), lambda r: drops.score_cube("c", (30, 50), (swinging(1.3), r)), lambda _: swinging(1.4))

    def test_a_round_drop(self):
        t = samples(0.5, 0.002)
        good = made(t, [self.shot(2, ripple=0.01)], speed=0.005, mass_drop=1.6, momentum_x=1e-6, momentum_y=-1e-6, jump=44.3)
        self.check(good, lambda r: drops.score_static("c", r, 0.004), scaled("speed", 20), scaled("jump", 1.2),
                   shown(lambda _: self.shot(2, ripple=0.2)))

    def test_a_drop_that_drifts(self):
        good = made(samples(0.5, 0.002), [self.shot(2)], mass_drop=1.6, momentum_x=1e-6, momentum_y=-1e-6)
        self.check(good, lambda r: drops.score_drift("c", r, 50), scaled("momentum_y", 1e5))

    def test_a_flat_interface(self):
        t = samples(0.3, 0.005)
        heights = [f"h{k}" for k in range(5)]
        good = made(t, speed=0.01, speed_gas=0.1, escaped=0, coverage=0.9, mass_liquid=20, mass_gas=0.02, **dict.fromkeys(heights, 0.1))

        def sunk(r: Run) -> Run:
            for name in heights:
                r = moved(name, -0.002)(r)
            return r

        self.check(good, lambda r: rest.score_flat("c", r, 0.004), moved("h3", 0.01), sunk, scaled("speed", 10))


class Interfaces(Scored):
    def test_spikes_and_bubbles(self):
        t = samples(3.05, 0.05)
        for atwood in interfaces.LIGHT:
            ref = series.table(f"P1/rt3d_vof_At{atwood}.csv")
            good = made(t, spike=np.interp(t, ref["t"], ref["z_spike"]), bubble=np.interp(t, ref["t"], ref["z_bubble"]))
            for full in (False, True):
                self.check(good, lambda r, a=atwood, full=full: interfaces.score_spikes("c", a, r, full),
                           moved("spike", 0.1), moved("bubble", -0.05))

    def test_fronts(self):
        ref = series.table("P1/lock_exchange_vof2d_freeslip.csv")
        t = samples(1.265, 0.01)
        good = made(t, light=0.905 + 0.2 * np.interp(t, ref["t_s"], ref["light_front_over_H"]),
                    heavy=0.905 - 0.2 * np.interp(t, ref["t_s"], ref["heavy_front_over_H"]))
        for full in (False, True):
            self.check(good, lambda r, full=full: interfaces.score_fronts("c", interfaces.front_speeds(r), full),
                       scaled("light", 0.9, 0.905), scaled("heavy", 0.9, 0.905))

    def test_means_converge_where_starts_tell(self):
        def row(coarse: list[float], fine: list[float]) -> Metric:
            return next(interfaces.converges_in_the_mean("c", "v", np.array(coarse), np.array(fine), 1))

        for coarse, fine, scored, passed in (([0.8, 0.81, 0.82], [0.9, 0.91, 0.92], True, True), ([0.9, 0.91, 0.92], [0.8, 0.81, 0.82], True, False),
                                             ([0.98, 1, 1.03], [0.99, 1.01, 1.02], False, True), ([0.98, 1, 1.03], [1.01], False, True),
                                             ([0.98, 1, 1.03], [1.1], True, False)):
            self.assertEqual((row(coarse, fine).scored, row(coarse, fine).passed), (scored, passed))

    def test_tips(self):
        ref = series.table("P2/rt2d_vof_noslip_256.csv")
        t = samples(5, 0.02)
        good = made(t, high=np.interp(t, ref["t"], ref["y_high"]), low=np.interp(t, ref["t"], ref["y_low"]))
        for full in (False, True):
            self.check(good, lambda r, full=full: interfaces.score_tips("c", r, full),
                       moved("high", -0.06), moved("low", 0.06))

    def test_growth(self):
        x, y = np.meshgrid(0.05 + 0.1 * np.arange(10), 0.05 + 0.1 * np.arange(20))
        places = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
        heavy = (places[:, 1] < 1).astype(int)

        def shot(t: float, rate: float, shift: float) -> Snapshot:
            up = 0.01 * np.exp(rate * t) * np.cos(2 * np.pi * places[:, 0] + shift) * np.exp(-6 * np.abs(places[:, 1] - 1))
            return Snapshot(t, 0.1, places, heavy, None, velocity=np.column_stack([0 * up, up, 0 * up]))

        def wave(rate: float, shift: float = 0) -> Made:
            return made(samples(1, 1), [shot(t, rate, shift) for t in samples(1, 0.1)])

        self.check(wave(1.1446), lambda r: interfaces.score_growth("c", r), lambda _: wave(1.34), lambda _: wave(-1),
                   lambda _: wave(1.1446, np.pi))


class Incompressible(Scored):
    def test_vortices(self):
        t = samples(4.9, 0.01)
        decay = np.exp(-8 * np.pi**2 * t / 100)
        good = made(t, speed=decay, kinetic=0.25 * decay**2, momentum_x=0, momentum_y=0, density_least=1, density_greatest=1)
        self.check(good, lambda r: incompressible.score_decay("c", 30, r), scaled("speed", 1.05), changed("momentum_y", lambda t, v: v + 1e-6 * t),
                   changed("density_least", lambda t, v: v - 0.02 * (t > 1)))
        beside = made(t, kinetic=0.5 + 0.25 * decay**2, momentum_x=1, momentum_y=0)
        self.check(beside, lambda r: incompressible.score_moved("c", 60, good, r), moved("kinetic", 0.02))

    def test_layers(self):
        t = samples(0.5, 0.01)
        good = made(t, error=5, speed=0.002, escaped=0)
        self.check(good, lambda r: incompressible.score_layers("c", "layers", 1000, r), scaled("error", 3), scaled("speed", 10), moved("escaped", 1))

    def test_drops(self):
        ref = series.table("P4/droplet_rho1_vof_noslip_256.csv")
        t = samples(0.7, 0.002)
        good = made(t, x_q=0.5 + np.interp(t, ref["t"], ref["x_q"]), jump=5.333, momentum_x=0, momentum_y=0, density_least=1, density_greatest=1)
        for full in (False, True):
            self.check(good, lambda r, full=full: incompressible.score_kicked("c", r, full), scaled("x_q", 0.9, 0.5),
                       changed("x_q", lambda t, v: np.interp(0.9 * t, t, v)), changed("momentum_x", lambda t, v: t), scaled("density_greatest", 1.02),
                       changed("density_greatest", lambda t, v: v + 0.02 * (t > 0.1)))
        ref = series.table("P4/droplet_rho3_vof_32.csv")
        t = samples(21, 0.05)
        good = made(t, x_q=6 + np.interp(t, ref["t"], ref["x_q"]), escaped=0)
        self.check(good, lambda r: incompressible.score_ellipse("c", 48, r, 0.04), changed("x_q", lambda t, v: np.interp(0.9 * t, t, v)), moved("escaped", 1))

    def test_a_damped_period(self):
        t = samples(0.7, 0.005)
        for period in (0.35, 0.37, 0.4):
            swing = 0.079 + 0.02 * np.exp(-5 * t) * np.cos(2 * np.pi * t / period - 1.3)
            self.assertAlmostEqual(incompressible.damped_period(t, swing), period, delta=1e-6)

    def test_a_density_may_be_off_by_its_tolerance_and_no_more(self):
        t = samples(4.9, 0.01)
        for off, passes in ((0.0099999, True), (0.01001, False)):
            r = made(t, speed=1, momentum_x=0, momentum_y=0, density_least=1 - off * (t > 1), density_greatest=1)
            self.assertEqual([m.passed for m in incompressible.score_decay("c", 30, r) if "density" in m.name], [passes])

    def test_a_drop_in_shear(self):
        lattice = np.stack(np.meshgrid(*2 * [np.linspace(-3, 3, 241)]), axis=-1).reshape(-1, 2)
        for ca, ratio, of_reference in ((0.15, 1, 0.1549), (0.2, 1, 0.2059), (0.15, 0.1, 0.1532)):
            def drop(deformed: float, ca: float = ca) -> Run:
                """An ellipse of axes 1 + D and 1 - D, aslant, in a liquid."""
                turn = np.array([[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]])
                inside = np.sum((lattice @ turn.T / [1 + deformed, 1 - deformed]) ** 2, axis=1) < 1
                places = np.column_stack([lattice + [4.2, 3.9], 0 * lattice[:, 0]])
                return made(samples(1, 1), [Snapshot(1, 0.025, places, 1 - inside.astype(int), None)])

            self.assertAlmostEqual(incompressible.deformation(drop(0.3).last()), 0.3, delta=0.003)
            for full in (False, True):
                self.check(drop(of_reference), lambda r, ca=ca, ratio=ratio, full=full: incompressible.score_shear("c", ca, ratio, r, full),
                           lambda _: drop(0.8 * of_reference))

    def test_tips(self):
        ref = series.table("P2/rt2d_vof_noslip_256.csv")
        t = samples(5, 0.02)
        good = made(t, high=np.interp(t, ref["t"], ref["y_high"]), low=np.interp(t, ref["t"], ref["y_low"]), density_least=1,
                    density_greatest=1.8, coverage=0.9, escaped=0)
        good.summary["uncorrected"] = 0
        self.check(good, lambda r: incompressible.score_tips("c", [r]), moved("high", -0.06), moved("low", 0.06), scaled("density_least", 0.98),
                   scaled("coverage", 0.5), moved("escaped", 1), lambda r: replace(r, summary=r.summary | {"uncorrected": 1}))


class Differences(Scored):
    def test_vortices(self):
        t = samples(4.9, 0.01)
        good = made(t, speed=np.exp(-8 * np.pi**2 * t / 100), density_least=1, density_greatest=1)
        for n in differences.LIMITS:
            self.check(good, lambda r, n=n: differences.score_vortices("c", n, r), scaled("speed", 1.05))

    def test_the_laplacian_of_frankes_function(self):
        def f(x: np.ndarray, y: np.ndarray) -> np.ndarray:
            return sum(a * np.exp(g(x, y)) for a, _, g in differences.EXPONENTS)

        x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 7))
        d = 1e-4
        by_differences = (f(x + d, y) + f(x - d, y) + f(x, y + d) + f(x, y - d) - 4 * f(x, y)) / d**2
        np.testing.assert_allclose(differences.franke_laplacian(x, y), by_differences, atol=1e-4)
        # The function itself, where Franke gives it: its height in the corner.
        self.assertAlmostEqual(float(f(np.float64(0), np.float64(0))), 0.7664205912849231, places=12)

    def test_errors_of_operators_are_of_the_square_alone(self):
        axis = np.linspace(-0.1, 1.1, 49)
        x, y = (a.ravel() for a in np.meshgrid(axis, axis))
        outside = (x < -1e-9) | (x > 1 + 1e-9) | (y < -1e-9) | (y > 1 + 1e-9)
        made_of_it = 1.03 * differences.franke_laplacian(x, y) + 1e6 * outside
        s = Snapshot(0, axis[1] - axis[0], np.column_stack([x, y, 0 * x]), 0 * x, None, acceleration=np.column_stack([made_of_it, 0 * x, 0 * x]))
        self.assertAlmostEqual(differences.franke_error(s), 0.03, places=12)

    def test_profiles(self):
        y = np.linspace(-0.975, 0.975, 40)

        def flow(ratio: float, error: float) -> Run:
            """Two parabolas of one stress, -y + c, that meet at the interface with one velocity, all of it too fast by a part."""
            c = (ratio - 1) / (2 * (ratio + 1))
            u = np.where(y < 0, (-y**2 / 2 + c * y + 0.5 + c) / ratio, -y**2 / 2 + c * y + 0.5 - c)
            places = np.column_stack([0 * y, y, 0 * y])
            shot = Snapshot(0.75, 0.05, places, (y > 0).astype(int), None, velocity=np.column_stack([(1 + error) * u, 0 * y, 0 * y]))
            return made(samples(1, 1), [shot])

        self.assertAlmostEqual(differences.profile_error(5, flow(5, 0).last()), 0, places=12)
        for operator, of_a_lattice in (("harmonic", 0.0132), ("conservative", 0.0132), ("divtau", 0.0477), ("sph", 0.0132)):
            self.check(flow(5, of_a_lattice), lambda r, operator=operator: differences.score_profile("c", 5, operator, r),
                       lambda _, of=of_a_lattice: flow(5, 1.3 * of))
        for operator, most in (("harmonic", 0.01), ("divtau", 0.02)):
            self.check(flow(5, 0.9 * most), lambda r, operator=operator: differences.score_square("c", 5, operator, r),
                       lambda _, most=most: flow(5, 1.1 * most))

    def test_a_bubble_in_a_tube(self):
        ref = series.table("P5/bubble_vof_axi_W2D_diam_D64.csv")
        t = samples(4.5, 0.05)
        height, width = (np.interp(t, ref["t"], ref[name]) for name in ("height", "width"))
        good = made(t, centre=np.interp(t, ref["t"], ref["y_c"]), speed=0.16, top=3 + height / 2, bottom=3 - height / 2, right=width / 2, left=-width / 2)
        for tolerance in (0.06, 0.12):
            self.check(good, lambda r, tolerance=tolerance: differences.score_rise("c", "D/8", r, 4.5, tolerance),
                       scaled("centre", 1.15, 2), moved("top", 0.15), moved("left", -0.2))


class Vortices(Scored):
    def test_a_cavity(self):
        """Speeds with the extremes of the reference, on places that are nowhere on the lines; snapshots from before and after are others."""
        rng = np.random.default_rng(3)

        def flow(factor: float, reynolds: int, scheme: str) -> Run:
            least_u, greatest_v, least_v = vortices.GHIA[reynolds]
            shots = []
            for k in range(-2, vortices.SHOTS + 2):
                places = rng.random((2500, 2))
                x, y = places.T
                u = factor * least_u * np.exp(-(((y - 0.42) / 0.2) ** 2)) + 0.1 * (x - 0.5)
                v = factor * (greatest_v * np.exp(-(((x - 0.24) / 0.13) ** 2)) + least_v * np.exp(-(((x - 0.81) / 0.13) ** 2))) + 0.1 * (y - 0.5)
                asked = 0 <= k < vortices.SHOTS
                shots.append(Snapshot(vortices.steady_from(reynolds, scheme) + vortices.INTERVAL * k, 0.02, np.column_stack([places, 0 * x]), 0 * x, None,
                                      velocity=np.column_stack([u, v, 0 * x]) + (0 if asked else 1)))
            return made(samples(1, 1), shots)

        for reynolds in vortices.GHIA:
            for scheme in vortices.SCHEMES:
                self.check(flow(1, reynolds, scheme), lambda r, re=reynolds, scheme=scheme: vortices.score_cavity("c", re, scheme, r),
                           lambda _, re=reynolds, scheme=scheme: flow(1.12, re, scheme))

    def test_damping(self):
        t = samples(vortices.END, 0.01)
        rate = 16 * np.pi**2 * vortices.VISCOSITY
        good = made(t, kinetic=0.25 * np.exp(-rate * t) * np.where(t < 0.9 * vortices.BEGIN, 1.2, 1))
        self.assertAlmostEqual(vortices.effective_viscosity(good), 1)
        for scheme in vortices.DAMPED:
            for factor in (0.8, 1.2):
                self.check(good, lambda r, scheme=scheme: vortices.score_damping("c", scheme, 40, r),
                           changed("kinetic", lambda t, v, factor=factor: v * np.exp((1 - factor) * rate * t)))


class Real(Scored):
    """Tension and viscosity of real fluids, against exact answers."""

    def test_a_drop_at_rest(self):
        t = samples(8, 0.05)
        good = made(t, jump=1 + 0.3 * (t < 4), volume=np.pi, x=0.013 + 2e-4 * t / 8, y=0.007, inside=np.where(t < 4, 1, 1e-4), outside=1e-4)
        for scheme in tensions.SCHEMES:
            for ratio in (1, 1000):
                self.check(good, lambda r, s=scheme, ratio=ratio: tensions.score_rest("c", "", s, ratio, 16, 0.1, r),
                           scaled("jump", 1.03), moved("inside", 0.1), moved("outside", 0.1), changed("x", lambda t, v: v + 2e-3 * t))

    def test_a_drop_on_a_floor(self):
        good = made(samples(6, 0.05), right=1.01, left=-0.99, top=1)
        self.check(good, lambda r: tensions.score_standing("c", "", 8, r), scaled("right", 1.15), scaled("top", 0.9))

    def test_a_lens(self):
        good = made(samples(8, 0.1), volume=np.pi, right=1.39, left=-1.38, top=0.8, bottom=-0.8)
        self.check(good, lambda r: tensions.score_floating("c", "", 8, r), scaled("right", 1.2), scaled("bottom", 0.6))

    def test_a_ripple(self):
        _, omega, nu = tensions.rippling("interfacial", 16)
        t = samples(25 / omega, 0.1 / omega)
        height = capillary.standing_wave(np.maximum(t, 1e-9), 2 * np.pi, nu, 1, 1, 1, 0, tensions.HEIGHT * omega)
        good = made(t, crest=0.3 + height, trough=0.3 - height)
        self.check(good, lambda r: tensions.score_ripple("c", "", 0.01, omega, nu, r), scaled("crest", 1.1))

    def test_a_drop_that_swings(self):
        def drop(dim: int, n: int, t: float, size: float) -> Snapshot:
            """Points of a ball, drawn out by a flow of one mode."""
            points = np.stack(np.meshgrid(*[np.linspace(-1, 1, 21)] * dim), -1).reshape(-1, dim)
            points = np.pad(points[np.sum(points**2, 1) < 1], ((0, 0), (0, 3 - dim)))
            x, y, z = points.T
            way = np.column_stack([-0.5 * x, -0.5 * y, z]) if dim == 3 else np.column_stack(
                [np.real((x + 1j * y) ** (n - 1)), -np.imag((x + 1j * y) ** (n - 1)), 0 * x])
            return Snapshot(t, 0.1, points + size * way, np.zeros(len(points), int), None)

        def run(dim: int, n: int, omega: float, damping: float) -> Made:
            t = samples(4 * 2 * np.pi / omega, 0.1 / omega)
            return made(t, [drop(dim, n, at, 0.02 * np.exp(-damping * at) * np.sin(omega * at)) for at in t], kinetic=0)

        for dim, n, ratio in ((2, 2, 1000), (2, 3, 1000), (3, 2, 100)):
            _, omega, damping = tensions.swinging("incompressible", dim, n, 8, ratio)
            for scheme in tensions.SCHEMES:
                self.check(run(dim, n, omega, damping), lambda r, s=scheme, d=dim, n=n, o=omega, g=damping: tensions.score_swing_of("c", "", s, d, n, o, g, r),
                           lambda _, d=dim, n=n, o=omega, g=damping: run(d, n, 1.03 * o, 1.5 * g))

    def test_a_wave(self):
        n = waves.root(1e-3)
        self.assertAlmostEqual(n.imag, np.sqrt(2 * np.pi * np.tanh(np.pi)), delta=0.01)  # of no viscosity
        t = samples(waves.PERIODS * 2 * np.pi / n.imag, 0.02 / n.imag)
        height = 0.03 * np.exp(n.real * t) * np.sin(n.imag * t)
        good = made(t, crest=height, trough=-height, centre=-0.25)
        slow = 0.03 * np.exp(1.1 * n.real * t) * np.sin(n.imag * t / 1.02)
        self.check(good, lambda r: waves.score_wave("c", "", n, r), lambda _: made(t, crest=slow, trough=-slow, centre=-0.25 + 2e-3 * (t > 0)))

    def test_three_bubbles(self):
        t = samples(1.2, 0.01)
        good = made(t, speed=0.2 * np.tanh(5 * t))
        for across in (6, 8):
            self.check(good, lambda r, n=across: bubbles.score_ten("c", n, {"a": r, "b": good, "c": made(t, speed=0.196 * np.tanh(5 * t))}),
                       scaled("speed", 1.2), scaled("speed", 0.8))
        each = {name: made(t, speed=speed * np.tanh(5 * t)) for name, speed in (("a", 0.337), ("b", 0.345), ("c", 0.362))}
        self.assertFalse(list(bubbles.score_ten("c", 6, each))[-1].passed, "each within 5 % of their mean, but 7 % apart")

    def test_growth(self):
        t = samples(1, 0.01)
        self.check(made(t, kinetic=1 - 0.1 * t), lambda r: drops.score_growth("c", "l/50", r), changed("kinetic", lambda t, v: v + 0.2 * t))


if __name__ == "__main__":
    unittest.main()

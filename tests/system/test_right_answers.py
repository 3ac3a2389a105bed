#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flows whose right answer is known, and that once had another without a word: each is run to its end from the command line, as anyone would."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, IN_MEMORY, ROOT, at_length, of_nightly  # noqa: E402

# Still water with a free surface that drifts along a periodic channel.
SWELL = """
dimensions: 2
resolution: 16
domain: {min: [0, 0], max: [2, 1], periodic: [x]}
gravity: [0, -1]
fluids: [{name: water, density: 1000, sound_speed: 20, pressure: hydrostatic, velocity: [SPEED, 0], shape: [{box: {min: [0, 0], max: [2, 0.5]}}]}]
walls: [{name: floor, shape: [{half_space: {point: [0, 0], normal: [0, 1]}}]}]
scheme: SCHEME
end_time: 1
probes: [{name: height, mass_centre: {axis: y}}, {name: potential, potential_energy: {}}]
output: {probe_interval: 0.05}
"""
# A round drop that flies diagonally through a periodic box, without gravity.
LUMP = """
dimensions: 2
resolution: 20
domain: {min: [-1, -1], max: [1, 1], periodic: [x, y]}
fluids: [{name: water, density: 1000, sound_speed: 20, velocity: [SPEED, SPEED], shape: [{ball: {centre: [0, 0], radius: 0.5}}]}]
scheme: SCHEME
end_time: 1
probes: [{name: kinetic, kinetic_energy: {}}, {name: most, extremum: {field: density, which: max}}, {name: across, extent: {fluid: water, axis: y, which: max}}]
output: {probe_interval: 0.05}
"""
# A bubble in a liquid ten times as dense between sides with slip; lengths in diameters, gravity of 1.
BUBBLE = """
dimensions: {dimensions}
resolution: 8
domain: {{min: {low}, max: {high}}}
gravity: {gravity}
fluids:
  - {{name: liquid, density: 10, viscosity: 0.3, sound_speed: 20, pressure: hydrostatic}}
  - {{name: gas, density: 1, viscosity: 0.03, sound_speed: 20, pressure: {start}, shape: [{{ball: {{centre: {centre}, radius: 0.5}}}}]}}
interfaces: [{tension}]
walls:
  - {{name: sides, shape: [{sides}]}}
  - {{name: ends, slip: none, shape: [{ends}]}}
scheme: {{{scheme}: {{}}}}
end_time: 1
probes: [{{name: velocity, velocity: {{fluid: gas, axis: {axis}}}}}]
output: {{probe_interval: 0.02}}
"""
# A ball, or half of one, that swings along the cut through a full tank.
SWINGING = """
dimensions: 2
resolution: 12
domain: {{min: [{low}, 0], max: [1, 2]}}
gravity: [0, -1]
fluids: [{{name: liquid, density: 1000, viscosity: 8, sound_speed: 15, pressure: hydrostatic}}]
walls:
  - {{name: ball, slip: none, shape: [{{ball: {{centre: [0, 1], radius: 0.25}}}}], motion: {{sine: {{amplitude: [0, 0.15], frequency: 1}}}}}}
  - {{name: sides, shape: [{{outside: true, box: {{min: [{low}, -1], max: [1, 3]}}}}]}}
  - {{name: ends, slip: none, shape: [{{half_space: {{point: [0, 0], normal: [0, 1]}}}}, {{half_space: {{point: [0, 2], normal: [0, -1]}}}}]}}
scheme: {{{scheme}: {{}}}}
end_time: 0.6
probes: [{{name: kinetic, kinetic_energy: {{}}}}]
output: {{probe_interval: 0.02}}
"""
# A full tank whose only wall has a belt's speed along x: its sides have it across themselves.
BELT = """
dimensions: 2
resolution: 16
domain: {min: [0, 0], max: [2, 1]}
fluids: [{name: water, density: 1000, viscosity: 10, sound_speed: 20}]
walls: [{name: tank, slip: none, surface_velocity: [0.5, 0], shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}]
scheme: SCHEME
end_time: 0.5
probes: [{name: kinetic, kinetic_energy: {}}]
"""
# A belt around a body in a liquid of next to no viscosity.
BODY = """
dimensions: 2
resolution: 12
domain: {min: [0, 0], max: [2, 1]}
fluids: [{name: water, density: 1000, viscosity: 1e-6, sound_speed: 20}]
walls:
  - {name: tank, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}
  - {name: belt, slip: SLIP, surface_velocity: [1, 0], shape: [SHAPE]}
scheme: SCHEME
end_time: 0.2
probes: [{name: kinetic, kinetic_energy: {}}]
output: {probe_interval: 0.02}
"""
# Water of unlike depth on two sides of a dam.
DAM = """
dimensions: 2
resolution: 16
domain: {min: [0, 0], max: [2, 1]}
gravity: [0, -1]
fluids:
  - {name: low, density: 1000, sound_speed: 20, pressure: hydrostatic, shape: [{box: {min: [0, 0], max: [1, 0.25]}}]}
  - {name: high, density: 1000, sound_speed: 20, pressure: hydrostatic, shape: [{half_space: {point: [FAR, 0], normal: [-1, 0]}}, {operation: intersect, box: {min: [0, 0], max: [2, 0.75]}}]}
walls: [{name: tank, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}, {name: dam, shape: [SHAPE]}]
scheme: riemann
end_time: 0.3
probes: [{name: kinetic, kinetic_energy: {fluid: low}}]
"""
# An impulse of 1 m/s on all of a periodic box.
PULSE = """
dimensions: 2
resolution: 8
domain: {min: [0, 0], max: [1, 1], periodic: [x, y]}
gravity: ["exp(-((t - 0.1)/WIDTH)^2)/WIDTH/sqrt(pi)", 0]
fluids: [{name: water, density: 1000, viscosity: 1, sound_speed: 20}]
scheme: SCHEME
end_time: 0.2
probes: [{name: velocity, velocity: {axis: x}}]
"""
# Still water in a tank that is at X.
STILL = """
dimensions: 2
resolution: 20
domain: {min: [X, 0], max: ["X + 2", 1]}
gravity: [0, -1]
fluids: [{name: water, density: 1000, sound_speed: 20, pressure: hydrostatic, shape: [{box: {min: [X, 0], max: ["X + 2", DEPTH]}}]}]
walls: [{name: tank, shape: [{outside: true, box: {min: [X, 0], max: ["X + 2", 1]}}]}]
scheme: SCHEME
end_time: 0.01
probes: [{name: wall, height: {fluid: water, at: [X]}}, {name: open, height: {fluid: water, at: ["X + 1"]}}]
"""
# A strip that leans, as its mirror image does.
COLUMN = """
dimensions: 2
resolution: 20
domain: {min: [0, 0], max: [3, 1.2]}
gravity: [0, -1]
fluids: [{name: liquid, density: 1000, sound_speed: 20, pressure: hydrostatic, shape: [{box: {min: [0, 0], max: [0.5, 1]}}]}]
walls: [{name: tank, shape: [{outside: true, box: {min: [0, 0], max: [3, 1.2]}}]}]
scheme: SCHEME
end_time: 1
probes:
  - {name: wall, height: {fluid: liquid, at: [0]}}
  - {name: near, height: {fluid: liquid, at: [0.01]}}
  - {name: open, height: {fluid: liquid, at: [0.05]}}
output: {probe_interval: 0.1}
"""
STRIP = """
dimensions: 2
resolution: 20
domain: {min: [-1, 0], max: [1, 1]}
fluids:
  - {name: a, density: 1000, sound_speed: 20, shape: [{formula: "abs(y - 0.5 - SLOPE*x) < 0.2 and abs(x) < 0.5"}]}
  - {name: b, density: 1000, sound_speed: 20}
walls: [{name: tank, shape: [{outside: true, box: {min: [-1, 0], max: [1, 1]}}]}]
scheme: riemann
end_time: 0.01
probes: [{name: area, surface_area: {fluid: a}}, {name: round, roundness: {fluid: a}}]
"""
SCHEMES = ("dissipation", "interfacial", "riemann", "{incompressible: {reference_speed: 1}}", "{differences: {reference_speed: 1}}")
# For `hydrostatic`, in place of its first two.
PROBES = ("probes[0]={name: coverage, coverage: {}}", "probes[1]={name: air, extremum: {field: velocity, fluid: air, which: max}}")


class RightAnswer(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-right-", dir=IN_MEMORY)
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)

    def told(self, case: str) -> str:
        """The name of a case, or the path that its text is written to."""
        if "\n" not in case:
            return case
        (self.home / "case.yaml").write_text(case)
        return str(self.home / "case.yaml")

    def complaints(self, case: str, *settings: str, out: "Path | None" = None, code: int = 0) -> str:
        """What a run says on standard error; the case by name, or its text."""
        words = [BUILD / "meniscus", "run", self.told(case), "--threads", "1", "--out", (out or Path(tempfile.mkdtemp(dir=self.home))) / "run"]
        words += [w for s in settings for w in ("--set", s)]
        environment = {**os.environ, "MENISCUS_CASES": str(ROOT / "server" / "cases")}
        done = subprocess.run([str(w) for w in words], env=environment, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr[-2000:])
        return done.stderr

    def probes(self, case: str, *settings: str) -> "dict[str, np.ndarray]":
        """Of a run to its end, all values."""
        out = Path(tempfile.mkdtemp(dir=self.home))
        self.complaints(case, *settings, out=out)
        return self.values(out)

    def values(self, out: Path) -> "dict[str, np.ndarray]":
        """Of the run that was made there."""
        with h5py.File(out / "run" / "probes.hdf") as f:
            return {name: values[:] for name, values in f["probes"].items()}


class Walls(RightAnswer):
    """Surfaces that move pump nothing, and what is on one side of a wall does not push what is on the other."""

    def test_what_is_across_a_surface_moves_nothing(self) -> None:
        for scheme in SCHEMES if at_length() else SCHEMES[-2:]:
            case = BELT.replace("SCHEME", scheme)
            self.assertLess(abs(self.probes(case)["kinetic"][-1] - 16), 1.2, scheme)  # 15.1 to 17.0, on the way to 22 of finer ones; 250 where the sides pump
        self.assertIn("walls[0].surface_velocity: 100 % of it is lost on the flat face", self.complaints(case))

    def test_a_belt_around_a_body_drags_and_does_not_pump(self) -> None:
        for shape in ("{box: {min: [0.75, 0.25], max: [1.25, 0.75]}}", "{ball: {centre: [1, 0.5], radius: 0.25}}"):
            for slip, most in (("none", 1e-9), ("free", 1e-20)):  # without viscosity to speak of; up to 14 J where edges pump
                for scheme in SCHEMES:
                    case = BODY.replace("SHAPE", shape).replace("SLIP", slip).replace("SCHEME", scheme)
                    kinetic = self.probes(case)["kinetic"].max()
                    self.assertLess(kinetic, most, (shape, slip, scheme))
                    self.assertEqual(kinetic > 1e-14, slip == "none", (shape, slip, scheme))  # friction's

    def test_a_thin_wall_is_refused_however_it_is_told(self) -> None:
        for shape in ("{box: {min: [1, 0], max: [1.0625, 1]}}", "{cylinder: {from: [1, 0.5], to: [1.0625, 0.5], radius: 0.5}}",
                      "{ball: {centre: [1.03125, 0.5], radius: 0.6}}, {operation: intersect, box: {min: [1, 0], max: [1.0625, 1]}}",
                      "{plate: {centre: [1.03125, 0.5], along: [0, 1], length: 1, thickness: 0.0625}}"):  # fmt: skip
            said = self.complaints(DAM.replace("FAR", "1.0625").replace("SHAPE", shape), code=65)
            self.assertRegex(said, r"walls\[1\]\.shape: dam is 0\.0[0-9]* m thick", shape)

    def test_a_neck_between_corners_is_refused(self) -> None:
        for over, where in ((0, "0 m thick near (1, 0.1875, 0) m"), (0.02, "0.0283 m thick near (1.01, 0.1775, 0) m")):
            shape = f"{{box: {{min: [0.8125, 0], max: [{1 + over}, 0.1875]}}}}, {{box: {{min: [1, {0.1875 - over}], max: [1.1875, 1]}}}}"
            self.assertIn(f"walls[1].shape: dam is {where}", self.complaints(DAM.replace("FAR", "1").replace("SHAPE", shape), code=65))

    def test_a_thick_one_holds(self) -> None:
        kinetic = self.probes(DAM.replace("FAR", "1.1875").replace("SHAPE", "{box: {min: [1, 0], max: [1.1875, 1]}}"))["kinetic"]
        self.assertLess(kinetic.max(), 0.05)


class Pulses(RightAnswer):
    def test_a_pulse_has_its_impulse(self) -> None:
        schemes = ["{incompressible: {reference_speed: 1}}", "{differences: {reference_speed: 1}}", "riemann", "interfacial", "dissipation"]
        for scheme in schemes if at_length() else schemes[:3]:
            for width in (0.02, 0.001):
                v = self.probes(PULSE.replace("SCHEME", scheme).replace("WIDTH", str(width)))["velocity"][-1]
                self.assertLess(abs(v - 1), 1e-3, (scheme, width))


class Places(RightAnswer):
    """Coordinates, edges and measures."""

    def still(self, x: float, depth: float, scheme: str = "riemann") -> str:
        text = STILL.replace('"X + 2"', f"{x + 2!r}").replace('"X + 1"', f"{x + 1!r}").replace("X", f"{x!r}")
        return text.replace("DEPTH", str(depth)).replace("SCHEME", scheme)

    def test_what_would_be_rounded_away_is_refused(self) -> None:
        self.assertIn("domain: a coordinate of", self.complaints(self.still(1e14, 0.5), code=65))
        self.assertIn("domain: a coordinate of", self.complaints(self.still(-1e12, 0.5), code=65))
        self.complaints(self.still(1e6, 0.5))

    def test_mass_that_the_lattice_does_not_hold_is_told(self) -> None:
        for depth, said in ((0.474, "water starts with 5.0 % less mass"), (0.476, "water starts with 5.0 % more mass"), (0.5, None)):
            complaints = self.complaints(self.still(0, depth))
            if said:
                self.assertIn(said, complaints)
            else:
                self.assertNotIn("mass", complaints)

    def test_mirror_images_have_one_surface(self) -> None:
        one, other = (self.probes(STRIP.replace("SLOPE", slope)) for slope in ("0.5", "(-0.5)"))
        for name in ("area", "round"):
            self.assertLess(abs(one[name][0] / other[name][0] - 1), 1e-9, name)  # 8e-4 where a surface is drawn along one diagonal alone

    def test_water_is_as_high_at_a_wall_as_it_is(self) -> None:
        for scheme in ("riemann", "dissipation"):
            p = self.probes(self.still(0, 0.5, scheme))
            for name in ("wall", "open"):
                self.assertLess(abs(p[name] - 0.5).max(), 0.5 * 0.05, (scheme, name))

    def test_water_that_falls_along_a_wall_is_as_high_there(self) -> None:
        """Its first column of particles is up to 0.84 spacings from the wall."""
        for scheme in ("riemann", "dissipation", "interfacial") if at_length() else ("riemann",):
            p = self.probes(COLUMN.replace("SCHEME", scheme))
            self.assertLess(p["open"].min(), 0.7)
            for name in ("wall", "near"):
                self.assertLess(abs(p[name] - p["open"]).max(), 0.5 * 0.05, (scheme, name))


class Shifting(RightAnswer):
    """It is made of differences of velocity, and stops at a free surface."""

    def test_water_that_drifts_stays_as_deep_as_it_is(self) -> None:
        for speed in (0, 0.1, 1, 4) if at_length() else (0, 4):
            p = self.probes(SWELL.replace("SPEED", str(speed)).replace("SCHEME", "interfacial"))
            self.assertLess(abs(p["height"] - 0.25).max(), 0.002, speed)
            self.assertLess(abs(p["potential"] - 250).max(), 2.5, speed)

    def test_a_drop_that_flies_stays_the_drop_that_it_is(self) -> None:
        for speed in (0, 3):
            p = self.probes(LUMP.replace("SPEED", str(speed)).replace("SCHEME", "interfacial"))
            self.assertLess(abs(p["most"] - 1000).max(), 1, speed)
            self.assertLess(abs(p["kinetic"] - p["kinetic"][0]).max(), 1e-6 * max(p["kinetic"][0], 1), speed)

    @of_nightly
    def test_water_that_sloshes_does_so_under_both_schemes(self) -> None:
        one, other = (self.probes("sloshing2d-single", f"scheme={s}", "end_time=3.2") for s in ("dissipation", "interfacial"))
        for gauge in ("left", "right"):
            self.assertLess(np.abs(one[gauge] - other[gauge]).max(), 0.002, gauge)


class PlaneOfSymmetry(RightAnswer):
    """Half of a bubble beside a cut with slip, and a quarter, rise as the whole does."""

    SOUND = ("riemann", "dissipation", "interfacial")
    SOLVED = ("incompressible", "differences")

    def rise(self, scheme: str, dimensions: int, resolution: int, end: float, part: bool, beyond: int = 0) -> float:
        """beyond: cells of the domain behind the cuts and the floor."""
        low, last = 0 if part else -1, dimensions - 1
        box = [[low, *([low] if dimensions == 3 else []), 0], [1, *([1] if dimensions == 3 else []), 4]]
        up = [0] * last + [1]
        ends = [f"{{half_space: {{point: {point}, normal: {normal}}}}}"
                for point, normal in ((box[0], up), (box[1], [-v for v in up]))]  # fmt: skip
        sides = [f"{{outside: true, box: {{min: {[*box[0][:last], -2]}, max: {[*box[1][:last], 6]}}}}}"]
        sides += [f"{{operation: subtract, {one[1:]}" for one in ends]
        tense = scheme != "riemann"  # which has no tension
        case = BUBBLE.format(tension="{between: [liquid, gas], tension: 0.5}" if tense else "", start="laplace" if tense else "hydrostatic",
                             dimensions=dimensions, low=[x - beyond / resolution for x in box[0]], high=box[1], gravity=[-v for v in up], centre=[0] * last + [1.2],
                             sides=", ".join(sides), ends=", ".join(ends), axis="xyz"[last], scheme=scheme)  # fmt: skip
        return self.probes(case, f"resolution={resolution}", f"end_time={end}")["velocity"].max()

    def check(self, scheme: str, dimensions: int, resolution: int, end: float) -> None:
        whole, part = (self.rise(scheme, dimensions, resolution, end, part) for part in (False, True))
        self.assertGreater(whole, 0.1)
        self.assertLess(abs(part / whole - 1), 0.01, (scheme, dimensions, whole, part))
        if scheme in ("interfacial", "incompressible") or at_length():
            within = self.rise(scheme, dimensions, resolution, end, True, 3)
            self.assertLess(abs(within / whole - 1), 0.01, (scheme, dimensions, whole, within))

    def test_half_of_a_bubble_rises_as_the_whole(self) -> None:
        for scheme in self.SOUND + self.SOLVED:
            self.check(scheme, 2, 8, 1.5)

    def test_half_of_a_ball_that_swings_along_the_cut_stirs_half(self) -> None:
        for scheme in self.SOUND + self.SOLVED:
            whole, half = (self.probes(SWINGING.format(low=low, scheme=scheme))["kinetic"] for low in (-1, 0))
            self.assertGreater(whole.max(), 50)
            # In the mean: a step with a correction of the density may be one earlier or later, and has 3 % more energy.
            self.assertLess(abs(2 * half - whole).mean(), 0.01 * whole.max(), scheme)

    def test_a_quarter_of_a_bubble_rises_as_the_whole(self) -> None:
        for scheme in self.SOUND + self.SOLVED if at_length() else ("riemann", "interfacial"):
            self.check(scheme, 3, 5, 1 if scheme in self.SOLVED else 0.3)


LAYERS = """
dimensions: 2
reference_length: 1
resolution: 24
domain: {min: [0, 0], max: [1, 1]}
gravity: [0, -9.81]
fluids:
  - {name: heavy, density: 1000, sound_speed: 60, pressure: hydrostatic, shape: [{box: {min: [0, 0], max: [1, 0.375]}}]}
  - {name: middle, density: 700, sound_speed: 60, pressure: hydrostatic, shape: [{box: {min: [0, 0.375], max: [1, 0.75]}}]}
  - {name: light, density: 50, sound_speed: 60, pressure: hydrostatic}
walls:
  - name: tank
    shape: [{outside: true, box: {min: [0, 0], max: [1, 1]}}]
    motion: {one_minus_cosine: {amplitude: [0.1, 0], frequency: 0.8}}
scheme: dissipation
end_time: 1.5
probes: [{name: coverage, coverage: {wall: tank}}]
output: {probe_interval: 0.01}
"""


class GasBesideLiquid(RightAnswer):
    """Under `dissipation` as it is without any option."""

    def test_both_stay_at_rest_at_any_ratio_of_densities(self) -> None:
        for ratio in (1, 10, 100, 300, 1000) if at_length() else (10, 1000):
            air = 1000 / ratio
            p = self.probes("hydrostatic", "scheme=dissipation", "resolution=20", "end_time=0.6", f"fluids[1].density={air}",
                            f"constants[3].value={air}", *PROBES)  # fmt: skip
            self.assertLess(p["error"].max(), 0.03 * 1000 * 9.81 * 0.5, ratio)
            self.assertLess(p["air"].max(), 1, ratio)
            self.assertGreater(p["coverage"].min(), 0.75, ratio)

    def column(self, ratio: float, scheme: str) -> "dict[str, np.ndarray]":
        return self.probes("dambreak2d", f"scheme={scheme}", f"fluids[1].density={1 / ratio}", "end_time=2")

    @of_nightly
    def test_a_column_that_breaks_makes_no_energy_and_leaves_no_voids(self) -> None:
        for ratio in (3, 10, 100, 300, 1000):
            p, other = self.column(ratio, "dissipation"), self.column(ratio, "riemann")
            energy, freed = p["kinetic"] + p["potential"], p["potential"][0] - p["potential"].min()
            self.assertLess(p["speed_air"].max(), 4, ratio)
            self.assertLess(energy.max() - energy[0], 0.001 * freed, ratio)
            self.assertEqual(p["escaped"].max(), 0, ratio)
            # Both are covered to more than 0.9. Which has the barer place is chance among gases (0.932 and 0.937 at 300); at 10 dissipation has
            # 0.923 and riemann 0.956, as more dissipation would brake waves (dissipation.md).
            self.assertGreaterEqual(p["coverage"].min(), min(other["coverage"].min(), 0.9), ratio)

    def test_light_liquids_leave_no_voids_either(self) -> None:
        """Where fluids fill the domain; with free surfaces and with tension liquids stay as P1 has them."""
        for ratio in (1.5, 10, 30) if at_length() else (10,):
            p = self.probes("dambreak2d", "scheme=dissipation", f"fluids[1].density={1 / ratio}", "end_time=2", "resolution=12")
            self.assertGreater(p["coverage"].min(), 0.9, ratio)

    def test_three_layers_are_not_torn(self) -> None:
        """Of liquids the lightest alone goes through interfaces."""
        said = self.complaints(LAYERS, out=self.home)
        self.assertNotIn("energy:", said)
        self.assertGreater(self.values(self.home)["coverage"].min(), 0.75)

    def test_layers_slosh_as_they_should(self) -> None:
        """What keeps light liquids together does not brake their waves: depths beside the walls of a tank, against `incompressible`."""
        setting = ("fluids[1].density=100", "fluids[1].sound_speed=26.6", "resolution=52", "end_time=3" if at_length() else "end_time=1")
        p, exact = (self.probes("sloshing2d", f"scheme={scheme}", *setting) for scheme in ("dissipation", "incompressible"))
        for gauge in ("h_left", "h_right"):
            n = min(len(p[gauge]), len(exact[gauge]))
            self.assertLess(np.sqrt(np.mean((p[gauge][:n] - exact[gauge][:n]) ** 2)), 0.01, gauge)
        self.assertGreater(p["coverage"].min(), 0.8)

    def test_more_than_it_holds_is_refused(self) -> None:
        said = self.complaints("hydrostatic", "scheme=dissipation", "fluids[1].density=0.5", code=65)
        self.assertIn("fluids: water is 2000 times as dense as air, and the scheme dissipation holds a gas up to 1000", said)

    def test_sounds_that_are_not_alike_are_right_or_refused(self) -> None:
        for ratio, sound in ((1000, 0.84), (1000, 1.2), (100, 0.5), (10, 0.25), (10, 1.2)) if at_length() else ((1000, 1.2),):
            air = 1000 / ratio
            p = self.probes("hydrostatic", "scheme=dissipation", "resolution=20", "end_time=0.6", f"fluids[1].density={air}",
                            f"fluids[1].sound_speed={44.3 * sound}", f"constants[3].value={air}", *PROBES)  # fmt: skip
            self.assertLess(p["error"].max(), 0.03 * 1000 * 9.81 * 0.5, (ratio, sound))
            self.assertLess(p["air"].max(), 1, (ratio, sound))
            self.assertGreater(p["coverage"].min(), 0.75, (ratio, sound))
        for ratio, sound, held in ((1000, 3, "from 36.92 to 53.16 m/s"), (1000, 0.5, "from 36.92 to 53.16 m/s"), (10, 3, "up to 53.16 m/s")):
            said = self.complaints("hydrostatic", "scheme=dissipation", f"fluids[1].density={1000 / ratio}", f"fluids[1].sound_speed={44.3 * sound}",
                                   code=65)  # fmt: skip
            self.assertIn("air has a sound of", said)
            self.assertIn(f"the scheme dissipation holds {held} there", said)

    def test_arithmetic_averages_are_warned_of(self) -> None:
        said = self.complaints("hydrostatic", "scheme={dissipation: {pair_average: arithmetic}}", "end_time=0.001")
        self.assertIn("scheme.dissipation.pair_average: the heaviest fluid is 1e+03 times as dense", said)


class Energy(RightAnswer):
    """What a scheme makes of nothing is in the result, and told."""

    def excess(self, case: str, *settings: str) -> "tuple[float, str]":
        """With what is said on standard error."""
        words = ["run", case, "--threads", "1", "--out", self.home / "run", "-o", "json", *(w for s in settings for w in ("--set", s))]
        environment = {**os.environ, "MENISCUS_CASES": str(ROOT / "server" / "cases")}
        done = subprocess.run([str(w) for w in (BUILD / "meniscus", *words)], env=environment, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        return json.loads(done.stdout)["energy_excess"], done.stderr

    def test_air_that_bursts_makes_some(self) -> None:
        excess, said = self.excess("hydrostatic", "scheme={dissipation: {pair_average: arithmetic}}", "resolution=20", "end_time=0.05")
        self.assertGreater(excess, 0.01)
        self.assertIn("energy: after step", said)

    @of_nightly
    def test_a_column_that_strikes_the_far_wall_makes_none(self) -> None:
        for scheme in ("riemann", "dissipation"):
            excess, said = self.excess("dambreak2d", f"scheme={scheme}", "end_time=4")
            self.assertEqual(excess, 0, scheme)
            self.assertNotIn("energy:", said)

    def test_what_rests_makes_none(self) -> None:
        runs = [("dissipation", 20), ("riemann", 20)]
        for scheme, resolution in [*runs, ("interfacial", 40)] if at_length() else runs:
            excess, said = self.excess("hydrostatic", f"scheme={scheme}", f"resolution={resolution}", "end_time=0.5")
            self.assertEqual(excess, 0, scheme)
            self.assertNotIn("energy:", said)

    @of_nightly
    def test_water_that_is_spread_is_lifted_and_that_is_told(self) -> None:
        excess, said = self.excess("hydrostatic", "resolution=20", "end_time=0.5", "walls[0].slip=none")
        self.assertGreater(excess, 0.01)
        self.assertIn("energy: after step", said)


if __name__ == "__main__":
    unittest.main()

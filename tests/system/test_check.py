#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""`meniscus check` looks at a case without running it; `meniscus run` deletes what was there or says how much is kept."""

import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any, List, Set

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, CHOICES, ROOT  # noqa: E402

CASE = """\
dimensions: 2
resolution: 16
domain: {min: [0, 0], max: [2, 1]}
gravity: [0, -1]
fluids: [{name: w, density: 1000, sound_speed: 20, shape: [{box: {min: [0, 0], max: [1, 0.5]}}]}]
walls: [{name: t, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}]
end_time: 0.02
output: {checkpoint_interval: 0.01}
"""

DROP = """\
dimensions: 2
reference_length: 0.0025
resolution: 8
domain: {min: [-0.005, -0.005], max: [0.005, 0.005]}
fluids:
  - {name: water, density: 1000, viscosity: 1.0e-3, sound_speed: 1.7, pressure: laplace, shape: [{ball: {centre: [0, 0], radius: 0.0025}}]}
  - {name: air, density: 1.2, viscosity: 1.8e-5, sound_speed: 3}
interfaces: [{between: [water, air], tension: 0.072}]
walls: [{name: box, slip: none, shape: [{outside: true, box: {min: [-0.005, -0.005], max: [0.005, 0.005]}}]}]
scheme: {interfacial: {background_pressure: 3.8}}
end_time: 0.02
"""

BUBBLE = """\
dimensions: 2
reference_length: 0.002
resolution: 6
domain: {min: [-0.006, 0], max: [0.006, 0.02]}
gravity: [0, -9.81]
fluids:
  - {name: air, density: 1.2, viscosity: 1.8e-5, sound_speed: 10, pressure: laplace, shape: [{ball: {centre: [0, 0.005], radius: 0.002}}]}
  - {name: water, density: 1000, viscosity: 1.0e-3, sound_speed: 5, pressure: hydrostatic}
interfaces: [{between: [water, air], tension: 0.072}]
walls: [{name: box, slip: none, shape: [{outside: true, box: {min: [-0.006, 0], max: [0.006, 0.02]}}]}]
scheme: {dissipation: {background_pressure: 100}}
end_time: 0.02
"""


class Shell(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        (self.home / "case.yaml").write_text(CASE)
        clean = {key: value for key, value in os.environ.items() if key not in CHOICES}
        self.environment = clean | {"MENISCUS_CASES": str(ROOT / "server/cases"), "OMP_NUM_THREADS": "1"}

    def meniscus(self, *words: str, code: int = 0) -> "subprocess.CompletedProcess[str]":
        done = subprocess.run([BUILD / "meniscus", *words], env=self.environment, cwd=self.home, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, code, f"meniscus {' '.join(words)}: {done.stdout}{done.stderr}")
        return done

    def ask(self, *words: str, code: int = 0) -> Any:
        return json.loads(self.meniscus(*words, "-o", "json", code=code).stdout)

    def files(self) -> Set[str]:
        return {str(path.relative_to(self.home)) for path in self.home.rglob("*")}


class Check(Shell):
    def test_it_says_what_a_run_takes_and_writes_nothing(self) -> None:
        before = self.files()
        found = self.ask("check", "case.yaml")
        self.assertEqual(self.files(), before)
        run = self.ask("run", "case.yaml", "--out", "out")
        for same in "case", "particles", "fluid_particles", "end_time", "threads":
            self.assertEqual(found[same], run[same])
        self.assertLess(abs(found["steps"] - run["steps"]), 3)
        self.assertGreater(found["memory_bytes"], 0)
        self.assertGreater(found["memory_free_bytes"], found["memory_bytes"])
        self.assertGreater(found["wall_s"], 0)
        self.assertEqual(found["doubts"], [])
        lines = self.meniscus("check", "case.yaml").stdout.splitlines()
        self.assertEqual(lines[0], f"case: {run['particles']} particles, {run['fluid_particles']} of fluid, 0.0625 m apart")
        self.assertEqual(lines[-1], "  nothing is doubtful")

    def test_set_and_threads_are_as_of_run(self) -> None:
        coarse, fine = self.ask("check", "case.yaml"), self.ask("check", "case.yaml", "--set", "resolution=32", "--threads", "2")
        self.assertEqual(fine["fluid_particles"], 4 * coarse["fluid_particles"])
        self.assertEqual((coarse["threads"], fine["threads"]), (1, 2))
        self.assertEqual(self.ask("check", "dambreak2d", "--set", "resolution=10")["case"], "dambreak2d")

    def test_doubtful_settings_are_listed(self) -> None:
        words = ["check", "case.yaml", "--set", "fluids[0].sound_speed=2"]
        doubt = self.ask(*words)["doubts"][0]
        self.assertIn("fluids[0].sound_speed: 2 m/s is less than", doubt)
        self.assertIn(f"  doubtful   {doubt}\n", self.meniscus(*words).stdout)

    def test_what_is_doubtful_is_said_of_a_case_whose_trial_steps_end_in_a_fault_too(self) -> None:
        """A background pressure that tears a gas apart within fifty steps."""
        (self.home / "drop.yaml").write_text(DROP)
        words = ["check", "drop.yaml", "--set", "scheme.interfacial.background_pressure=90"]
        done = self.meniscus(*words, code=70)
        self.assertIn("  doubtful   scheme.interfacial.background_pressure: 90 Pa is more than rho c^2/exponent of air", done.stdout)
        self.assertIn("diverged in step", done.stderr)
        both = subprocess.run([BUILD / "meniscus", *words], env=self.environment, cwd=self.home, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120).stdout
        self.assertLess(both.index("doubtful"), both.index("diverged"))
        found = self.ask(*words, code=70)
        self.assertEqual(list(found), ["doubts", "error"])
        self.assertTrue(any("background_pressure: 90 Pa" in doubt for doubt in found["doubts"]), found)
        self.assertEqual(self.ask("check", "nowhere", code=65)["doubts"], [])

    def said(self, *words: str) -> List[str]:
        """Of sounds, background pressures, kernels and ratios."""
        about = "sound_speed", "background_pressure", "scheme.kernel", "scheme.smoothing", "interfaces"
        done = subprocess.run([BUILD / "meniscus", "check", *words, "-o", "json"], env=self.environment, cwd=self.home, capture_output=True, text=True, timeout=120)
        self.assertIn(done.returncode, (0, 70), done.stderr)  # what is doubtful may end the trial steps
        return [doubt for doubt in json.loads(done.stdout)["doubts"] if any(entry in doubt.split(":")[0] for entry in about)]

    def test_what_is_advised_holds_when_it_is_taken(self) -> None:
        """All of it together, as it stands there."""
        (self.home / "drop.yaml").write_text(DROP)
        (self.home / "bubble.yaml").write_text(BUBBLE)
        for case, settings in (("drop.yaml", ["fluids[1].sound_speed=1", "scheme.interfacial.background_pressure=20"]),
                               ("drop.yaml", ["scheme={interfacial: {}}"]),
                               ("drop.yaml", ["fluids[0].sound_speed=0.5", "fluids[1].sound_speed=0.5", "scheme={interfacial: {}}"]),
                               ("drop.yaml", ["scheme.smoothing=1.0"]),
                               ("drop.yaml", ["fluids[0].shape[0].ball.centre=[0, -0.005]", "fluids[0].sound_speed=1"]),
                               ("bubble.yaml", []),
                               ("bubble.yaml", ["scheme={interfacial: {}}"])):
            words = [word for setting in settings for word in ("--set", setting)]
            with self.subTest(case=case, settings=settings):
                doubts = self.said(case, *words)
                self.assertTrue(doubts)
                for doubt in doubts:
                    entry, number = doubt.split(":")[0], re.search(r"(?:; |take )([0-9.e+]+)(?= m/s would| Pa would|$)", doubt)
                    assert number, doubt
                    words += ["--set", f"{entry}={number[1]}"]
                    for other, value in re.findall(r"(fluids\[\d+\].sound_speed) of ([0-9.e+]+) m/s", doubt):
                        words += ["--set", f"{other}={value}"]
                self.assertEqual(self.said(case, *words), [])

    def test_layers_and_what_is_around_a_drop_are_not_said_to_be_bubbles(self) -> None:
        """Both have fewer particles than the water."""
        self.assertEqual(self.said("ripple2d", "--set", "domain.max=[0.01, 0.0075]", "--set", "walls[0].shape[1].half_space.point=[0, 0.0075]"), [])
        (self.home / "drop.yaml").write_text(DROP)
        small = ["--set", "domain={min: [-0.003125, -0.003125], max: [0.003125, 0.003125], periodic: [x, y]}", "--set", "walls=[]"]
        self.assertEqual(self.said("drop.yaml", *small), [])

    def test_half_a_drop_on_a_floor_is_as_curved_as_the_whole(self) -> None:
        (self.home / "drop.yaml").write_text(DROP)
        for centre in ("[0, 0]", "[0, -0.005]", "[-0.005, -0.005]"):
            doubt = self.said("drop.yaml", "--set", f"fluids[0].shape[0].ball.centre={centre}", "--set", "fluids[0].sound_speed=1")[0]
            self.assertRegex(doubt, r"of water, 0.005\d* m across|of water, 0.0049\d* m across")
            self.assertTrue(doubt.endswith("; 1.7 m/s would be enough"), doubt)

    def test_kernels_and_ratios_that_a_scheme_was_not_measured_with_are_doubtful(self) -> None:
        wet = ["case.yaml", "--set", "fluids[0].viscosity=0.1"]
        for words, doubt in ((["drop-in-air2d", "--set", "scheme.smoothing=1.0"], "scheme.smoothing: with wendland-c2 and a smoothing of 1 the scheme interfacial was not measured, but with from 1.6 to 2; take 1.6"),
                             (["drop-in-air2d", "--set", "scheme.kernel=truncated-gaussian", "--set", "scheme.smoothing=1.1"],
                              "scheme.kernel: the scheme interfacial was not measured with truncated-gaussian; take wendland-c2 with a smoothing of 1.6, or leave both out"),
                             (wet, "scheme.smoothing: with wendland-c2 and a smoothing of 1.3 the scheme riemann was not measured at the free surface of a viscous fluid, but with from 1.6 to 2; take 1.6"),
                             ([*wet, "--set", "scheme.smoothing=1.6"], None),
                             (["drop-in-air2d", "--set", "scheme={differences: {reference_speed: 0.1}}"],
                              "interfaces: fluids with surface tension differ in density by a factor of 833.3, and the scheme differences is known to hold it up to 10: at 1000 the pressure jump of a drop at rest is 5 to 12 % too large, "
                              "its volume grows and longer runs break up; take interfacial or incompressible"),
                             (["drop-in-air2d", "--set", "scheme={incompressible: {reference_speed: 0.1}}"], None)):
            with self.subTest(words):
                self.assertEqual(self.said(*words), [doubt] if doubt else [])

    def test_the_first_error_is_said_with_its_place_and_65(self) -> None:
        for setting, path, start in (("resolution=0", "resolution", "--set resolution=0: "),
                                     ("domain.max=[2, 1.02]", "resolution", "case.yaml:2:13: "),
                                     ("gravity=[0, log(-1)]", "gravity[1]", "--set gravity=[0, log(-1)]: "),
                                     ("probes=[{name: p, mass: {}}, {name: p, mass: {}}]", "probes[1].name", "--set probes=")):
            with self.subTest(setting):
                words = ["check", "case.yaml", "--set", setting]
                said = self.meniscus(*words, code=65).stderr
                self.assertTrue(said.startswith(start), said)
                self.assertEqual(self.ask(*words, code=65)["error"]["path"], path)
        (self.home / "bad.yaml").write_text(CASE.replace("sound_speed: 20", "sound_speed: fast"))
        self.assertTrue(self.meniscus("check", "bad.yaml", code=65).stderr.startswith("bad.yaml:5:"))
        self.assertEqual(self.ask("check", "nowhere", code=65)["error"]["status"], "not found")
        self.meniscus("check", code=2)
        self.meniscus("check", "case.yaml", "--out", "x", code=2)


    def under(self, limits: str, *words: str, code: int) -> "subprocess.CompletedProcess[str]":
        shell = ["bash", "-c", f'{limits}; exec "$@"', "bash", BUILD / "meniscus", *words]
        done = subprocess.run(shell, env=self.environment, cwd=self.home, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_a_case_that_takes_more_memory_than_there_is_is_refused_with_65(self) -> None:
        done = self.under("ulimit -v 2000000", "check", "case.yaml", "--set", "resolution=4000", "-o", "json", code=65)
        self.assertEqual(json.loads(done.stdout)["error"]["status"], "out of memory")
        self.assertEqual(json.loads(done.stdout)["error"]["exit_code"], 65)

    def test_the_limit_on_the_size_of_files_counts(self) -> None:
        for words in (["check", "case.yaml"], ["run", "case.yaml", "--out", "out"]):
            said = self.under("ulimit -f 10", *words, code=74).stderr
            self.assertRegex(said, r"it has \d+ kB, and the limit on the size of files is 10 kB; raise the limit \(`ulimit -f`")
        self.assertEqual(self.files(), {"case.yaml"})
        many = ["check", "case.yaml", "--set", "probes=[{name: m, mass: {}}]", "--set", "output.probe_interval=1e-9", "--set", "end_time=100"]
        said = self.under("ulimit -f 200", *many, code=0).stdout
        self.assertRegex(said, r"doubtful   output.probe_interval: probes.hdf will have some \S+ rows and \S+ kB, and the limit .* 204.8 kB")
        self.assertNotIn("probes.hdf", self.meniscus(*many).stdout)


class Overwrite(Shell):
    def test_it_deletes_what_the_run_before_wrote_and_nothing_else(self) -> None:
        self.meniscus("run", "case.yaml", "--out", "out", "--set", "end_time=0.03")
        self.meniscus("run", "case.yaml", "--out", "out")
        self.assertTrue((self.home / "out/abandoned").is_dir())
        (self.home / "out/notes.txt").write_text("mine")
        kept = {name for name in self.files() if name.startswith("out/abandoned")}
        newest = sorted(name for name in self.files() if name.startswith("out/checkpoint"))
        self.meniscus("run", "case.yaml", "--out", "out", "--overwrite", "--set", "end_time=0.01")
        after = self.files()
        self.assertEqual({name for name in after if name.startswith("out/abandoned")}, kept)
        self.assertNotIn(newest[-1], after)
        self.assertEqual((self.home / "out/notes.txt").read_text(), "mine")

    def test_a_case_that_is_refused_deletes_nothing(self) -> None:
        self.meniscus("run", "case.yaml", "--out", "out")
        before = self.files()
        self.meniscus("run", "case.yaml", "--out", "out", "--overwrite", "--set", "gravity=[0, log(-1)]", code=65)
        self.assertEqual(self.files(), before)

    def test_it_does_not_go_with_resume(self) -> None:
        self.assertIn("give one of them", self.meniscus("run", "case.yaml", "--overwrite", "--resume", "auto", code=2).stderr)

    def test_what_is_kept_is_told_once_it_passes_ten(self) -> None:
        for k in range(12):
            said = self.meniscus("run", "case.yaml", "--out", "out", "--set", "end_time=0.001").stderr
            with self.subTest(k):
                self.assertEqual("meniscus run --overwrite" in said, k > 10, said)
        self.assertIn("11 directories out/abandoned* hold ", said)
        total = sum(path.stat().st_size for path in self.home.glob("out/abandoned*/*"))
        self.assertIn(f" hold {1e-6 * total:.3g} MB of earlier runs", said)
        said = self.meniscus("run", "case.yaml", "--out", "out", "--overwrite", "--set", "end_time=0.001").stderr
        self.assertNotIn("abandoned", said)  # which has no more than before, and stays
        self.assertEqual(len(list(self.home.glob("out/abandoned*"))), 11)


if __name__ == "__main__":
    unittest.main()

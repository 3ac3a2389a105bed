#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""A run that goes on where products are rounded otherwise: it does, and says so. And where the level is the same, so are the bits,
whatever the processor has besides. Threads that are to be bound to processors are bound to different ones."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, DaemonTest, old_machine  # noqa: E402

CASE = ["dambreak2d", "--set", "resolution=10", "--set", "threads=1", "--resume", "auto"]
WARNING = "differs in the last bits"
NOTICE = "so is what follows, with the instructions of x86-64"


def named(path: Path) -> str:
    """The arithmetic that a file says it is of."""
    with h5py.File(path) as file:
        return str(file["meniscus"].attrs["arithmetic"].decode())


class Levels(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-levels-")
        self.addCleanup(scratch.cleanup)
        self.out = Path(scratch.name) / "run"

    def run_until(self, end: float, level: dict[str, str] | None = None) -> str:
        """What it says on standard error. The state it ends in is kept."""
        environment = {key: value for key, value in os.environ.items() if key != "MENISCUS_LEVEL"}
        environment |= {"MENISCUS_CASES": str(ROOT / "server" / "cases")} | (level or {})
        words = [BUILD / "meniscusd", "--batch", *CASE, "--out", self.out, "--set", f"end_time={end}", "--output", "json"]
        done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.state = json.loads(done.stdout)["state_hash"]
        return done.stderr

    def arithmetic(self) -> str:
        return named(max(self.out.glob("checkpoint-*.hdf"), key=lambda path: int(path.stem.split("-")[1])))

    @unittest.skipIf(os.uname().machine != "x86_64", "there is one level")
    def test_the_best_of_the_machine_is_chosen(self) -> None:
        flags = set(Path("/proc/cpuinfo").read_text().split("flags", 1)[1].split("\n", 1)[0].split())
        v3 = {"avx2", "fma", "bmi1", "bmi2"} <= flags
        v4 = v3 and {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= flags
        environment = {key: value for key, value in os.environ.items() if key != "MENISCUS_LEVEL"}
        told = subprocess.run([BUILD / "meniscusd", "--machine"], env=environment, capture_output=True, text=True, check=True).stdout
        self.assertIn("x86-64-v4," if v4 else "x86-64-v3," if v3 else "x86-64,", told)

    def test_who_goes_on_with_another_arithmetic_is_told(self) -> None:
        self.assertNotIn(WARNING, self.run_until(0.1))
        usual = self.arithmetic()
        self.assertEqual(WARNING in self.run_until(0.2, old_machine()), usual == "fused")
        self.assertEqual(self.arithmetic(), "separate")

    def test_who_goes_on_from_an_old_machine_computes_as_it_did(self) -> None:
        self.run_until(0.1, old_machine())
        said = self.run_until(0.2)
        self.assertNotIn(WARNING, said)
        went_on, arithmetic = self.state, self.arithmetic()
        self.out = self.out.with_name("there")
        for end in (0.1, 0.2):  # steps end where a run is to end
            self.run_until(end, old_machine())
        self.assertEqual((went_on, arithmetic), (self.state, "separate"))
        self.out = self.out.with_name("usual")
        self.run_until(0.1)
        self.assertEqual(NOTICE in said, self.arithmetic() == "fused")

    def test_who_goes_on_with_the_same_is_not(self) -> None:
        self.run_until(0.1)
        self.assertNotIn(WARNING, self.run_until(0.2))


class Runs(DaemonTest):
    """What was computed as old machines do, in a daemon that does not by itself."""

    SMALL = ["dambreak2d", "--set", "resolution=10", "--set", "end_time=9", "--set", "threads=1"]

    def tearDown(self) -> None:
        self.meniscus("stop")

    def arithmetic(self) -> str:
        """That a checkpoint is computed in."""
        return named(Path(self.ask("checkpoint")["path"]))

    def usual(self) -> str:
        self.meniscus("load", *self.SMALL, "--name", "usual")
        usual = self.arithmetic()
        self.meniscus("stop")
        return usual

    def compute_old(self) -> None:
        words = [BUILD / "meniscusd", "--batch", *self.SMALL, "--set", "end_time=0.05", "--out", self.home / "state" / "old"]
        subprocess.run(words, env=self.environment | old_machine(), check=True, capture_output=True, timeout=60)

    def test_it_is_kept_until_a_beginning(self) -> None:
        usual = self.usual()
        self.compute_old()
        self.meniscus("load", *self.SMALL, "--name", "old", "--resume")
        self.meniscus("step", "5")
        self.assertEqual(self.arithmetic(), "separate")
        self.meniscus("restore")
        self.assertEqual(self.arithmetic(), "separate")
        self.meniscus("load", *self.SMALL, "--set", "resolution=1e5", "--name", "huge", code=1)
        self.assertEqual(self.arithmetic(), "separate")
        self.assertRegex(self.ask("capabilities")["build"], r"\bx86-64(,|$)")
        self.kill_daemon()
        self.assertEqual(self.arithmetic(), "separate")
        self.meniscus("step", "60")
        self.meniscus("load", *self.SMALL, "--name", "after")
        self.assertEqual(self.arithmetic(), usual)
        self.assertEqual(named(self.home / "state" / "old" / "probes.hdf"), "separate")
        self.meniscus("load", *self.SMALL, "--name", "old", "--resume")
        self.assertEqual(self.arithmetic(), "separate")
        self.meniscus("reset")
        self.assertEqual(self.arithmetic(), usual)

    def test_a_crash_does_not_change_it(self) -> None:
        usual = self.usual()
        environment = self.environment
        self.daemon.terminate()
        self.daemon.wait()
        type(self).environment = environment | old_machine()
        self.start_daemon()
        self.meniscus("load", *self.SMALL, "--name", "early")
        self.meniscus("step", "5")
        type(self).environment = environment
        self.kill_daemon()
        self.assertEqual(self.arithmetic(), "separate")
        self.meniscus("reset")
        self.assertEqual(self.arithmetic(), usual)


class Solvers(unittest.TestCase):
    def test_files_name_the_method_by_which_pressures_were_solved_for(self) -> None:
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            for case, end, solver in (("hydrostatic-isph", 0.01, "cg"), ("dambreak2d", 0.1, None)):
                out = Path(scratch) / case
                words = ["--set", "resolution=10", "--set", f"end_time={end}", "--set", f"output.snapshot_interval={end}", "--out", out]
                done = subprocess.run(
                    [BUILD / "meniscusd", "--batch", case, *words], env=os.environ | {"MENISCUS_CASES": str(ROOT / "server" / "cases")},
                    capture_output=True, text=True, timeout=60,
                )  # fmt: skip
                self.assertEqual(done.returncode, 0, done.stderr)
                for kind in ("checkpoint", "snapshot"):
                    with h5py.File(sorted(out.glob(f"{kind}-*.hdf"))[-1]) as file:
                        found = file["meniscus"].attrs.get("solver")
                    self.assertEqual(found and found.decode(), solver, (case, kind))


class Processors(unittest.TestCase):
    """The C library chooses its mathematics by the processor, and can be told that this one has less than it has."""

    def state_of(self, case: str, settings: tuple[str, ...], less: bool) -> str:
        environment = os.environ | {"MENISCUS_CASES": str(ROOT / "server" / "cases")} | old_machine()
        if less:
            environment["GLIBC_TUNABLES"] = "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4"
        with tempfile.TemporaryDirectory(prefix="mns-processors-") as scratch:
            words = [BUILD / "meniscusd", "--batch", case, "--out", f"{scratch}/run", "--output", "json"]
            words += [word for setting in settings for word in ("--set", setting)]
            done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        return str(json.loads(done.stdout)["state_hash"])

    def test_walls_that_move_by_a_sine(self) -> None:
        case = "sloshing2d", ("resolution=20", "end_time=0.5")
        self.assertEqual(self.state_of(*case, less=False), self.state_of(*case, less=True))

    def test_fields_that_begin_as_formulas(self) -> None:
        case = "taylor-green2d", ("resolution=20", "end_time=0.05")
        self.assertEqual(self.state_of(*case, less=False), self.state_of(*case, less=True))

    @unittest.skipIf(len(os.sched_getaffinity(0)) < 2, "one processor")
    def test_threads_that_are_bound_have_a_processor_each(self) -> None:
        environment = {key: value for key, value in os.environ.items() if key not in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT")}
        environment |= {"MENISCUS_CASES": str(ROOT / "server" / "cases"), "OMP_PROC_BIND": "true"}
        environment |= {"OMP_DISPLAY_AFFINITY": "true", "OMP_AFFINITY_FORMAT": "team of %N: %A"}
        with tempfile.TemporaryDirectory(prefix="mns-bound-") as scratch:
            words = [BUILD / "meniscusd", "--batch=dambreak2d", "--set=threads=2", "--set=resolution=10", "--set=end_time=0.02"]
            done = subprocess.run([*words, f"--out={scratch}/run"], env=environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len({line for line in done.stderr.splitlines() if line.startswith("team of 2: ")}), 2, done.stderr)


if __name__ == "__main__":
    unittest.main()

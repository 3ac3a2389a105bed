#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Simulation, the readers of a run's files, and how they look in a notebook, against a real daemon."""

import os
import subprocess
import sys
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, readme_lines  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import simulation as module  # noqa: E402

SMALL = {"resolution": 10, "end_time": 1}


class WithDaemon(DaemonTest):
    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]
        self.simulation = meniscus.Simulation(f"ipc://{self.home}/run/meniscus/default/control.ipc", timeout=50)
        self.addCleanup(self.simulation.close)
        self.simulation.load("dambreak2d", SMALL)

    def test_parameters_are_items_and_attributes(self) -> None:
        parameters = self.simulation.parameters
        self.assertEqual((parameters["end_time"].value, parameters["end_time"].unit), (1, "s"))
        parameters.end_time = 3
        self.assertEqual(float(parameters.end_time), 3)
        parameters.scheme.cfl = np.float64(0.2)
        self.assertEqual(parameters["scheme.cfl"].value, 0.2)
        self.assertEqual(str(parameters.scheme.cfl.bounds), "[0.001, 1]")
        self.assertIn("scheme", dir(parameters))
        with self.assertRaises(meniscus.RefusedError) as caught:
            parameters.scheme.cfl = 99
        self.assertEqual(caught.exception.path, "scheme.cfl")
        with self.assertRaises(AttributeError):
            parameters.scheme.cfi
        with self.assertRaises(KeyError):
            parameters["cfl"]

    def test_several_parameters_change_at_one_step_or_not_at_all(self) -> None:
        parameters = self.simulation.parameters
        with self.assertRaises(meniscus.RefusedError):
            parameters.update({"end_time": 4, "scheme.cfl": 99})
        self.assertEqual(parameters.end_time.value, 1)
        self.simulation.parameters = {"end_time": 4, "gravity": [0, -2]}
        self.assertEqual(parameters.end_time.value, 4)
        self.assertEqual([float(formula) for formula in parameters.gravity.value], [0, -2])
        self.assertIs(parameters.scheme.riemann.transport_stress.value in (True, False), True)

    def test_probes_are_numbers(self) -> None:
        probes = self.simulation.probes
        self.assertIn("front", probes)
        self.assertAlmostEqual(probes["front"], 2, delta=0.2)
        self.assertEqual(probes.units["P05"], "Pa")
        now = probes.now("front", "h1")
        self.assertEqual(now.dtype.names, ("front", "h1"))
        self.assertEqual(now["front"], probes["front"])
        with self.assertRaises(KeyError):
            probes["nothing"]

    def test_time_state_and_particles(self) -> None:
        self.simulation.run_until(0.05)
        self.assertEqual((self.simulation.time, self.simulation.state), (0.05, "PAUSED"))
        velocity = self.simulation.particles(["velocity"])["velocity"]
        velocity *= 2  # an array of our own
        self.assertEqual(velocity.shape[1], 2)

    def test_a_snapshot_is_what_was_asked_of_the_daemon(self) -> None:
        self.simulation.run_until(0.05)
        file = self.simulation.snapshot(["velocity", "pressure"])
        now = self.simulation.particles(["position", "pressure"], walls=True)
        with meniscus.Snapshot(file.path) as snapshot:
            self.assertEqual((snapshot.step, snapshot.time, snapshot.dimensions), (file.step, file.time, 2))
            self.assertEqual(snapshot.units["pressure"], "Pa")
            self.assertEqual(snapshot.units["position"], "m")
            self.assertEqual(snapshot["velocity"].shape, (snapshot.particles, 2))
            self.assertEqual(snapshot["position"][3:5].shape, (2, 2))
            self.assertEqual(snapshot["position"][3:5, 0].shape, (2,))
            table = snapshot.array("position", "pressure")
            ours, theirs = np.lexsort(table["position"].T), np.lexsort(now["position"].T)
            np.testing.assert_array_equal(table["pressure"][ours], now["pressure"][theirs])
            masks = snapshot.select("water"), snapshot.select("water", "air")
            self.assertTrue(0 < masks[0].sum() < masks[1].sum() <= snapshot.particles)
            with self.assertRaises(KeyError):
                snapshot["colour"]
            with self.assertRaises(KeyError):
                snapshot.select("oil")
        snapshots = self.simulation.snapshots
        self.assertEqual(list(snapshots.times), [0, 0.05])
        self.assertTrue(all(len(kept["pressure"][:]) for kept in list(snapshots)))
        with snapshots[-1] as last:
            self.assertEqual(last.step, file.step)

    def test_the_series_of_a_run_that_goes_on(self) -> None:
        with meniscus.ProbeSeries(self.home / "probes.hdf") as nothing:
            self.assertEqual((len(nothing), len(nothing.time), nothing.refresh()), (0, 0, False))
        for none in (self.home / "nowhere", self.home / "nowhere" / "probes.hdf", self.home / "other.hdf"):
            with self.assertRaisesRegex(FileNotFoundError, "no such directory"):
                meniscus.ProbeSeries(none)
        with self.assertRaisesRegex(FileNotFoundError, "no such directory"):
            meniscus.Snapshots(self.home / "nowhere")
        self.assertEqual(len(meniscus.Snapshots(self.home)), 0)
        self.simulation.parameters = {"end_time": 60, "output.probe_interval": 0.01}
        self.simulation.run_until(0.1)
        self.simulation.checkpoint()
        series = self.simulation.series
        before = len(series.time)
        self.assertTrue(before and np.isfinite(series["kinetic"]).all())
        self.assertEqual(series.units["P05"], "Pa")
        self.simulation.run_until(0.3)
        self.simulation.checkpoint()
        self.assertEqual(len(series["front"]), before)  # all columns of one moment
        self.assertTrue(series.refresh())
        self.assertGreater(len(series["front"]), before)
        table = series.array("front")
        self.assertEqual(table.dtype.names, ("step", "time", "front"))
        self.assertTrue((np.diff(table["time"]) > 0).all())
        self.assertFalse(series.refresh())

    def test_the_lines_of_the_documentation_read_files(self) -> None:
        self.simulation.run_until(0.1)
        self.simulation.snapshot()
        runs = self.home / "lines" / "runs"
        runs.mkdir(parents=True)
        (runs / "dambreak2d").symlink_to(self.simulation.status().run_directory)
        lines = self.run_python(readme_lines("The files of a run"), runs.parent).splitlines()
        self.assertEqual(len(lines), len(self.simulation.snapshots))
        self.assertRegex(lines[-1], r"^0.1 [\d.]+ Pa$")

    def test_what_a_notebook_shows_is_escaped(self) -> None:
        self.simulation.stop()
        self.simulation.load("dambreak2d", SMALL | {"title": "<script>alert('&')</script>"})
        for shown in (self.simulation._repr_html_(), self.simulation.status()._repr_html_()):
            self.assertNotIn("<script", shown)
            self.assertIn("&lt;script&gt;alert(&#x27;&amp;&#x27;)&lt;/script&gt;", shown)
        self.assertIn("front", self.simulation._repr_html_())
        self.assertIn("[0.001, 1]", self.simulation.parameters._repr_html_())
        self.simulation.stop()
        self.assertIn("EMPTY", self.simulation._repr_html_())
        self.simulation.load("dambreak2d", SMALL)

    def test_a_case_without_probes_has_nothing_to_plot(self) -> None:
        self.simulation.load("dambreak2d", {"resolution": 20, "probes": []})
        with self.assertRaisesRegex(meniscus.RefusedError, "this case has no probes"):
            self.simulation.plot()


class WithoutDaemon(unittest.TestCase):
    def test_bounds(self) -> None:
        bounds = module.Bounds.read("(0, inf)")
        assert bounds
        self.assertEqual([value in bounds for value in (0, 1e-9, 1e300)], [False, True, True])
        self.assertEqual(str(bounds), "(0, inf)")
        self.assertIsNone(module.Bounds.read(""))

    def test_a_file_that_is_none_is_named(self) -> None:
        import tempfile

        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            bad = Path(scratch) / "snapshot-0000000001.hdf"
            with self.assertRaises(FileNotFoundError):
                meniscus.Snapshot(bad)
            bad.write_bytes(b"no HDF5")
            with self.assertRaises(meniscus.CorruptError):
                meniscus.Snapshot(bad)
            with h5py.File(bad, "w"):
                pass
            with self.assertRaises(meniscus.CorruptError) as caught:
                meniscus.Snapshot(bad)
            self.assertIn(bad.name, caught.exception.message)

    def test_it_is_imported_without_what_only_notebooks_have(self) -> None:
        code = "import sys\nfor name in ('IPython', 'matplotlib', 'h5py'): sys.modules[name] = None\nimport meniscus\n" \
            "print(meniscus.Status('DONE')._repr_html_())"
        done = subprocess.run(["/usr/bin/python3", "-c", code], env=os.environ | {"PYTHONPATH": str(BUILD / "python")},
                              capture_output=True, text=True)
        self.assertIn("DONE", done.stdout, done.stderr)


if __name__ == "__main__":
    unittest.main()

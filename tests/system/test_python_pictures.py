#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""What of the Python client draws by matplotlib or hands over to pandas and xarray, against a real daemon."""

import os
import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402


class Pictures(DaemonTest):
    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]
        self.simulation = meniscus.Simulation(f"ipc://{self.home}/run/meniscus/default/control.ipc", timeout=50)
        self.addCleanup(self.simulation.close)

    def last(self, case: str, settings: "dict[str, object]") -> meniscus.Snapshot:
        self.simulation.load(case, settings)
        self.simulation.step(3)
        self.simulation.snapshot()
        snapshot = self.simulation.snapshots[-1]
        self.addCleanup(snapshot.close)
        return snapshot

    def test_a_plot_follows_the_run_until_it_stands_still(self) -> None:
        self.simulation.load("dambreak2d", {"resolution": 10, "end_time": 1})
        plot = self.simulation.plot("front", "P05", "h1", interval=0.05)
        self.assertEqual(len(plot.figure.axes), 2)  # one for each unit
        self.simulation.start()
        plot.follow(timeout=20)
        self.assertEqual(self.simulation.state, "DONE")
        times = plot.figure.axes[0].lines[0].get_xdata()
        self.assertGreater(len(times), 10)
        self.assertTrue((np.diff(times) > 0).all())
        np.testing.assert_array_equal(times, self.simulation.series.time)  # from the first sample on, whenever it began to listen
        self.assertTrue((plot._repr_png_() or b"").startswith(b"\x89PNG"))
        plot.follow(timeout=20)  # nothing comes any more, and that is seen

    def test_a_series_as_a_table(self) -> None:
        self.simulation.load("dambreak2d", {"resolution": 10, "end_time": 1})
        self.simulation.run_until(0.2)
        self.simulation.checkpoint()
        series = self.simulation.series
        table = series.to_pandas("front", "P05")
        self.assertEqual(list(table.columns), ["step", "front", "P05"])
        np.testing.assert_array_equal(table.index, series.time)
        np.testing.assert_array_equal(table["front"], series["front"])
        self.assertEqual(table.attrs["units"], {"front": "m", "P05": "Pa"})
        self.assertEqual(list(series.to_pandas().columns), ["step", *series])
        with self.assertRaises(KeyError):
            series.to_pandas("nothing")

    def test_a_snapshot_as_a_dataset(self) -> None:
        snapshot = self.last("dambreak2d", {"resolution": 10})
        data = snapshot.to_xarray()
        self.assertEqual(set(data.data_vars), set(snapshot))
        np.testing.assert_array_equal(data.velocity.sel(axis="y"), snapshot["velocity"][:][:, 1])
        self.assertEqual((data.pressure.attrs["units"], data.pressure.dims), ("Pa", ("particle",)))
        self.assertEqual((data.attrs["step"], list(data.axis.values)), (3, ["x", "y"]))

    def test_a_snapshot_as_a_picture(self) -> None:
        snapshot = self.last("dambreak2d", {"resolution": 10})
        axes = snapshot.plot("velocity")
        dots = axes.collections[0]
        self.assertEqual(len(dots.get_offsets()), snapshot.particles)
        np.testing.assert_allclose(dots.get_array(), np.linalg.norm(snapshot["velocity"][:], axis=1))
        self.assertEqual(snapshot.plot("pressure", axes), axes)

    def test_a_slice_of_space(self) -> None:
        snapshot = self.last("dambreak3d", {"resolution": 8})
        axes = snapshot.plot("pressure", across="z")
        self.assertEqual((axes.get_xlabel(), axes.get_ylabel()), ("x [m]", "y [m]"))
        self.assertTrue(0 < len(axes.collections[0].get_offsets()) < 0.5 * snapshot.particles)
        with self.assertRaises(ValueError):
            snapshot.plot("pressure", across="w")


if __name__ == "__main__":
    unittest.main()

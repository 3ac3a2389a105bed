#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""Snapshots of a real run open in ParaView, by their names alone, with times, fields and values as they were written.

ParaView runs headless (packages paraview python3-paraview xvfb xauth); without it these tests are skipped."""

import glob
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest

import h5py
import matplotlib.image
import numpy

BUILD = os.path.abspath(os.environ.get("BUILD", "build"))

# Runs inside ParaView: prints what it sees in the files as JSON on the last line, draws the first at its last time.
LOOK = """
import json, sys
from paraview.simple import *

def look(path):
    source = OpenDataFile(path)
    times = list(source.TimestepValues) if hasattr(source.TimestepValues, "__iter__") else [source.TimestepValues]
    source.UpdatePipeline(times[-1] if times else 0)
    seen = source.GetDataInformation()
    arrays = {a.Name: [a.GetRange(d) for d in range(a.GetNumberOfComponents())] for a in source.PointData}
    return source, {"reader": type(source).__name__, "times": times, "points": seen.GetNumberOfPoints(),
                    "cells": seen.GetNumberOfCells(), "bounds": seen.GetBounds(), "arrays": arrays}

def draw(source, time, path):
    view = GetActiveViewOrCreate("RenderView")
    view.ViewSize, view.Background, view.OrientationAxesVisibility = [400, 300], [1, 1, 1], 0
    view.UseColorPaletteForBackground, view.ViewTime = 0, time
    shown = Show(source, view)
    shown.Representation, shown.PointSize = "Points", 6
    ColorBy(shown, ("POINTS", "phase"))
    shown.RescaleTransferFunctionToDataRange(True)
    shown.SetScalarBarVisibility(view, False)
    view.ResetCamera()
    SaveScreenshot(path, view)

picture, paths = sys.argv[1], sys.argv[2:]
found = [look(p) for p in paths]
draw(found[0][0], found[0][1]["times"][-1], picture)
print(json.dumps([f[1] for f in found]))
"""

# Behind a state that was run: what it shows.
LOOK_AT_STATE = """
import json
from paraview.simple import FindSource, GetActiveView, GetDisplayProperties, GetSources, SaveScreenshot
SaveScreenshot("state.png", GetActiveView())
scale = GetColorTransferFunction("pressure").RGBPoints
print(json.dumps({"time": GetActiveView().ViewTime, "sources": sorted(k[0] for k in GetSources()), "range": [scale[0], scale[-4]],
                  "colour": list(GetDisplayProperties(FindSource("run")).ColorArrayName)}))
"""
HIDDEN = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset"]  # as the documentation has it
WORKFLOWS = os.path.abspath(os.path.join(os.path.dirname(__file__), "../../client/workflows"))


def paraview(picture, paths):
    """What ParaView sees in each of the files, as a list of dictionaries; draws the first to `picture`."""
    with tempfile.NamedTemporaryFile("w", suffix=".py") as script:
        script.write(LOOK)
        script.flush()
        done = subprocess.run([*HIDDEN, "pvbatch", script.name, picture, *paths], capture_output=True, text=True, timeout=180, check=False)
    if done.returncode != 0 or "ERR" in done.stdout + done.stderr:
        raise AssertionError(f"pvbatch ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
    return json.loads(done.stdout.strip().splitlines()[-1])


@unittest.skipUnless(shutil.which("pvbatch") and shutil.which("xvfb-run"),
                     "needs ParaView headless: packages paraview python3-paraview xvfb xauth")
class SnapshotsInParaView(unittest.TestCase):
    """One run, opened once as a series and once as a single file."""

    @classmethod
    def setUpClass(cls):
        cls.dir = tempfile.TemporaryDirectory(prefix="meniscus-paraview-")
        cls.addClassCleanup(cls.dir.cleanup)
        run = [f"{BUILD}/meniscus", "run", "dambreak2d", "--out", cls.dir.name, "-o", "json"]
        for entry in ("resolution=10", "end_time=0.03", "output.snapshot_interval=0.01"):
            run += ["--set", entry]
        subprocess.run(run, check=True, timeout=120, stdout=subprocess.DEVNULL)
        cls.files = [h5py.File(p) for p in glob.glob(f"{cls.dir.name}/**/snapshot*.hdf", recursive=True)]
        cls.files.sort(key=lambda f: f["meniscus"].attrs["time"])
        cls.last = cls.files[-1]
        series = glob.glob(f"{cls.dir.name}/**/snapshots.hdf.series", recursive=True)
        cls.picture = f"{cls.dir.name}/picture.png"
        cls.series, cls.single = paraview(cls.picture, [series[0], cls.last.filename])

    @classmethod
    def tearDownClass(cls):
        for file in cls.files:
            file.close()

    def test_the_series_has_the_times_of_the_run(self):
        times = [float(f["meniscus"].attrs["time"]) for f in self.files]
        self.assertGreater(len(times), 2)
        self.assertEqual(self.series["times"], times)

    def test_file_and_series_find_their_reader_by_name(self):
        self.assertEqual([self.series["reader"], self.single["reader"]], ["VTKHDFReader"] * 2)

    def test_every_particle_is_a_point_and_a_cell(self):
        points = self.last["VTKHDF/Points"]
        for seen in (self.series, self.single):
            self.assertEqual([seen["points"], seen["cells"]], [len(points)] * 2)
            low, high = points[:].min(axis=0), points[:].max(axis=0)
            numpy.testing.assert_array_equal(seen["bounds"], numpy.column_stack([low, high]).ravel())

    def test_every_field_has_its_values(self):
        fields = self.last["VTKHDF/PointData"]
        self.assertLessEqual({"velocity", "pressure", "density", "phase", "id"}, set(fields))
        for seen in (self.series, self.single):
            self.assertEqual(set(seen["arrays"]), set(fields))
            for name, values in fields.items():
                columns = values[:].reshape(len(values), -1)
                ranges = numpy.column_stack([columns.min(axis=0), columns.max(axis=0)])
                numpy.testing.assert_allclose(seen["arrays"][name], ranges, rtol=1e-12, err_msg=name)

    def pvpython(self, *words):
        """What a script prints, in the run directory."""
        done = subprocess.run([*HIDDEN, "pvpython", *words], capture_output=True, text=True, timeout=120, check=False,
                              cwd=os.path.dirname(self.series_file()))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def series_file(self):
        return glob.glob(f"{self.dir.name}/**/snapshots.hdf.series", recursive=True)[0]

    def example(self, output):
        """What the example for workflows does of the series."""
        path = f"{self.dir.name}/{output}"
        self.pvpython(os.path.join(WORKFLOWS, "with_paraview.py"), self.series_file(), path)
        return path

    def assert_drawn(self, path):
        """All of it: nothing is cut off by an edge."""
        pixels = matplotlib.image.imread(path)[:, :, :3]
        for edge in (pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]):
            self.assertEqual(len(numpy.unique(edge, axis=0)), 1)
        self.assertGreater(len(numpy.unique(pixels.reshape(-1, 3), axis=0)), 50)

    def test_the_state_shows_the_last_time_by_pressure(self):
        look = f"{self.dir.name}/look.py"
        state = os.path.join(WORKFLOWS, "paraview_state.py")
        with open(look, "w") as script:
            script.write(f"exec(compile(open({state!r}).read(), 'state', 'exec'))\n{LOOK_AT_STATE}")
        seen = json.loads(self.pvpython(look).splitlines()[-1])
        self.assertEqual(seen["time"], float(self.last["meniscus"].attrs["time"]))
        self.assertEqual((seen["sources"], seen["colour"]), (["run", "time"], ["POINTS", "pressure"]))
        pressures = self.last["VTKHDF/PointData/pressure"][:]
        numpy.testing.assert_allclose(seen["range"], [pressures.min(), pressures.max()], rtol=1e-6)
        self.assert_drawn(os.path.join(os.path.dirname(self.series_file()), "state.png"))

    def test_the_lines_of_the_documentation_draw(self):
        with open(os.path.join(WORKFLOWS, "README.md")) as readme:
            text = readme.read()
        self.assertIn("`" + " ".join(f'"{w}"' if " " in w else w for w in HIDDEN) + " pvpython`", text)
        lines = re.search(r"```python\n(from paraview.*?)```", text, re.DOTALL)[1]
        self.assertEqual(len(lines.splitlines()), 5)
        script = f"{self.dir.name}/lines.py"
        with open(script, "w") as file:
            file.write(lines.replace("DIR/", "") + 'import json\nscale = GetColorTransferFunction("pressure").RGBPoints\n'
                       'print(json.dumps([view.ViewTime, scale[0], scale[-4]]))\n')
        time, low, high = json.loads(self.pvpython(script).splitlines()[-1])
        self.assertEqual(time, self.series["times"][-1])
        pressures = self.last["VTKHDF/PointData/pressure"][:]
        numpy.testing.assert_allclose([low, high], [pressures.min(), pressures.max()], rtol=1e-6)
        self.assert_drawn(os.path.join(os.path.dirname(self.series_file()), "pressure.png"))

    def test_the_example_writes_the_particles_of_the_last_time_as_csv(self):
        table = numpy.genfromtxt(self.example("last.csv"), delimiter=",", names=True, deletechars="")
        columns = {name.strip('"'): table[name] for name in table.dtype.names}
        self.assertEqual(len(table), len(self.last["VTKHDF/Points"]))
        numpy.testing.assert_allclose(columns["pressure"], self.last["VTKHDF/PointData/pressure"][:], rtol=1e-4)
        numpy.testing.assert_allclose(columns["Points:0"], self.last["VTKHDF/Points"][:, 0], rtol=1e-4)

    def test_the_example_draws_the_last_time(self):
        pixels = matplotlib.image.imread(self.example("last.png"))[:, :, :3]
        self.assertEqual(pixels.shape, (800, 1200, 3))
        self.assertGreater(len(numpy.unique(pixels.reshape(-1, 3), axis=0)), 50)

    def without_display(self, path, output):
        """The example where there is none, with the programs of a PATH."""
        environment = {key: value for key, value in os.environ.items() if key != "DISPLAY"} | {"PATH": path}
        words = [shutil.which("pvpython"), os.path.join(WORKFLOWS, "with_paraview.py"), self.series_file(), output]
        return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False, env=environment)

    def test_the_example_draws_where_there_is_no_display(self):
        path = f"{self.dir.name}/hidden.png"
        done = self.without_display(os.environ["PATH"], path)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        self.assert_drawn(path)

    def test_the_example_says_what_it_takes_to_draw(self):
        bare = f"{self.dir.name}/bare"
        os.mkdir(bare)
        os.symlink("/bin/true", f"{bare}/rsh")  # MPI, which pvpython begins with, insists on one
        done = self.without_display(bare, f"{self.dir.name}/never.png")
        self.assertEqual(done.returncode, 1, done.stderr[-2000:])
        self.assertIn("there is no display", done.stderr)
        self.assertIn("xvfb", done.stderr)
        self.assertFalse(os.path.exists(f"{self.dir.name}/never.png"))

    def test_the_picture_shows_the_phases(self):
        pixels = matplotlib.image.imread(self.picture)[:, :, :3]
        colours, counts = numpy.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)
        drawn = counts[colours.min(axis=1) < 1]
        self.assertGreater(drawn.sum(), 0.02 * counts.sum())
        self.assertGreaterEqual((drawn > 100).sum(), len(numpy.unique(self.last["VTKHDF/PointData/phase"][:])))


if __name__ == "__main__":
    unittest.main(verbosity=2)

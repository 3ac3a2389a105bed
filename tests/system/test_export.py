#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""meniscus export: tables with all that the files of a run have, to the last bit, for programs that do not read HDF5."""

import csv
import io
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD  # noqa: E402


class Export(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        directory = tempfile.TemporaryDirectory(prefix="meniscus-")
        cls.addClassCleanup(directory.cleanup)
        cls.directory = Path(directory.name)
        settings = ["resolution=8", "end_time=0.02", "output.snapshot_interval=0.02", "output.walls=true"]
        words = [word for setting in settings for word in ("--set", setting)]
        cls.meniscus("run", "hydrostatic", "--out", str(cls.directory / "run"), *words, check=True)
        cls.snapshot = sorted((cls.directory / "run").glob("snapshot-*.hdf"))[-1]
        cls.series = cls.directory / "run" / "probes.hdf"

    @staticmethod
    def meniscus(*words: str, check: bool = False) -> subprocess.CompletedProcess[str]:
        return subprocess.run([BUILD / "meniscus", *words], capture_output=True, text=True, timeout=100, check=check)

    def table(self, text: str) -> dict[str, np.ndarray]:
        rows = list(csv.reader(io.StringIO(text)))
        self.assertTrue(all(len(row) == len(rows[0]) for row in rows))
        numbers = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]])
        return {name: numbers[:, k] for k, name in enumerate(rows[0])}

    def test_particles_as_csv(self) -> None:
        table = self.table(self.meniscus("export", str(self.snapshot), check=True).stdout)
        with h5py.File(self.snapshot) as file:
            data = file["VTKHDF/PointData"]
            points = file["VTKHDF/Points"][:]
            for k, name in enumerate("xyz"):
                np.testing.assert_array_equal(table[f"{name} [m]"], points[:, k])
            np.testing.assert_array_equal(table["pressure [Pa]"], data["pressure"][:])
            np.testing.assert_array_equal(table["velocity_y [m/s]"], data["velocity"][:, 1])
            np.testing.assert_array_equal(table["phase"], data["phase"][:])
            self.assertEqual(len(table), 3 + sum(np.prod(field.shape[1:], dtype=int) for field in data.values()))

    def test_probes_as_csv(self) -> None:
        out = self.directory / "probes.csv"
        self.meniscus("export", str(self.series), "--out", str(out), check=True)
        table = self.table(out.read_text())
        with h5py.File(self.series) as file:
            np.testing.assert_array_equal(table["time [s]"], file["time"][:])
            np.testing.assert_array_equal(table["step"], file["step"][:])
            for name, series in file["probes"].items():
                unit = series.attrs["unit"].decode()
                np.testing.assert_array_equal(table[name if unit == "1" else f"{name} [{unit}]"], series[:])
            self.assertEqual(len(table), 2 + len(file["probes"]))

    def test_vtk_is_what_its_format_asks_for(self) -> None:
        out = self.directory / "a.vtk"
        self.meniscus("export", str(self.snapshot), "--out", str(out), check=True)
        raw = out.read_bytes()
        with h5py.File(self.snapshot) as file:
            points, data = file["VTKHDF/Points"][:], {name: field[:] for name, field in file["VTKHDF/PointData"].items()}
        at = raw.index(b"double\n") + len(b"double\n")
        np.testing.assert_array_equal(np.frombuffer(raw, ">f8", points.size, at).reshape(points.shape), points)
        for name, values in data.items():
            components = values.size // len(points)
            head = f"\n{name} {components} {len(points)} double\n".encode()
            at = raw.index(head) + len(head)
            np.testing.assert_array_equal(np.frombuffer(raw, ">f8", values.size, at).reshape(values.shape), values)

    def test_paraview_reads_it(self) -> None:
        out = self.directory / "b.vtk"
        self.meniscus("export", str(self.snapshot), "--out", str(out), check=True)
        script = ("import sys; from paraview.simple import LegacyVTKReader, servermanager\n"
                  "reader = LegacyVTKReader(FileNames=[sys.argv[1]]); reader.UpdatePipeline()\n"
                  "info = reader.GetDataInformation(); print('points', info.GetNumberOfPoints(), reader.PointData['pressure'].GetRange())")
        done = subprocess.run(["pvpython", "-c", script, str(out)], capture_output=True, text=True, timeout=120)
        with h5py.File(self.snapshot) as file:
            pressure = file["VTKHDF/PointData/pressure"][:]
        self.assertIn(f"points {len(pressure)} ({pressure.min()}, {pressure.max()})", done.stdout, done.stderr)

    def test_what_cannot_be_exported_is_told(self) -> None:
        nothing = self.directory / "nothing.hdf"
        nothing.write_bytes(b"no file of HDF5")
        checkpoint = sorted((self.directory / "run").glob("checkpoint-*.hdf"))[-1]
        for words, code, sentence in (
            ((str(self.series), "--out", str(self.directory / "p.vtk")), 1, "no places for a .vtk file"),
            ((str(self.snapshot), "--out", str(self.directory / "p.xls")), 2, "ends with .csv or .vtk"),
            ((str(self.snapshot), "-o", "json"), 2, "--out FILE must be given"),
            ((str(self.directory / "run"),), 74, f"is a directory: give one of its files, as its newest snapshot, {self.snapshot}"),
            ((str(self.directory),), 74, "no snapshot is in it"),
            ((str(self.directory / "none.hdf"),), 74, "cannot read"),
            ((str(self.directory / "run" / "snapshots.hdf.series"),), 74,
             f"is a list of snapshots, which ParaView opens: give one of them, as {self.snapshot}"),
            ((str(nothing),), 74, "HDF5 cannot open it"),
            ((str(checkpoint),), 74, "neither a snapshot nor a series"),
            ((str(self.snapshot), "--out", "/nonexistent/a.csv"), 74, "cannot write the table"),
        ):
            done = self.meniscus("export", *words)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(sentence, done.stderr)
        self.assertEqual(list(self.directory.glob("*.part")), [])


if __name__ == "__main__":
    unittest.main()

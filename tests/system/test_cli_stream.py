# SPDX-License-Identifier: BSD-3-Clause
"""meniscus stream: rows, JSON lines, files for numpy, snapshots; exit codes; and what a killed daemon costs, which is nothing."""

import csv
import json
import sys
import threading
import time
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.daemon import BUILD, SMALL, DaemonTest  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402


class Stream(DaemonTest):
    def setUp(self) -> None:
        self.ask("load", *SMALL)

    def stream(self, *words: str, code: int = 0) -> str:
        return str(self.meniscus("stream", *words, code=code).stdout)

    def test_particles_of_a_box_are_rows(self) -> None:
        rows = list(csv.DictReader(self.stream("fields", "position", "phase", "--first", "--count", "1", "--csv",
                                               "--box", "0,0,0.3,0.2").splitlines()))
        self.assertEqual(list(rows[0]), ["step", "time [s]", "position_x [m]", "position_y [m]", "phase"])
        self.assertTrue(rows and all(0 <= float(r["position_x [m]"]) <= 0.3 and float(r["position_y [m]"]) <= 0.2 for r in rows))

    def test_arrays_for_numpy_are_within_the_bound(self) -> None:
        exact, near = self.home / "exact", self.home / "near"
        for directory, more in ((exact, []), (near, ["--exact", "position=0.001", "--pack", "zstd"])):
            told = self.stream("fields", "position", "id", "--first", "--count", "1", "--to", str(directory), "-o", "json", *more)
            self.assertEqual(json.loads(told)["step"], 0)
        ids = [np.load(directory / "id-0000000000.npy") for directory in (exact, near)]
        positions = [np.load(directory / "position-0000000000.npy") for directory in (exact, near)]
        self.assertTrue((ids[0] == ids[1]).all())
        off = np.abs(positions[0] - positions[1]).max()
        self.assertTrue(0 < off < 0.001)

    def test_probes_and_series_have_the_same_columns(self) -> None:
        self.ask("run-until", "0.02")
        self.ask("checkpoint")
        rows = list(csv.DictReader(self.stream("series", "front", "h1", "--csv", "--timeout", "1", code=124).splitlines()))
        self.assertEqual(list(rows[0]), ["step", "time [s]", "front [m]", "h1 [m]"])
        self.assertEqual(float(rows[0]["time [s]"]), 0)
        item = json.loads(self.stream("probes", "front", "--first", "--count", "1", "-o", "json"))
        self.assertEqual([column["name"] for column in item["columns"]], ["front"])
        self.assertEqual(item["arrays"]["values"]["values"][0], float(rows[-1]["front [m]"]))

    def test_a_series_has_the_same_columns_however_it_is_had(self) -> None:
        """Also where there is no number, as of a front where no water is."""
        nowhere = ["--set", "probes[6].front.within.min=[4, 1]", "--set", "probes[6].front.within.max=[5, 1.5]"]
        run = Path(self.meniscus("load", *SMALL, *nowhere).stdout.strip().rsplit(": ", 1)[1])
        self.ask("run-until", "0.02")
        self.ask("checkpoint")
        streamed = self.stream("series", "--csv", "--timeout", "1", code=124)
        exported = self.meniscus("export", str(run / "probes.hdf")).stdout
        self.assertEqual(list(csv.DictReader(exported.splitlines())), list(csv.DictReader(streamed.splitlines())))
        self.assertIn(",,", streamed)

    def test_snapshots_come_byte_for_byte(self) -> None:
        written = Path(self.ask("snapshot")["path"])
        self.stream("snapshots", "--to", str(self.home / "files"), "--count", "1")
        self.assertEqual((self.home / "files" / written.name).read_bytes(), written.read_bytes())
        self.assertEqual(list((self.home / "files").glob("*.part")), [])

    def test_wrong_usage_is_told_with_exit_code_2_and_a_refusal_with_1(self) -> None:
        for words in (["nothing"], ["fields"], ["snapshots"], ["events", "front"], ["fields", "pressure", "--exact", "0"],
                      ["fields", "pressure", "--exact", "velocity=1"], ["--pack", "gzip"], ["fields", "id", "--box", "1,2"]):
            with self.subTest(words):
                self.stream(*words, code=2)
        self.assertIn("fields[0].name", self.meniscus("stream", "fields", "presure", code=1).stderr)

    def test_a_series_has_no_gap_and_no_duplicate_over_kills_of_the_daemon(self) -> None:
        self.ask("set", "output.probe_interval=0.0005", "output.checkpoint_interval=0.01")
        self.ask("start")
        endpoint = f"ipc://{self.home}/run/meniscus/default/control.ipc"
        taken: list[float] = []
        stop = threading.Event()

        def take() -> None:
            with meniscus.Client(endpoint) as client, client.stream("series") as stream:
                while not stop.is_set():
                    try:
                        item = stream.next(0.5)
                    except meniscus.UnavailableError:
                        continue
                    if item and item.abandoned:
                        del taken[item.row :]
                    elif item:
                        taken.extend(item["time"].tolist())

        taker = threading.Thread(target=take)
        taker.start()
        for _ in range(3):
            time.sleep(3)
            self.daemon.kill()
            self.daemon.wait()
            type(self).start_daemon()
        time.sleep(1)
        self.meniscus("pause")
        self.ask("checkpoint")
        run = Path(self.ask("status")["run_directory"])
        expected = meniscus.ProbeSeries(run).time.tolist()
        for _ in range(100):
            if len(taken) >= len(expected):
                break
            time.sleep(0.1)
        stop.set()
        taker.join()
        self.assertGreater(len(expected), 10)
        self.assertEqual(taken, expected)


if __name__ == "__main__":
    unittest.main(verbosity=2)

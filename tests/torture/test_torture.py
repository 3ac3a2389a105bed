#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""The harness of `make torture`: verdicts, the table, sizes; rows run, one that fails is a miss, and what loads a machine ends by itself."""

import json
import math
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Iterator
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
sys.path.insert(0, str(Path(__file__).resolve().parent))
import torture  # noqa: E402
from daemon import BUILD, free_ports  # noqa: E402
from rows import live, metrics, rubbish  # noqa: E402
from rows.metrics import SIZES, Metric, Report, Size, resized  # noqa: E402


class Table(unittest.TestCase):
    def test_a_value_out_of_its_bounds_or_none_at_all_is_a_miss(self) -> None:
        for value, verdict in ((1, "MISS"), (2, "PASS"), (3, "PASS"), (4, "MISS"), (math.nan, "MISS")):
            self.assertEqual(Metric("m", value, low=2, high=3).verdict, verdict)
        self.assertEqual((Metric("m", 7).verdict, Metric("m", 7).target), ("-", "-"))
        self.assertEqual(Metric("m", 0.5, "ms", high=2).columns("row"), ["row", "m", "<= 2 ms", "0.5 ms", "PASS"])
        self.assertEqual(metrics.none_of("m", 1).verdict, "MISS")
        self.assertEqual([metrics.all_of("m", n, 3).verdict for n in (2, 3)], ["MISS", "PASS"])

    def test_rows_that_are_not_run_keep_their_lines(self) -> None:
        with tempfile.TemporaryDirectory() as scratch, mock.patch.multiple(metrics, HERE=Path(scratch), BUILD=Path(scratch)):
            for row, value in (("b", 1), ("a", 2), ("b", 3)):
                report = Report(["a", "b"], "small")
                report.add(row, Metric("m", value, high=2))
                path = report.write()
            lines = [line for line in path.read_text().splitlines() if line.startswith("| ")]
            self.assertEqual([line.split(" | ")[:5] for line in lines[1:]],
                             [["| a", "m", "<= 2", "2", "PASS"], ["| b", "m", "<= 2", "3", "MISS"]])
            told = json.loads((Path(scratch) / "torture.json").read_text())
            self.assertEqual([(m["row"], m["verdict"], m["low"]) for m in told["metrics"]], [("b", "MISS", None)])
            self.assertFalse(report.passed)

    def test_sizes_are_set_by_name(self) -> None:
        size = resized(SIZES["small"], ["kills=7", "seconds=0.5"])
        self.assertEqual((size.kills, size.seconds, size.queued), (7, 0.5, SIZES["small"].queued))
        for wrong in ("kill=7", "kills=0", "kills=x", "kills"):
            with self.assertRaises(SystemExit):
                resized(SIZES["small"], [wrong])

    def test_what_company_costs_is_told_with_the_unrest_of_the_machine(self) -> None:
        paces, spent = iter([100, 90, 100, 88, 120]), iter([0, 0, 0, 1, 1, 1, 1, 2, 2, 2])
        with mock.patch.multiple(live, pace=lambda *_: next(paces), beside_solver=lambda *_: next(spent)), \
                mock.patch.object(live.os, "sched_getaffinity", return_value={0, 1}):
            lost = live.loss(mock.Mock(), mock.Mock(), 2.0, 2, mock.MagicMock())
        self.assertAlmostEqual(lost.share, 0.15)
        self.assertAlmostEqual(lost.error, 0.05)
        self.assertAlmostEqual(lost.beside, 0.25)

    def test_a_row_that_fails_or_takes_too_long_is_a_miss_and_the_next_is_run(self) -> None:
        def broken(_: Size) -> Iterator[Metric]:
            yield Metric("first", 1, low=1)
            raise ValueError("a | b")

        def slow(_: Size) -> Iterator[Metric]:
            time.sleep(20)
            yield Metric("never", 1)

        rows = {"broken": torture.Row(broken, ""), "slow": torture.Row(slow, "")}
        with mock.patch.object(torture, "ROWS", rows), mock.patch.object(torture.traceback, "print_exc"):
            failed = list(torture.metrics_of("broken", SIZES["small"], 10))
            late = list(torture.metrics_of("slow", SIZES["small"], 1))
        self.assertEqual([m.verdict for m in failed + late], ["PASS", "MISS", "MISS"])
        self.assertIn("ValueError: a / b", failed[1].note)

    def test_inputs_and_sequences_are_counted_and_gone_on_with_until_there_are_as_many_as_were_asked_for(self) -> None:
        fuzzed = [(2, 0, "ok - case: 300 inputs break nothing\nok - journal: 50 inputs break nothing\n")] * 3
        with mock.patch.object(rubbish, "test_program", side_effect=[*fuzzed, (2, 0, "")]):
            broken, inputs, _ = rubbish.frames(resized(SIZES["small"], ["inputs=1000"]))
        self.assertEqual((broken.value, inputs.value, inputs.target, inputs.verdict), (2, 1050, ">= 1000", "PASS"))
        with mock.patch.object(rubbish, "test_program", side_effect=[fuzzed[0], (1, 1, "ok - case: 300 inputs break nothing\n"), (2, 0, "")]), \
                mock.patch.object(rubbish.sys, "stderr"):
            broken, inputs, _ = rubbish.frames(resized(SIZES["small"], ["inputs=1000"]))
        self.assertEqual((broken.verdict, inputs.value, inputs.verdict), ("MISS", 650, "MISS"))
        with mock.patch.object(rubbish, "test_program", side_effect=lambda *_, **words: (1, 0, f"{words['MENISCUS_SEQUENCES']} sequences, 9 commands, ")):
            _, sequences = rubbish.model(resized(SIZES["small"], ["sequences=20500"]))
        runs = math.ceil(20500 / 1000)
        self.assertEqual((sequences.value, sequences.target, sequences.note.split(";")[0]), (20500, ">= 20500", f"{9 * runs} commands"))
        with mock.patch.object(rubbish, "test_program", return_value=(0, 1, "FAILED")) as runs_begun, mock.patch.object(rubbish.sys, "stderr"):
            self.assertEqual([m.verdict for m in rubbish.model(resized(SIZES["small"], ["sequences=100000"]))], ["MISS", "MISS"])
        self.assertLessEqual(runs_begun.call_count, rubbish.DAEMONS)

    def test_tests_are_counted_and_what_was_skipped_has_failed(self) -> None:
        self.assertEqual(live._count("1..3\nok 1 - a\nnot ok 2 - b\nok 3 - c # SKIP\n"), (1, 2))
        self.assertEqual(live._count("....\nRan 4 tests in 1 s\n\nOK\n"), (4, 0))
        self.assertEqual(live._count("Ran 5 tests in 1 s\n\nFAILED (failures=1, errors=2)\n"), (2, 3))
        self.assertEqual(live.test_program(["false"], 5)[:2], (0, 1))
        self.assertEqual(live.test_program(["sleep", "9"], 0.3)[:2], (0, 1))


class Live(unittest.TestCase):
    def test_rows_run_at_any_size(self) -> None:
        small = ["run-until", "pause", "writers", "--set", "runs_until=5", "--set", "pauses=2", "--set", "queued=50",
                 "--set", "resolution=10", "--set", "writers=8", "--set", "seconds=1"]
        done = subprocess.run([sys.executable, torture.__file__, *small], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual({line.split("\t")[0] for line in done.stdout.splitlines()}, {"run-until", "pause", "writers"})
        self.assertIn("no table is written", done.stderr)

    def test_generators_end_by_themselves_and_say_what_they_did(self) -> None:
        with live.Daemon() as daemon, daemon.client() as client:
            live.computing(client, 10)
            with live.beside("subscribers", daemon.telemetry, 50, 2, ready=True) as process:
                told = json.loads(process.communicate(timeout=30)[0])
            self.assertEqual(told["subscribers"], 50)
            self.assertGreaterEqual(told["frames"], 50)
            self.assertGreater(live.told("round_trips", daemon.endpoint, 0.2, 0)["n"], 10)
            self.assertLess(live.told("half_open", free_ports(), 100, 0.3)["begun"], 60)
        for words in (["subscribers", "x"], ["subscribers", "x", "0", "1"], ["round_trips"], ["half_open"], ["capture", "0"]):
            wrong = subprocess.run([BUILD / "tests" / "torture" / words[0], *words[1:]], capture_output=True, text=True)
            self.assertEqual((wrong.returncode, wrong.stderr[:6]), (2, "usage:"), words)


if __name__ == "__main__":
    unittest.main()

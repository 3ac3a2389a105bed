#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What lays schemes side by side: noise that is made up is found, and tables say what came of each run. Nothing is run."""

from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import compare  # noqa: E402
from validation import common  # noqa: E402
from validation.metrics import Metric  # noqa: E402
from validation.runs import ROOT, Snapshot  # noqa: E402

DONE = {"particles": 100, "steps": 20, "cpu_s": 1.26, "wall_s": 2.5, "error": None, "exit_code": 0}
DIVERGED = DONE | {"t": 0.12345, "end_time": 7.0, "exit_code": 70,
                   "error": {"message": "diverged in step 20 at t = 0.1 s: most is due to \"x\". Look at the snapshot"}}
REFUSED = {"steps": 0, "exit_code": 65, "error": {"message": f"{ROOT}/server/cases/a.yaml:3:1: no tension. Take another"}}


def shot(pressure: np.ndarray, x: np.ndarray) -> Snapshot:
    return Snapshot(0, 0.1, x, (x[:, 0] > 2).astype(int), pressure)


class Grain(unittest.TestCase):
    def setUp(self):
        rng = np.random.default_rng(1)
        axis = np.arange(0, 4, 0.1)
        self.x = np.array(np.meshgrid(axis, axis, [0])).reshape(3, -1).T
        self.x[:, :2] += rng.uniform(-0.02, 0.02, (len(self.x), 2))
        self.noise = rng.standard_normal(len(self.x))
        self.linear = 3 * self.x[:, 0] - 5 * self.x[:, 1] + 7

    def test_a_linear_field_has_none_whatever_the_other_fluid_has(self):
        other = np.where(self.x[:, 0] > 2, 1000 * self.noise, 0)
        self.assertLess(common.grain(shot(self.linear + other, self.x), 0), 1e-12)

    def test_noise_shows_as_large_as_it_is(self):
        found = common.grain(shot(self.linear + 2 * self.noise, self.x), 0)
        # That of the particle itself, and that of the neighbours whose mean it is held against.
        self.assertAlmostEqual(found, 2 * np.sqrt(1 + 1 / common.NEAR), delta=0.15)

    def test_spray_does_not_count(self):
        x = np.concatenate([self.x, [[-9.0, -9.0, 0], [-9.1, -9.0, 0]]])
        self.assertLess(common.grain(shot(np.append(self.linear, [1e6, -1e6]), x), 0), 1e-12)


class Tables(unittest.TestCase):
    def row(self, summary: dict, *metrics: Metric) -> compare.Row:
        return compare.Row("riemann", summary, list(metrics))

    def test_errors_are_told_apart_by_how_they_are_measured(self):
        metrics = [Metric("c", "a", 1.1, 1, 0.1, relative=True), Metric("c", "b", -1.6, -2, 0.1, relative=True),
                   Metric("c", "t", 1.3, 1.0, 0.1), Metric("c", "u", 2.5, 3.0, 0.1), Metric("c", "none", 99)]
        relative, other = compare.largest_errors(metrics)
        self.assertAlmostEqual(relative, 0.2)
        self.assertAlmostEqual(other, 0.5)

    def test_a_verdict_is_that_of_the_solver(self):
        self.assertEqual(self.row(DONE, Metric("c", "m", 1)).verdict, "done")
        self.assertEqual(self.row(DIVERGED).verdict, "diverged at t = 0.123 of 7")
        self.assertEqual(self.row(REFUSED).verdict, "refused")
        self.assertEqual(self.row(DIVERGED | {"exit_code": 1}).verdict, "failed")
        self.assertEqual(self.row(REFUSED).reason, "server/cases/a.yaml:3:1: no tension")

    def test_at_equal_cost_errors_lie_on_the_power_through_two_runs(self):
        def rows(cost: float, *errors: float) -> list[compare.Row]:
            return [self.row(DONE | {"cpu_s": cost}, Metric("c", "error", error)) for error in errors]

        text = compare.at_equal_cost("T", rows(1, 0.4, 0.1, 0.2), rows(16, 0.1, 0.1, 0.2)).split("\n")
        # In 4 s the first has half its way; the mean of all errors is 0.16.
        self.assertEqual(text[4], "| scheme | error in 4 s | seconds for an error of 0.16 | error falls as seconds to the power of |")
        self.assertEqual(text[6], "| riemann | 0.2 | 6.3 | -0.50 |")
        self.assertEqual(text[7], "| riemann | 0.1 | under 1 | 0.00 |")
        self.assertEqual(text[8], "| riemann | 0.2 | over 16 | 0.00 |")

    def test_the_report_has_what_is_compared(self):
        titles = [line[3:] for line in compare.REPORT.read_text().splitlines() if line.startswith("## ")]
        self.assertEqual(titles, compare.ORDER)

    def test_a_section_has_a_row_for_each_scheme_and_a_reason_for_each_gap(self):
        comparison = compare.Comparison("a", ("resolution=3",), (), lambda case, r: iter(()))
        rows = [self.row(REFUSED), self.row(DONE, Metric("c", "m", 1.23456, 1.2, 0.1), Metric("c", "n", 5)), self.row(DIVERGED)]
        lines = compare.section("T", comparison, rows).split("\n")
        self.assertEqual(lines[0], "## T")
        self.assertTrue(lines[2].startswith("`a` with `resolution=3`, commit "))
        self.assertEqual(lines[4], "| scheme | m | n | particles | steps | ns per particle and step | processor s | wall s | verdict |")
        self.assertEqual(lines[6], "| reference | 1.2 | - |  |  |  |  |  |  |")
        self.assertEqual(lines[7], "| riemann | - | - | - | - | - | - | - | refused |")
        self.assertEqual(lines[8], "| riemann | 1.235 | 5 | 100 | 20 | 630000 | 1.3 | 2.5 | done |")
        self.assertEqual(lines[9], "| riemann | - | - | 100 | 20 | 630000 | 1.3 | 2.5 | diverged at t = 0.123 of 7 |")
        self.assertEqual(lines[11:], ["- riemann: server/cases/a.yaml:3:1: no tension",
                                      "- riemann: diverged in step 20 at t = 0.1 s: most is due to \"x\""])

    def test_densities_are_told_fluid_by_fluid(self):
        x, phase = np.zeros((4, 3)), np.array([0, 0, 1, 1])
        first = Snapshot(0, 0.1, x, phase, None, np.array([1000.0, 1000, 1, 1]))
        last = Snapshot(1, 0.1, x, phase, None, np.array([1010.0, 990, -0.25, np.nan]))
        self.assertTrue(compare.densities(first, last).endswith(": 0.99 to 1.01; -0.25 to -0.25"))

    def test_sections_that_are_not_made_again_stay(self):
        old = "# Head\n\nwords\n\n## B\n\nold b\n\n## A\n\nold a\n\n## Gone\n\nx\n"
        self.assertEqual(compare.merged(old, {"B": "## B\n\nnew b"}, ["A", "B", "C"]), ["## A\n\nold a", "## B\n\nnew b"])
        self.assertEqual(compare.merged("", {"B": "## B\n\nnew b"}, ["A", "B"]), ["## B\n\nnew b"])


if __name__ == "__main__":
    unittest.main()

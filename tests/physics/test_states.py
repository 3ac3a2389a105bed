#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Which cases a change has touched: those with a run whose state, or what scores it, is another than recorded, those of which nothing is recorded, and
no others."""

from __future__ import annotations

import shutil
import sys
import tempfile
import unittest
from collections.abc import Callable
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).parent))
import validate  # noqa: E402
from validation import sources, states  # noqa: E402

SCORES: "dict[str, Callable]" = dict.fromkeys(("one", "two", "three", "new"), lambda paper: ())
RECORD = {"one": {states.SCORING: "f0", ("a", "x=1"): "11"}, "two": {states.SCORING: "f0", ("a", "x=1"): "11", ("b",): "22"},
          "three": {states.SCORING: "f0", ("c",): states.NONE}}


class States(unittest.TestCase):
    def changed(self, now: "dict[states.Asked, str]", *names: str, scoring: "str | None" = "f0") -> "list[str]":
        with mock.patch.object(states, "state_after", lambda asked: now[asked]), mock.patch.object(states, "scoring", lambda score, runs: scoring):
            return states.changed(names, 2, RECORD, SCORES)

    def test_what_is_as_recorded_is_not_run_again(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11", ("b",): "22", ("c",): states.NONE}, "one", "two", "three"), [])

    def test_another_state_touches_every_case_that_has_the_run(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11", ("b",): "23", ("c",): states.NONE}, "one", "two", "three"), ["two"])
        self.assertEqual(self.changed({("a", "x=1"): "12", ("b",): "22"}, "one", "two"), ["one", "two"])

    def test_a_case_that_was_refused_and_is_not_any_more_is_touched(self) -> None:
        self.assertEqual(self.changed({("c",): "33"}, "three"), ["three"])

    def test_a_case_without_a_record_is_run(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11"}, "one", "new"), ["new"])

    def test_a_case_that_is_scored_otherwise_is_run(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11"}, "one", scoring="f1"), ["one"])

    def test_what_scores_is_what_scores_and_the_cases_that_it_runs(self) -> None:
        score = validate.CASES["hydrostatic"].score
        self.assertNotEqual(states.scoring(score, [("hydrostatic",)]), states.scoring(score, [("hydrostatic",), ("hydrostatic4",)]))
        self.assertNotEqual(states.scoring(score, []), states.scoring(validate.CASES["hydrostatic4"].score, []))
        self.assertEqual(states.scoring(score, [("hydrostatic", "x=1")]), states.scoring(score, [("hydrostatic", "x=2")]))

    def test_the_record_is_of_cases_that_there_are(self) -> None:
        """And says of all whose runs it has what has scored them."""
        record = states.read()
        self.assertLessEqual(record.keys(), validate.CASES.keys())
        self.assertEqual([name for name, of in record.items() if states.SCORING not in of], [])
        self.assertNotIn("metamorphic", record)  # whose runs have no record

    def test_the_record_keeps_what_was_not_run_in_the_order_of_the_cases(self) -> None:
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / "states.txt"
            states.note(RECORD, list(RECORD), path)
            self.assertEqual(states.read(path), RECORD)
            states.note({"two": {("b",): "44"}}, ["two", "one", "three"], path)
            self.assertEqual(states.read(path), RECORD | {"two": {("b",): "44"}})
            self.assertEqual([line.split("\t")[0] for line in path.read_text().splitlines()], ["two", "one", "one", "three", "three"])

    def test_a_state_depends_on_what_is_set(self) -> None:
        small = ("dambreak2d", "resolution=8")
        self.assertRegex(states.state_after(small), "^[0-9a-f]{16}$")
        self.assertNotEqual(states.state_after(small), states.state_after((*small, "gravity=[0, -2]")))
        self.assertEqual(states.state_after((*small, "gravity=down")), states.NONE)


class Sources(unittest.TestCase):
    """What a change of a copy of the package makes of the digests of the cases."""

    def changes(self, file: str, old: str, new: str) -> "set[str]":
        def digests() -> "dict[str, str]":
            return {name: sources.digest(case.score) for name, case in validate.CASES.items()}

        before = digests()
        with tempfile.TemporaryDirectory() as scratch:
            package, reference = Path(scratch) / "validation", Path(scratch) / "reference"
            shutil.copytree(sources.PACKAGE, package)
            shutil.copytree(sources.REFERENCE, reference)
            path = Path(scratch) / file
            text = path.read_text()
            self.assertEqual(text.count(old), 1)
            path.write_text(text.replace(old, new))
            sources.top.cache_clear()
            with mock.patch.multiple(sources, PACKAGE=package, REFERENCE=reference):
                after = digests()
            sources.top.cache_clear()
        return {name for name in before if before[name] != after[name]}

    def test_a_tolerance(self) -> None:
        self.assertEqual(self.changes("validation/bubbles.py", 'r.at("film", t * unit) / RADIUS, thickness(ref, t), wide)',
                                      'r.at("film", t * unit) / RADIUS, thickness(ref, t), 2 * wide)'), {"bubble2d-sussman"})

    def test_what_a_helper_in_another_module_needs(self) -> None:
        scored_there = {name for name, case in validate.CASES.items() if case.score.__module__.rpartition(".")[2] in ("interfaces",)}
        found = self.changes("validation/common.py", "high=1e-13)", "high=1e-12)")
        self.assertLessEqual(scored_there, found)
        self.assertNotIn("multigrid", found)

    def test_a_constant_between_functions(self) -> None:
        self.assertEqual(self.changes("validation/multigrid.py", "STEPS = 12\n", "STEPS = 20\n"), {"multigrid"})

    def test_how_a_run_is_read(self) -> None:
        self.assertEqual(self.changes("validation/runs.py", "np.interp(t, self.t", "np.interp(2 * t, self.t"), set(validate.CASES) - {"curvature"})  # which has no series

    def test_a_reference_whose_name_is_put_together(self) -> None:
        text = (sources.REFERENCE / "P1/rt3d_vof_At0.3.csv").read_text().splitlines()[-1]
        found = self.changes("reference/P1/rt3d_vof_At0.3.csv", text, text + "1")
        self.assertEqual(found, {name for name in validate.CASES if name.startswith("rayleigh-taylor3d")})

    def test_comments_layout_and_order_are_nothing(self) -> None:
        self.assertEqual(self.changes("validation/interfaces.py", "GATE, TANK, SPEED = 0.905, 0.2,", "# As printed\nGATE,TANK, SPEED = 0.905,  0.2,"), set())
        self.assertEqual(self.changes("validation/interfaces.py", '"""P1 4.4 in a slice, at', '"""In a slice, at'), set())
        self.assertEqual(self.changes("validation/interfaces.py", "from validation.common import LONG_STEPS,", "from validation.common import grain, LONG_STEPS,"), set())
        self.assertEqual(self.changes("validation/jobs.py", "self.over = True", "self.over = 1"), set())


if __name__ == "__main__":
    unittest.main()

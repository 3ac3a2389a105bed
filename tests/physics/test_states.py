#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Which cases a change has touched: those with a run whose state is another than recorded, those of which nothing is recorded, and no others."""

from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).parent))
from validation import states  # noqa: E402

RECORD = {"one": {("a", "x=1"): "11"}, "two": {("a", "x=1"): "11", ("b",): "22"}, "three": {("c",): states.NONE}}


class States(unittest.TestCase):
    def changed(self, now: "dict[states.Asked, str]", *names: str) -> "list[str]":
        with mock.patch.object(states, "state_after", lambda asked: now[asked]):
            return states.changed(names, 2, RECORD)

    def test_what_is_as_recorded_is_not_run_again(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11", ("b",): "22", ("c",): states.NONE}, "one", "two", "three"), [])

    def test_another_state_touches_every_case_that_has_the_run(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11", ("b",): "23", ("c",): states.NONE}, "one", "two", "three"), ["two"])
        self.assertEqual(self.changed({("a", "x=1"): "12", ("b",): "22"}, "one", "two"), ["one", "two"])

    def test_a_case_that_was_refused_and_is_not_any_more_is_touched(self) -> None:
        self.assertEqual(self.changed({("c",): "33"}, "three"), ["three"])

    def test_a_case_without_a_record_is_run(self) -> None:
        self.assertEqual(self.changed({("a", "x=1"): "11"}, "one", "new"), ["new"])

    def test_the_record_keeps_what_was_not_run_in_the_order_of_the_cases(self) -> None:
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / "states.txt"
            states.note(RECORD, list(RECORD), path)
            self.assertEqual(states.read(path), RECORD)
            states.note({"two": {("b",): "44"}}, ["two", "one", "three"], path)
            self.assertEqual(states.read(path), RECORD | {"two": {("b",): "44"}})
            self.assertEqual([line.split("\t")[0] for line in path.read_text().splitlines()], ["two", "one", "three"])

    def test_a_state_depends_on_what_is_set(self) -> None:
        small = ("dambreak2d", "resolution=8")
        self.assertRegex(states.state_after(small), "^[0-9a-f]{16}$")
        self.assertNotEqual(states.state_after(small), states.state_after((*small, "gravity=[0, -2]")))
        self.assertEqual(states.state_after((*small, "gravity=down")), states.NONE)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A few of the relations of validation/metamorphic.py, for all schemes at once; and that it sees what is wrong."""

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from validation import metamorphic, retelling  # noqa: E402


class Metamorphic(unittest.TestCase):
    def setUp(self) -> None:
        self.addCleanup(setattr, retelling, "SIZE", retelling.SIZE)
        retelling.SIZE = 12

    def check(self, relation: str, scheme: str) -> None:
        told = {**retelling.full(scheme), "end_time": 0.02}
        change = retelling.CHANGES[relation][0]
        here, there = metamorphic.last(told), change.back(metamorphic.last(change(told)))
        names = retelling.names(told)
        self.assertLessEqual(metamorphic.apart(here, there, names, names), metamorphic.bound(relation, scheme), (relation, scheme))

    def test_a_quarter_turn_and_other_units_are_the_same_flow(self) -> None:
        for scheme in retelling.SCHEMES:
            for relation in ("units scaled by powers of two", "quarter turns"):
                self.check(relation, scheme)

    def test_another_flow_is_seen_as_another(self) -> None:
        told = {**retelling.plain("riemann"), "end_time": 0.02}
        here, other = metamorphic.last(told), metamorphic.last({**told, "gravity": ["0", "-1.001"]})
        self.assertGreater(metamorphic.apart(here, other, ["water"], ["water"]), 1e-6)
        other.x = here.x + np.array([0.0, 1e-3, 0.0])
        self.assertGreater(metamorphic.apart(here, other, ["water"], ["water"]), 0.9e-3)
        other.phase = other.phase[:-1]
        self.assertEqual(metamorphic.apart(here, other, ["water"], ["water"]), np.inf)


if __name__ == "__main__":
    unittest.main()

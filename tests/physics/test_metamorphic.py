#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A few of the relations of validation/metamorphic.py, for all schemes at once; and that it sees what is wrong."""

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from validation import metamorphic, retelling  # noqa: E402
from validation.measures import Seen  # noqa: E402


def shorter(told: retelling.Told) -> retelling.Told:
    return {**told, "end_time": 0.02}


class Metamorphic(unittest.TestCase):
    def check(self, found: metamorphic.Apart, relation: str, scheme: str) -> None:
        self.assertGreater(len(found), 15, (relation, scheme))  # fields and probes
        of, value = max(found.items(), key=lambda item: item[1])
        self.assertLessEqual(value, metamorphic.bound(relation, scheme), (relation, scheme, of))

    def test_a_quarter_turn_and_other_units_are_the_same_flow(self) -> None:
        for scheme in retelling.SCHEMES:
            told = shorter(retelling.full(scheme))
            here = metamorphic.last(told)
            for relation in ("units scaled by powers of two", "quarter turns"):
                change = retelling.CHANGES[relation][0]
                self.check(metamorphic.apart(here, change.back(metamorphic.last(change(told)), told), told), relation, scheme)

    def test_who_moves_sees_the_same_flow(self) -> None:
        """With a free surface where the scheme has one: what is scaled by a speed in the laboratory lifts it."""
        for scheme in retelling.SCHEMES:
            if scheme in retelling.SOUND:
                self.check(metamorphic.moving_surface(scheme, "plain"), "seen from a moving frame, with a free surface", scheme)
            else:
                self.check(metamorphic.moving_frame(scheme, "plain"), "seen from a moving frame", scheme)

    def test_half_of_a_flow_is_half_of_the_whole(self) -> None:
        for scheme in ("incompressible", "differences"):
            self.check(metamorphic.half(scheme, "full"), "half of it beside a slip wall", scheme)

    def test_a_wall_in_two_pieces_is_one(self) -> None:
        for scheme in retelling.SCHEMES:
            told = shorter(retelling.full(scheme))
            pieces = list(retelling.sides(told))[-1]
            self.check(metamorphic.apart(metamorphic.last(told), metamorphic.last(pieces), told), "the tank told in four ways", scheme)

    def test_another_flow_is_seen_as_another(self) -> None:
        told = shorter(retelling.pair("riemann"))
        here, other = metamorphic.last(told), metamorphic.last({**told, "gravity": ["0", "-1.001"]})
        found = metamorphic.apart(here, other, told)
        for of in ("velocity of water", "pressure of water", "density of water", "kinetic_energy", "gauge"):
            self.assertGreater(found[of], 1e-9, of)
        for name in ("surface", "mass_centre-x-oil", "max-density"):
            wrong = Seen(here.snapshot, here.probes | {name: here.probes[name] + 1e-3})
            self.assertGreater(metamorphic.apart(here, wrong, told)[name], 1e-7, name)
            nothing = Seen(here.snapshot, here.probes | {name: np.nan})
            self.assertEqual(metamorphic.apart(here, nothing, told)[name], np.inf)
        moved = metamorphic.view(here.snapshot, x=(0, -1e-3))
        self.assertGreater(metamorphic.apart(here, Seen(moved, here.probes), told)["places of oil"], 0.9e-3)
        broken = metamorphic.view(here.snapshot, here.snapshot.phase >= 0)
        assert broken.pressure is not None
        broken.pressure[0] = np.nan
        self.assertEqual(max(metamorphic.apart(here, Seen(broken, here.probes), told).values()), np.inf)
        fewer = metamorphic.view(here.snapshot, slice(1, None))
        self.assertEqual(max(metamorphic.apart(here, Seen(fewer, here.probes), told).values()), np.inf)


if __name__ == "__main__":
    unittest.main()

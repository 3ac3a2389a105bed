#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""Functions for AVX-512 use its registers, and those for AVX2 not. And both leave the upper halves of the vector registers clean wherever they return to, or call, what is compiled
for any machine: that takes thrice as long otherwise, as each of its instructions waits for the one that wrote the register before, and
nothing else shows it. gcc sees to it, but not where such a function calls one of the same file that is not part of it (INLINE)."""

import os
import re
import subprocess
import sys
import unittest
from pathlib import Path

BUILD = Path(os.environ.get("BUILD", Path(__file__).resolve().parents[2] / "build"))
HEAD = re.compile(r"^([0-9a-f]+) <(.+)>:$")
INSTRUCTION = re.compile(r"^ +([0-9a-f]+):\t(\S+) *(.*)$")
WIDE = re.compile(r"%[yz]mm\d")
COPY = re.compile(r"vmov\w+ %[yz]mm\d+,%[yz]mm\d+$")  # as dirty as what it is of, and that is known
WIDENED = "_ZGV"  # functions of vectors, which take them

Line = tuple[int, str, str]  # address, mnemonic, operands


# Instructions of the fused loops over pairs for AVX-512, in two and three dimensions, and how many of them are of four doubles, where gcc 12.2
# made them: valgrind, which counts those that run, knows none of these. What is fetched in fours, where it could be in eights, shows here.
LOOPS = {
    "density_beside": ((1036, 42), (1135, 53)),
    "dissipation_shape_fused": ((536, 38), (668, 63)),
    "forces_beside": ((3277, 271), (3800, 380)),
    "gas_rates_beside": ((4956, 462), (5349, 591)),
    "gas_rates_fused": ((1436, 88), (1572, 108)),
    "interfacial_density_fused": ((700, 39), (753, 44)),
    "inviscid_fused": ((712, 50), (897, 84)),
    "inviscid_rates_fused": ((627, 35), (676, 42)),
    "jumping_density_fused": ((903, 40), (940, 45)),
    "mean_curvature_beside": ((418, 52), (412, 53)),
    "normal_beside": ((573, 38), (681, 55)),
    "number_density_fused": ((349, 15), (356, 15)),
    "rates_beside": ((2446, 238), (2659, 301)),
    "raw_curvature_beside": ((758, 58), (919, 85)),
    "reconstructed_forces_fused": ((625, 133), (805, 173)),
    "riemann_density_fused": ((620, 153), (666, 182)),
    "riemann_forces_fused": ((583, 129), (720, 169)),
    "shape_beside": ((935, 55), (1136, 88)),
    "sloped_density_fused": ((1114, 292), (1453, 427)),
    "strained_density_fused": ((976, 242), (1223, 339)),
    "transported_forces_fused": ((728, 138), (923, 181)),
    "transported_reconstructed_forces_fused": ((780, 143), (1020, 185)),
    "viscous_fused": ((786, 54), (981, 91)),
    "viscous_rates_fused": ((687, 40), (759, 49)),
    "weighed_density_fused": ((1052, 287), (1326, 393)),
}
MORE = 1.03, 1.1  # of either, before somebody has to look


def functions(program: Path) -> dict[str, list[Line]]:
    """Those of a program that use wide registers."""
    command = ["objdump", "-d", "--no-show-raw-insn", str(program)]
    found: dict[str, list[Line]] = {}
    body: list[Line] = []
    for line in subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines():
        if head := HEAD.match(line):
            body = found[head[2]] = []
        elif part := INSTRUCTION.match(line):
            body.append((int(part[1], 16), part[2], part[3]))
    return {name: lines for name, lines in found.items() if any(WIDE.search(rest) for _, _, rest in lines)}


def target(rest: str) -> int | None:
    """The address a jump names."""
    named = re.match(r"([0-9a-f]+) <", rest)
    return int(named[1], 16) if named else None


def left_dirty(body: list[Line]) -> list[str]:
    """Where the function is left, or calls another, with upper halves that it may have written: along every path of jumps."""
    place = {address: k for k, (address, _, _) in enumerate(body)}
    seen: set[tuple[int, bool]] = set()
    paths = [(0, False)]
    found = set()
    while paths:
        k, dirty = paths.pop()
        if k >= len(body) or (k, dirty) in seen:
            continue
        seen.add((k, dirty))
        address, name, rest = body[k]
        if name in ("vzeroupper", "vzeroall"):
            dirty = False
        elif WIDE.search(rest) and not COPY.match(f"{name} {rest}"):
            dirty = True
        if name.startswith("j"):
            to = place.get(target(rest) or -1)
            if to is not None:
                paths.append((to, dirty))
            elif dirty:
                found.add(f"{address:x}: {name} {rest}")
            if name == "jmp":
                continue
        elif name.startswith("ret"):
            if dirty:
                found.add(f"{address:x}: {name}")
            continue
        elif name.startswith("call") and dirty and WIDENED not in rest:
            found.add(f"{address:x}: {name} {rest}")
        paths.append((k + 1, dirty))
    return sorted(found)


class WideFunctions(unittest.TestCase):
    def test_have_the_width_of_their_level(self) -> None:
        widest = {name: any("%zmm" in rest for _, _, rest in body) for name, body in functions(BUILD / "meniscusd").items()}
        for level, widest_of_level in (("v3", False), ("v4", True)):
            of_level = {name: wide for name, wide in widest.items() if re.search(rf"_{level}(_|$)", name)}
            self.assertGreater(len(of_level), 100, level)
            self.assertEqual([name for name, wide in of_level.items() if wide != widest_of_level], [], level)

    def test_have_no_more_instructions_than_they_had(self) -> None:
        wide = functions(BUILD / "meniscusd")
        for name, of_dimensions in LOOPS.items():
            for dim, bounds in zip((2, 3), of_dimensions):
                with self.subTest(name, dim=dim):
                    body = wide[f"{name}_v4_{dim}_wendland_c2"]
                    for has, had, more in zip((len(body), sum("%ymm" in rest for _, _, rest in body)), bounds, MORE):
                        self.assertLessEqual(has, more * had)

    def test_leave_upper_halves_clean(self) -> None:
        wide = functions(BUILD / "meniscusd")
        self.assertGreater(len(wide), 100, "there are functions for AVX2 and AVX-512")
        dirty = {name: places for name, body in wide.items() if (places := left_dirty(body))}
        self.assertEqual(dirty, {}, f"{len(dirty)} of {len(wide)} functions leave upper halves dirty")

    def test_dirty_ones_would_be_seen(self) -> None:
        call = (2, "call", "1234 <scalar>")
        self.assertEqual(left_dirty([(1, "vmulpd", "%zmm1,%zmm2,%zmm3"), call, (3, "vzeroupper", ""), (4, "ret", "")]), ["2: call 1234 <scalar>"])
        self.assertEqual(left_dirty([(1, "je", "4 <f+3>"), (2, "vmulpd", "%ymm1,%ymm2,%ymm3"), (3, "nop", ""), (4, "ret", "")]), ["4: ret"])
        self.assertEqual(left_dirty([(1, "vmulpd", "%ymm1,%ymm2,%ymm3"), (2, "vzeroupper", ""), (3, "jmp", "99 <other>")]), [])


if __name__ == "__main__":
    if os.uname().machine != "x86_64":
        print("1..0 # SKIP only x86-64 has upper halves")
        sys.exit(0)
    unittest.main(verbosity=2)

# SPDX-License-Identifier: BSD-3-Clause
"""The table of inputs on which the readers of cases agree, that of the command line and that of Python: texts that are refused or taken, and
settings of entries by their paths."""

from dataclasses import dataclass
from typing import Optional, Tuple

HEAD = b"dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [1, 1]}\nend_time: 1\n"
FLUIDS = b"fluids: [{name: water, density: 1, sound_speed: 10}]\n"
# What is wrong in itself comes behind these; of the numbers Python's own float() takes some.
WRONG_ENDS = (
    b"end_time: 2\n", FLUIDS, b"output: {walls: true, walls: true}\n", b"scheme: {riemann: {}, dissipation: {}}\n",
    b"walls: [{name: w, shape: [{box: {min: [0, 0], max: [1, 1]}, ball: {centre: [0, 0], radius: 1}}]}]\n",
    "threads: \u0663\n".encode(), b"threads: 1_0\n", b"threads: +3\n", b"threads: 4294967297\n", b"threads: 1.5\n", b"threads: -1\n",
    b"threads: [1]\n", b"threads: '3'\n", b"threads:\n", b"threads: 1025\n", b"title:\n", b"title: {a: b}\n", b'title: "a\\0b"\n',
    b'title: "a\\x01b"\n', b"limits: 3\n", b"output: {walls: yes}\n", b"output: {walls: True}\n", b"output: {walls: 'true'}\n",
    b"output: {xyzzy: 1}\n", b"gravity: -9.81\n", b"gravity: [1]\n", b"scheme: {kernel: Wendland-c2}\n", b"scheme: {kernel: wendland_c2}\n",
    b"scheme: {kernel: WENDLAND_C2}\n", b"? [a]\n: 1\n", b"title: &t a\n", b"title: !!str a\n", b"title: ! a\n", b"title: *t\n",
    b'title: "\\ud83d\\ude00"\n', b'title: "a\\\\\\ud800"\n', b"scheme: cfl\n", b"scheme: Riemann\n", b"scheme: RIEMANN\n", b"threads: 1.0\n", b"scheme: {RIEMANN: {}}\n", b"fluids: RIEMANN\n", b"output: {fields: velocity}\n", b"scheme: [riemann]\n", b"scheme: {riemann: riemann}\n", b"domain: min\n", b"---\ndimensions: 2\n", b"titel\xff: 1\n", b"title: \xc3\xa4\x01b\n", b"walls: [{name: w, shape: [{outside: true}]}]\n",
    *(b"reference_length: " + wrong + b"\n" for wrong in (
        "\u0661".encode(), b"nan", b".nan", b"0.1abc", b"1,5", b"0x10", b"1e", b"e5", b"+", b".", b"1 2", b"1_000", b"true", b"infinity",
        b"Inf", b".inf", b"1e999", b"1e1_0", b"'1'", b"0", b"-1")),
)
WRONG = [HEAD + FLUIDS + end for end in WRONG_ENDS] + [
    b"", b"# nothing\n", b"- a\n", b"just words", HEAD, FLUIDS, HEAD + b"fluids: {name: water}\n", HEAD + b"fluids: [water]\n",
    HEAD + b"fluids: [{name: water, densty: 1, sound_speed: 10}]\n", b"dimensions: 2\n\tresolution: 3\n"]
RIGHT = [HEAD + FLUIDS + end for end in (
    b"", b"reference_length: +1\n", b"reference_length: 1.\n", b"reference_length: .5\n", b"reference_length: 1e-1\n",
    b"reference_length: 1E+0\n", b"threads: 001\n", b"scheme: {kernel: 'wendland-c2', riemann: {}}\n", b"title: ''\n", b"title: '1'\n", b"title: null\n",
    b"scheme: riemann\n", b"scheme: 'dissipation'\n", b"scheme: {skin: 0.2\t}\n", b"title: a\tb\t# c\n", b'title: "\\U0001f600 \\\\ud800"\n')]


@dataclass(frozen=True)
class Settings:
    """Settings, as --set has them, of a case, in their order."""

    text: bytes
    settings: Tuple[Tuple[str, str], ...]
    blamed: Optional[str] = None  # the entry that is refused; None: all are taken
    setting: str = ""  # the path of the setting that is named beside it; "": the file is


WHOLE = HEAD + FLUIDS
TANK = WHOLE + b"walls: [{name: tank, shape: [{outside: true, box: {min: [0, 0], max: [1, 1]}}]}]\n"
BOX = "{min: [0, 0], max: [0.5, 0.5]}"
SETTINGS = [Settings(*row) for row in (
    (WHOLE, (("resolution", "20"), ("end_time", "2"))),
    (WHOLE, (("scheme", "interfacial"),)),
    (WHOLE, (("scheme", "{riemann: {}}"), ("scheme.dissipation", "{}"))),
    (WHOLE + b"scheme: riemann\n", (("scheme.cfl", "0.1"), ("scheme.riemann.limiter", "2"))),
    (WHOLE + b"scheme: {cfl: 0.1, riemann: {}}\n", (("scheme.dissipation", "{}"),)),
    (WHOLE, (("scheme.cfl", "0.1"), ("scheme.riemann.limiter", "2"))),
    (WHOLE, (("gravity[0]", "0"), ("gravity[1]", "-1"))),
    (WHOLE, (("gravity", "[0, -1]"), ("gravity[0]", "sin(t)"))),
    # One entry in several pieces: only the whole must be right.
    (WHOLE, (("walls[0].name", "tank"), ("walls[0].shape[0].outside", "true"), ("walls[0].shape[0].box", "{min: [0, 0], max: [1, 1]}"))),
    (TANK, (("probes[0].name", "p"), ("probes[0].pressure.at[0]", "0.5"), ("probes[0].pressure.at[1]", "0.5"))),
    (TANK, (("fluids[0].shape[0].box.min", "[0, 0]"), ("fluids[0].shape[0].box.max[0]", "0.5"), ("fluids[0].shape[0].box.max[1]", "0.5"))),
    (WHOLE, (("fluids[0]", "{name: w}"), ("fluids[0].density", "2"), ("fluids[0].sound_speed", "20"))),
    (WHOLE, (("fluids[0].density", "-1"), ("fluids[0]", "{name: water, density: 1, sound_speed: 10}"))),
    (FLUIDS, (("dimensions", "2"), ("resolution", "10"), ("domain.min", "[0, 0]"), ("domain.max", "[1, 1]"), ("end_time", "1"))),
    (HEAD, (("fluids[0]", "{name: water, density: 1, sound_speed: 10}"),)),
    # Refused.
    (WHOLE, (("walls[0].name", "tank"),), "walls[0].shape", "walls[0].name"),
    (WHOLE, (("probes[0].pressure.at", "[0.5, 0.5]"),), "probes[0].name", "probes[0].pressure.at"),
    (WHOLE, (("fluids[0]", "{name: w, density: 2}"),), "fluids[0].sound_speed", "fluids[0]"),
    (HEAD, (("end_time", "2"),), "fluids"),
    (WHOLE, (("end_time", "2"), ("resolution", "0")), "resolution", "resolution"),
    (WHOLE, (("fluids[0].density", "x"), ("fluids[0]", "{name: water, density: 1, sound_speed: 10}")), "fluids[0].density", "fluids[0].density"),
    (WHOLE, (("fluids[0].densty", "1"), ("fluids", "[{name: water, density: 1, sound_speed: 10}]")), "fluids[0].densty", "fluids[0].densty"),
    (WHOLE + b"scheme: dissipation\n", (("scheme.riemann.limiter", "2"), ("scheme", "riemann")), "scheme.riemann.limiter", "scheme.riemann.limiter"),
    (WHOLE, (("scheme", "cfl"),), "scheme", "scheme"),
    (WHOLE, (("scheme", "riemenn"),), "scheme", "scheme"),
    (WHOLE, (("domain", "min"),), "domain", "domain"),
    (WHOLE, (("scheme", "RIEMANN"),), "scheme", "scheme"),
    (WHOLE, (("threads", "1.0"),), "threads", "threads"),
    (WHOLE, (("fluids[0].name", "a b"),), "fluids[0].name", "fluids[0].name"),
    (WHOLE, (("fluids[0]", "{name: a b, density: 1, sound_speed: 10}"),), "fluids[0].name", "fluids[0]"),
    (WHOLE, (("fluids[2].density", "1"),), "fluids[2].density", "fluids[2].density"),
    (WHOLE, (("fluids.density", "1"),), "fluids.density", "fluids.density"),
    (WHOLE, (("fluids[0][0]", "1"),), "fluids[0][0]", "fluids[0][0]"),
    (WHOLE, (("resolution[0]", "1"),), "resolution[0]", "resolution[0]"),
    (WHOLE, (("title.a", "1"),), "title.a", "title.a"),
    (WHOLE, (("scheme.xyzzy.a", "1"),), "scheme.xyzzy.a", "scheme.xyzzy.a"),
    (WHOLE, (("gravity[0]", "[1]"),), "gravity[0]", "gravity[0]"),
    (WHOLE, (("gravity", "1"),), "gravity", "gravity"),
    (WHOLE, (("title", ""),), "title", "title"),
    (WHOLE, (("title", "&a b"),), "title", "title"),
    (WHOLE, (("threads", "1_0"),), "threads", "threads"),
    (WHOLE, (("domain.periodic", "{a: b}"),), "domain.periodic", "domain.periodic"),
)]

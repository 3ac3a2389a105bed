#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python client reads cases by the rules of the command line: the same text is taken by both, or refused by both at the same place."""

import os
import re
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, DaemonTest  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import case  # noqa: E402

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
    b"---\ndimensions: 2\n", b"titel\xff: 1\n", b"title: \xc3\xa4\x01b\n", b"walls: [{name: w, shape: [{outside: true}]}]\n",
    *(b"reference_length: " + wrong + b"\n" for wrong in (
        "\u0661".encode(), b"nan", b".nan", b"0.1abc", b"1,5", b"0x10", b"1e", b"e5", b"+", b".", b"1 2", b"1_000", b"true", b"infinity",
        b"Inf", b".inf", b"1e999", b"1e1_0", b"'1'", b"0", b"-1")),
)
WRONG = [HEAD + FLUIDS + end for end in WRONG_ENDS] + [
    b"", b"# nothing\n", b"- a\n", b"just words", HEAD, FLUIDS, HEAD + b"fluids: {name: water}\n", HEAD + b"fluids: [water]\n",
    HEAD + b"fluids: [{name: water, densty: 1, sound_speed: 10}]\n", b"dimensions: 2\n\tresolution: 3\n"]
RIGHT = [HEAD + FLUIDS + end for end in (
    b"", b"reference_length: +1\n", b"reference_length: 1.\n", b"reference_length: .5\n", b"reference_length: 1e-1\n",
    b"reference_length: 1E+0\n", b"threads: 001\n", b"scheme: {kernel: 'wendland-c2', riemann: {}}\n", b"title: ''\n", b"title: '1'\n", b"title: null\n")]


class OneCorpus(DaemonTest):
    def setUp(self) -> None:
        self.client = meniscus.Client(f"ipc://{self.home}/run/meniscus/default/control.ipc", timeout=50)
        self.addCleanup(self.client.close)
        self.file = self.home / "one.yaml"

    def place_in(self, text: str) -> str:
        found = re.search(re.escape(str(self.file)) + r"(:\d+:\d+)", text)
        return found[1] if found else f"none in: {text}"

    def test_what_one_of_them_refuses_the_other_refuses_at_the_same_place(self) -> None:
        for text in WRONG:
            with self.subTest(text.splitlines()[-1:]):
                self.file.write_bytes(text)
                theirs = self.place_in(self.meniscus("load", str(self.file), code=65).stderr)
                with self.assertRaises(meniscus.CaseError) as caught:
                    self.client.load(self.file)
                self.assertEqual(self.place_in(caught.exception.message), theirs)

    def test_what_one_of_them_takes_the_other_takes_too(self) -> None:
        for text in RIGHT:
            with self.subTest(text.splitlines()[-1:]):
                self.file.write_bytes(text)
                self.meniscus("load", str(self.file))
                theirs = self.client.status().state_hash
                self.client.load(self.file)
                self.assertEqual(self.client.status().state_hash, theirs)

    def test_what_is_longer_than_a_case_may_be_is_refused(self) -> None:
        self.file.write_bytes(HEAD + FLUIDS + b"#" * (16 << 20))
        theirs = self.place_in(self.meniscus("load", str(self.file), code=65).stderr)
        with self.assertRaisesRegex(meniscus.CaseError, "allowed") as caught:
            self.client.load(self.file)
        self.assertEqual(self.place_in(caught.exception.message), theirs)

    def test_what_is_nested_without_end_is_refused(self) -> None:
        self.file.write_bytes(b"domain: " + b"[" * 5000)
        self.meniscus("load", str(self.file), code=65)
        with self.assertRaises(meniscus.CaseError):
            self.client.load(self.file)


class Names(unittest.TestCase):
    def test_a_name_is_that_of_a_shipped_case_and_not_of_a_file_that_happens_to_lie_here(self) -> None:
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch, mock.patch.dict(os.environ):
            os.environ.pop("MENISCUS_CASES", None)
            Path(scratch, "dambreak2d.yaml").write_text("nothing of the kind")
            Path(scratch, "mine.yaml").write_text("title: mine")
            self.addCleanup(os.chdir, os.getcwd())
            os.chdir(scratch)
            self.assertEqual(case.find("dambreak2d"), ROOT / "server/cases/dambreak2d.yaml")
            self.assertEqual(case.find("mine.yaml"), Path("mine.yaml"))
            with self.assertRaises(meniscus.CaseError):
                case.find("mine")
            os.environ["MENISCUS_CASES"] = scratch
            self.assertEqual(case.find("mine"), Path(scratch, "mine.yaml"))


class Overrides(unittest.TestCase):
    def test_a_path_is_one_of_the_command_line(self) -> None:
        for path in ("fluids.0.density", "fluids[\u0661].density", "fluids[1", "fluids[1]density", "fluids[].density", ".resolution", "a..b", "",
                     "title.a", "title[0]", "fluids[9].density"):
            with self.subTest(path), self.assertRaises(meniscus.CaseError):
                text = case.CaseText(ROOT / "server/cases/dambreak2d.yaml")
                text.set(path, 1)
                text.message()

    def test_the_index_after_the_last_appends_to_a_list_that_is_not_there_too(self) -> None:
        text = case.CaseText({})
        text.set("gravity[0]", 1)
        text.set("gravity[1]", -2)
        self.assertEqual(list(text.message().gravity), ["1", "-2"])

    def test_a_member_of_a_choice_that_is_set_as_a_whole_takes_the_place_of_the_other(self) -> None:
        text = case.CaseText({"scheme": {"skin": 0.2, "riemann": {}}})
        text.set("scheme.dissipation", {})
        scheme = text.message().scheme
        self.assertEqual((scheme.WhichOneof("method"), scheme.skin), ("dissipation", 0.2))
        text.set("scheme.riemann.limiter", 2)
        with self.assertRaisesRegex(meniscus.CaseError, 'override scheme.riemann.limiter: .*"dissipation" and "riemann" exclude each other'):
            text.message()


if __name__ == "__main__":
    unittest.main()

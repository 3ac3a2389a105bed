#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python client reads cases by the rules of the command line: the same text is taken by both, or refused by both at the same place."""

import os
import re
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from case_inputs import FLUIDS, HEAD, RIGHT, SETTINGS, WRONG, Settings  # noqa: E402
from daemon import BUILD, ROOT, DaemonTest  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import case  # noqa: E402


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

    def said(self, text: str) -> str:
        """What is wrong and what is allowed, but for bounds and the kind of a list's items, which the client does not know."""
        return re.sub(r"(?<=allowed: )(a |any )?(whole )?number.*|(?<=allowed: )[\[(].*|, of a (mapping|text|number).*", "", text.splitlines()[0])

    def test_both_say_what_is_allowed_in_the_same_words(self) -> None:
        n = 0
        for text in WRONG:
            self.file.write_bytes(text)
            theirs = self.meniscus("load", str(self.file), code=65).stderr
            with self.assertRaises(meniscus.CaseError) as caught:
                self.client.load(self.file)
            if "llowed: " in theirs:
                n += 1
                with self.subTest(text.splitlines()[-1:]):
                    self.assertEqual(self.said(caught.exception.message), self.said(theirs))
        self.assertGreater(n, 30)
        for row in SETTINGS:
            if row.blamed:
                self.file.write_bytes(row.text)
                with self.subTest(row.settings), self.assertRaises(meniscus.CaseError) as caught:
                    self.client.load(self.file, dict(row.settings))
                self.assertLessEqual(caught.exception.message.count(f"{row.blamed}: "), 1)

    def test_what_one_of_them_takes_the_other_takes_too(self) -> None:
        for text in RIGHT:
            with self.subTest(text.splitlines()[-1:]):
                self.file.write_bytes(text)
                self.meniscus("load", str(self.file))
                theirs = self.client.status().state_hash
                self.client.load(self.file)
                self.assertEqual(self.client.status().state_hash, theirs)

    def written(self) -> "str | None":
        """The case as the daemon has it."""
        directory = self.client.status().run_directory
        return directory and Path(directory, "case.yaml").read_text()

    def test_settings_are_taken_by_both_or_refused_by_both_for_the_same_reason(self) -> None:
        for row in SETTINGS:
            with self.subTest(row.settings):
                self.file.write_bytes(row.text)
                words = [word for path, value in row.settings for word in ("--set", f"{path}={value}")]
                theirs = self.ask("load", str(self.file), *words, code=65 if row.blamed else 0).get("error")
                if row.blamed:
                    self.is_refused(row, theirs)
                    continue
                written = self.written()
                self.client.load(self.file, dict(row.settings))
                self.assertEqual(self.written(), written)

    def is_refused(self, row: Settings, theirs: Any) -> None:
        with self.assertRaises(meniscus.CaseError) as caught:
            self.client.load(self.file, dict(row.settings))
        ours = caught.exception
        self.assertEqual((theirs["path"], ours.path), (row.blamed, row.blamed))
        in_file = str(self.file) + ":"
        self.assertRegex(theirs["message"], "^" + re.escape(f"--set {row.setting}=" if row.setting else in_file))
        self.assertRegex(ours.message, "^" + re.escape(f"override {row.setting}: " if row.setting else in_file))

    def test_what_is_longer_than_a_case_may_be_is_refused(self) -> None:
        self.file.write_bytes(HEAD + FLUIDS + b"#" * (16 << 20))
        theirs = self.place_in(self.meniscus("load", str(self.file), code=65).stderr)
        with self.assertRaisesRegex(meniscus.CaseError, "allowed") as caught:
            self.client.load(self.file)
        self.assertEqual(self.place_in(caught.exception.message), theirs)

    def test_what_is_nested_without_end_is_refused(self) -> None:
        self.file.write_bytes(b"domain: " + b"[" * 300_000)
        self.meniscus("load", str(self.file), code=65, timeout=20)
        begun = time.process_time()
        with self.assertRaisesRegex(meniscus.CaseError, "nested deeper than those of any case"):
            self.client.load(self.file)
        self.assertLess(time.process_time() - begun, 20)  # it took minutes


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
        with self.assertRaisesRegex(meniscus.CaseError, 'override scheme.riemann.limiter: .*"dissipation", which excludes "riemann"'):
            text.set("scheme.riemann.limiter", 2)
        self.assertEqual(text.message().scheme, scheme)


if __name__ == "__main__":
    unittest.main()

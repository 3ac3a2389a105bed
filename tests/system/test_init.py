#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""meniscus init: what it writes is a case that runs, and nothing is lost to it."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT  # noqa: E402

CASES = ROOT / "server" / "cases"


class Init(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)

    def meniscus(self, *words: str, code: int = 0) -> "subprocess.CompletedProcess[str]":
        environment = os.environ | {"MENISCUS_CASES": str(CASES), "OMP_WAIT_POLICY": "passive"}
        done = subprocess.run(
            [BUILD / "meniscus", *words], env=environment, cwd=self.home, capture_output=True, text=True, timeout=60
        )
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_the_case_it_writes_runs_and_says_so(self) -> None:
        said = self.meniscus("init").stdout
        self.assertIn("meniscus run case.yaml\n", said)
        self.assertIn("meniscus load case.yaml --start\n", said)
        text = (self.home / "case.yaml").read_text()
        self.assertGreater(text.count("#"), 15)
        run = self.meniscus("run", "case.yaml", "--set", "resolution=10", "--set", "end_time=0.02", "-o", "json")
        result = json.loads(run.stdout)
        self.assertEqual(result["state"], "DONE")
        self.assertEqual(set(result["probes"]), {"front", "impact", "energy"})

    def test_a_case_that_came_along_is_copied_to_the_letter(self) -> None:
        for number, source in enumerate(sorted(CASES.glob("*.yaml"))[::12]):
            done = json.loads(self.meniscus("init", f"{number}.yaml", "--from", source.stem, "-o", "json").stdout)
            self.assertEqual(set(done), {"file", "from", "next"})
            self.assertEqual((done["file"], done["from"]), (f"{number}.yaml", str(source)))
            self.assertEqual((self.home / f"{number}.yaml").read_bytes(), source.read_bytes())

    def test_a_copy_has_the_name_of_its_case(self) -> None:
        self.assertIn("meniscus run dambreak2d.yaml", self.meniscus("init", "--from", "dambreak2d").stdout)
        self.assertTrue((self.home / "dambreak2d.yaml").exists())

    def test_a_file_that_is_there_stays_as_it_is(self) -> None:
        (self.home / "case.yaml").write_text("mine")
        done = self.meniscus("init", "-o", "json", code=74)
        self.assertIn("case.yaml is there already", json.loads(done.stdout)["error"]["message"])
        self.assertEqual((self.home / "case.yaml").read_text(), "mine")
        (self.home / "link.yaml").symlink_to(self.home / "nowhere")
        self.meniscus("init", "link.yaml", code=74)
        self.assertFalse((self.home / "nowhere").exists())

    def test_a_dash_is_standard_output(self) -> None:
        self.assertIn("title: A column of water", self.meniscus("init", "-").stdout)
        self.assertEqual(self.meniscus("init", "-", "--from", "dambreak2d").stdout, (CASES / "dambreak2d.yaml").read_text())
        self.meniscus("init", "-", "-o", "json", code=2)
        self.assertEqual(list(self.home.iterdir()), [])

    def test_a_case_that_is_none_is_refused_and_nothing_written(self) -> None:
        done = self.meniscus("init", "--from", "dambrake2d", code=65)
        self.assertIn('did you mean "dambreak2d"', done.stderr)
        (self.home / "bad.yaml").write_text("dimensions: 7\n")
        done = self.meniscus("init", "new.yaml", "--from", "bad.yaml", code=65)
        self.assertTrue(done.stderr.startswith("bad.yaml:1:"), done.stderr)
        self.meniscus("init", "a", "b", code=2)
        self.meniscus("init", "", code=2)
        self.assertEqual([path.name for path in self.home.iterdir()], ["bad.yaml"])


if __name__ == "__main__":
    unittest.main()

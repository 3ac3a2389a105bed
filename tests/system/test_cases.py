#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Each case that comes along runs in a daemon, loaded by its name; in space with half the particles along each side, as some have a hundred thousand."""

import re
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import ROOT, DaemonTest  # noqa: E402


class Cases(DaemonTest):
    def test_each_case_takes_steps_in_a_daemon(self) -> None:
        cases = sorted((ROOT / "server" / "cases").glob("*.yaml"))
        self.assertGreater(len(cases), 30)
        for case in cases:
            with self.subTest(case.stem):
                text = case.read_text()
                coarser = []
                if re.search(r"^dimensions: 3", text, re.MULTILINE):
                    found = re.search(r"^resolution: (\S+)", text, re.MULTILINE)
                    assert found
                    coarser = ["--set", f"resolution={float(found[1]) / 2:g}"]
                self.meniscus("load", case.stem, *coarser)
                self.meniscus("step", "2")
                ended = re.search(r"^end_time: 0$", text, re.MULTILINE)
                self.meniscus("wait", "--for", "state=DONE" if ended else "step=2")
                self.assertEqual(self.ask("status")["state"], "DONE" if ended else "PAUSED")
                self.meniscus("stop")


if __name__ == "__main__":
    unittest.main()

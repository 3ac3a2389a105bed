#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Each case that comes along runs in a daemon, loaded by its name; with half the particles along each side, as some have a hundred thousand."""

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
                written = re.search(r"^resolution: (\S+)", case.read_text(), re.MULTILINE)
                assert written
                self.meniscus("load", case.stem, "--set", f"resolution={float(written[1]) / 2:g}")
                self.meniscus("step", "2")
                self.meniscus("wait", "--for", "step=2")
                status = self.ask("status")
                self.assertEqual((status["state"], status["step"]), ("PAUSED", 2))
                self.assertGreater(status["t"], 0)
                self.meniscus("stop")


if __name__ == "__main__":
    unittest.main()

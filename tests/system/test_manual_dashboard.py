#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make check CI=1
"""The manual page of the dashboard, which is built with it alone."""

import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from test_manual import complaints, options_of, shown  # noqa: E402


class DashboardManual(unittest.TestCase):
    def test_roff_has_nothing_to_complain_about(self) -> None:
        self.assertEqual(complaints("meniscus-dashboard.8"), (0, ""))

    def test_the_page_of_the_dashboard_has_every_option(self) -> None:
        page = shown("meniscus-dashboard.8")
        options = options_of("meniscus-dashboard")
        self.assertGreater(len(options), 5)
        for option in options:
            self.assertIn(option, page)
        self.assertIn("WHO MAY", page)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Manual pages: roff that nothing complains about, with all that the tables have."""

import json
import re
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT  # noqa: E402

PAGES = ("meniscus.1", "meniscusd.8", "meniscus-case.5")  # that of the dashboard: test_manual_dashboard.py


def shown(page: str) -> str:
    """As a reader sees it, in one line."""
    words = ["man", "-P", "cat", "-l", str(BUILD / "man" / page)]
    done = subprocess.run(words, env={"LC_ALL": "C.UTF-8", "MANWIDTH": "500", "PATH": "/usr/bin:/bin", "MAN_KEEP_FORMATTING": ""},
                          capture_output=True, text=True, check=True, timeout=30)  # fmt: skip
    return " ".join(re.sub(r".\x08", "", done.stdout).split())


def complaints(page: str) -> "tuple[int, str]":
    """Of roff: the exit status, and what it says."""
    words = ["man", "--warnings=w", "-E", "UTF-8", "-l", "-Tutf8", "-Z", str(BUILD / "man" / page)]
    done = subprocess.run(words, env={"LC_ALL": "C.UTF-8", "MANWIDTH": "100", "PATH": "/usr/bin:/bin"}, capture_output=True, text=True, timeout=60)
    return done.returncode, done.stderr


def options_of(program: str) -> "set[str]":
    """All that its help names."""
    text = subprocess.run([BUILD / program, "--help"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"--[a-z-]+", text))


class Manual(unittest.TestCase):
    def test_roff_has_nothing_to_complain_about(self) -> None:
        for page in PAGES:
            self.assertEqual(complaints(page), (0, ""), page)

    def test_the_page_of_the_client_has_every_command_and_option(self) -> None:
        page = shown("meniscus.1")
        help_text = subprocess.run([BUILD / "meniscus", "help", "-o", "json"], capture_output=True, text=True, check=True).stdout
        tables = json.loads(help_text)
        for command in tables["commands"]:
            heading = f"{command['name']} {command['arguments'] or ''}".strip()
            self.assertIn(f"{heading} {command['help'][0].upper()}{command['help'][1:]}.", page)
            for option in command["options"]:
                self.assertIn(f"--{option['name']}", page)
                self.assertIn(option["help"].replace("`", ""), page)
        for row in tables["exit_codes"]:
            self.assertIn(f"{row['code']} {row['meaning']}", page)
        self.assertIn("A daemon is named by --daemon", page)

    def test_the_page_of_the_daemon_has_every_option(self) -> None:
        page = shown("meniscusd.8")
        options = options_of("meniscusd")
        self.assertGreater(len(options), 20)
        for option in options:
            self.assertIn(option, page)
        self.assertIn("--state-dir=DIR Where runs keep their files", page)
        self.assertIn("75 stopped by a signal", page)

    def test_the_page_of_the_case_has_every_entry(self) -> None:
        page = shown("meniscus-case.5")
        reference = (ROOT / "server" / "cases" / "REFERENCE.md").read_text()
        entries = set(re.findall(r"(?m)^\| `([a-z_]+)` \|", reference))
        self.assertGreater(len(entries), 80)
        for entry in entries:
            self.assertIn(f" {entry} ", page)
        self.assertNotIn("`", page)
        self.assertNotIn("](", page)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Limits that the system sets for a process, as batch systems, containers and service units do: said in a sentence, or made do with."""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, free_ports, start_in, surroundings  # noqa: E402

CASE = ["dambreak2d", "--set", "threads=1", "--set", "resolution=10", "--set", "end_time=0.1"]
Done = subprocess.CompletedProcess[str]


def limited(limits: str, *words: "str | Path") -> "list[str | Path]":
    """The words of a command under limits of the shell."""
    return ["bash", "-c", f'{limits}; exec "$@"', "bash", *words]


class Alone(unittest.TestCase):
    """Programs in a directory of their own, without a daemon."""

    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-limits-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        self.environment = surroundings(self.home)

    def under(self, limits: str, *words: "str | Path", code: int, **more: str) -> Done:
        """Run a command under limits; its standard error is a file, as in batch systems."""
        with open(self.home / "errors", "w+", encoding="utf-8") as errors:
            done = subprocess.run(limited(limits, *words), env=self.environment | more, stdout=subprocess.PIPE, stderr=errors,
                                  text=True, timeout=120, cwd=self.home)  # fmt: skip
            errors.seek(0)
            done.stderr = errors.read()
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def assert_whole(self, directory: Path) -> None:
        for path in directory.glob("*.hdf"):
            with h5py.File(path) as file:
                self.assertTrue(list(file))
        self.assertEqual(list(directory.rglob("*.tmp")), [])


class FileSize(Alone):
    """`ulimit -f`, LimitFSIZE=: the signal SIGXFSZ ends programs that do not care."""

    def run_under(self, blocks: int, *more: str) -> "tuple[Done, dict[str, Any]]":
        done = self.under(f"ulimit -f {blocks}", BUILD / "meniscus", "run", *CASE, *more, "--out", "r", "-o", "json", code=74)
        return done, json.loads(done.stdout)

    def test_a_run_whose_state_is_longer_than_a_file_may_be_is_refused(self) -> None:
        done, told = self.run_under(100)
        self.assertRegex(done.stderr, r"it has \d+ kB, and the limit on the size of files is 102 kB; raise the limit \(`ulimit -f`")
        self.assertEqual(told["exit_code"], 74)

    def test_a_run_that_meets_the_limit_keeps_its_state(self) -> None:
        """Probes write a file that grows beyond it."""
        done, told = self.run_under(100, "--set", "resolution=6", "--set", "output.probe_interval=1e-5", "--set", "end_time=9")
        self.assertIn("File too large; raise the limit on the size of files (`ulimit -f`", done.stderr)
        self.assertEqual(told["state"], "FAULT")
        self.assert_whole(self.home / "r")
        self.assertTrue((self.home / "r" / f"checkpoint-{told['steps']:010d}.hdf").exists())

    def test_what_is_printed_into_a_file_is_whole_or_refused(self) -> None:
        words = limited("ulimit -f 1", BUILD / "meniscus", "completion", "bash")
        with open(self.home / "out", "wb") as out:
            done = subprocess.run(words, env=self.environment, stdout=out, stderr=subprocess.PIPE, timeout=60)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn(b"File too large", done.stderr)


class FileSizeOfDaemon(DaemonTest):
    """A daemon that can write no file at all, its log neither, still answers, also from afar."""

    @classmethod
    def start_daemon(cls) -> None:
        cls.environment["MENISCUS_KEYS"] = str(cls.home / "keys")
        subprocess.run([BUILD / "meniscus", "keys", "new", "eve", "--role", "operator"], env=cls.environment, check=True,
                       stdout=subprocess.DEVNULL)  # fmt: skip
        cls.far = f"tcp://127.0.0.1:{free_ports()}"
        program = cls.home / "limited"
        program.write_text(f'#!/bin/bash\nulimit -f 0\nexec {BUILD}/meniscusd "$@"\n')
        program.chmod(0o755)
        cls.options = ["--listen", cls.far]
        cls.daemon = start_in(cls.home, cls.environment, cls.options, program)

    def test_it_answers_and_refuses_what_it_cannot_keep(self) -> None:
        key = str(self.home / "keys" / "eve.key")
        self.assertEqual(self.ask("status", "--daemon", self.far, "--key", key)["state"], "EMPTY")
        refused = self.meniscus("load", *CASE, code=74).stderr
        self.assertIn("File too large; raise the limit on the size of files", refused)
        self.assertEqual(self.ask("status", "--daemon", self.far, "--key", key)["state"], "EMPTY")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""meniscus doctor: what is well is said in a line, what is not with a remedy, and scripts are told."""

import socket
import importlib.util
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, SMALL, DaemonTest  # noqa: E402

ALWAYS = {"programs", "instructions", "threads", "memory", "cases", "sockets", "daemon", "state", "keys", "python", "paraview",
          "dashboard"}  # fmt: skip


class Doctor(DaemonTest):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)
        self.before = dict(self.environment)
        self.environment["MENISCUS_KEYS"] = str(self.scratch / "keys")
        self.environment.pop("MENISCUS_LEVEL", None)

    def tearDown(self) -> None:
        self.environment.clear()
        self.environment.update(self.before)
        super().tearDown()

    def examine(self, *words: str, code: int = 0) -> dict:
        """What is said of each thing, by its name."""
        said = self.ask("doctor", "--state-dir", str(self.scratch), *words, code=code)
        self.assertEqual(set(said), {"checks", "problems", "warnings", "version"})
        for check in said["checks"]:
            self.assertEqual(set(check), {"name", "status", "text", "remedy"})
        self.assertEqual(said["problems"], sum(check["status"] == "problem" for check in said["checks"]))
        return {check["name"]: check for check in said["checks"]}

    def elsewhere(self) -> Path:
        """Another place for sockets, without a daemon."""
        run = self.scratch / "run"
        run.mkdir(mode=0o700)
        self.environment["XDG_RUNTIME_DIR"] = str(run)
        return run

    def test_a_daemon_that_answers_is_well(self) -> None:
        checks = self.examine()
        self.assertEqual(set(checks), ALWAYS)
        self.assertNotIn("problem", {check["status"] for check in checks.values()})
        self.assertEqual(checks["daemon"]["status"], "ok")
        self.assertIn("EMPTY", checks["daemon"]["text"])
        self.assertIn("protocol", checks["daemon"]["text"])

    def test_there_is_a_line_for_each_thing(self) -> None:
        lines = self.meniscus("doctor").stdout.splitlines()
        self.assertEqual({line.split()[1] for line in lines[:-1]}, ALWAYS)
        self.assertTrue({line.split()[0] for line in lines[:-1]} <= {"ok", "warning"})
        self.assertRegex(lines[-1], "^0 problems, [0-9]+ warnings?$")

    def test_what_python_lacks_is_named(self) -> None:
        lacking = self.scratch / "meniscus"
        lacking.mkdir()
        (lacking / "__init__.py").write_text("import no_such_module\n")
        for path, status, words in ((str(BUILD / "python"), "ok", "can import"), (str(self.scratch), "warning", "no_such_module"),
                                    ("/nonexistent", "ok", "PYTHONPATH")):  # fmt: skip
            if path == "/nonexistent" and importlib.util.find_spec("meniscus"):
                continue  # it is installed here
            self.environment |= {"PYTHONPATH": path, "PATH": "/usr/bin:" + self.environment["PATH"]}
            python = self.examine()["python"]
            self.assertEqual(python["status"], status, python)
            self.assertIn(words, python["text"])

    def test_it_looks_where_the_daemon_keeps_its_run(self) -> None:
        self.meniscus("load", *SMALL)
        said = {check["name"]: check["text"] for check in self.ask("doctor")["checks"]}
        self.assertIn("READY, case dambreak2d", said["daemon"])
        self.assertTrue(said["state"].startswith(str(self.home / "state")), said["state"])

    def test_that_no_daemon_runs_is_no_problem_but_is_said(self) -> None:
        self.elsewhere()
        daemon = self.examine()["daemon"]
        self.assertEqual(daemon["status"], "ok")
        self.assertIn("`meniscusd --name default &`", daemon["remedy"])
        self.assertEqual(self.examine("--daemon", "nobody")["daemon"]["status"], "warning")

    def test_a_socket_that_nobody_hears_is_told_from_a_daemon(self) -> None:
        place = self.elsewhere() / "meniscus" / "default"
        place.mkdir(mode=0o700, parents=True)
        place.parent.chmod(0o700)
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(place / "control.ipc"))
        daemon = self.examine()["daemon"]
        self.assertEqual(daemon["status"], "warning")
        self.assertIn("has ended", daemon["text"])

    def test_sockets_where_others_can_look_are_a_problem(self) -> None:
        place = self.elsewhere() / "meniscus"
        place.mkdir()
        place.chmod(0o755)
        sockets = self.examine(code=1)["sockets"]
        self.assertEqual((sockets["status"], sockets["remedy"]), ("problem", f"chmod 700 {place}"))

    def test_a_runtime_directory_that_is_not_there_is_a_problem_as_it_is_to_the_daemon(self) -> None:
        self.elsewhere()
        self.environment["XDG_RUNTIME_DIR"] = missing = str(self.scratch / "not" / "there")
        sockets = self.examine(code=1)["sockets"]
        self.assertIn(f"there is no {missing}", sockets["text"])
        self.assertIn("unset XDG_RUNTIME_DIR", sockets["remedy"])
        done = subprocess.run([BUILD / "meniscusd"], env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 74)
        self.assertIn("unset XDG_RUNTIME_DIR", done.stderr)

    def test_a_path_too_long_for_a_socket_is_a_problem(self) -> None:
        self.elsewhere()
        self.environment["XDG_RUNTIME_DIR"] = str(self.scratch / ("x" * 90))
        self.assertIn("too long", self.examine(code=1)["sockets"]["text"])

    def test_keys_that_others_can_read_are_a_problem(self) -> None:
        self.meniscus("keys", "new", "ada", "--role", "viewer")
        self.assertTrue(self.examine()["keys"]["text"].startswith("1 let in"))
        (self.scratch / "keys" / "ada.key").chmod(0o644)
        keys = self.examine(code=1)["keys"]
        self.assertEqual(keys["status"], "problem")
        self.assertIn("chmod 600", keys["text"])

    def test_a_key_that_cannot_be_read_is_told_once(self) -> None:
        words = ["--daemon", "tcp://192.0.2.1:9999"]
        self.environment["MENISCUS_KEY"] = missing = str(self.scratch / "nonexistent")
        checks = self.examine(*words, code=1)
        self.assertEqual([name for name, check in checks.items() if missing in check["text"]], ["own key"])
        self.assertIn("meniscus keys new", checks["own key"]["remedy"])
        self.assertIn("own key", checks["daemon"]["remedy"])

    def test_files_that_cannot_be_written_are_a_problem(self) -> None:
        said = self.ask("doctor", "--state-dir", "/dev/null/x", code=1)
        state = next(check for check in said["checks"] if check["name"] == "state")
        self.assertEqual(state["status"], "problem")
        self.assertIn("--state-dir", state["remedy"])

    def test_a_level_that_this_machine_has_not_is_a_problem(self) -> None:
        self.environment["MENISCUS_LEVEL"] = "z80"
        self.assertEqual(self.examine(code=1)["programs"]["status"], "problem")

    def test_cases_are_counted(self) -> None:
        number = len(list(Path(self.environment["MENISCUS_CASES"]).glob("*.yaml")))
        self.assertTrue(self.examine()["cases"]["text"].startswith(f"{number} came along"))


if __name__ == "__main__":
    unittest.main()

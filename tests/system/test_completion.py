#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""Completion: a shell offers what the tables have, and what is there."""

import json
import os
import pty
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, SMALL, DaemonTest  # noqa: E402

CASES = ROOT / "server" / "cases"
SPLIT = r"""
. "$1"
COMP_WORDS=("${@:2}") COMP_CWORD=$(($# - 2))
case $2 in *meniscusd | *dashboard) _meniscus_service ;; *) _meniscus ;; esac
printf '%s\n' "${COMPREPLY[@]}"
"""


def finish_in_zsh(test: unittest.TestCase, environment: "dict[str, str]", home: Path, typed: "tuple[tuple[bytes, bytes], ...]") -> None:
    """In one that is used as people do, at a terminal. What is there already need not be drawn again."""
    script = home / "_meniscus"
    script.write_text(subprocess.run([BUILD / "meniscus", "completion", "zsh"], stdout=subprocess.PIPE, text=True, check=True, timeout=20).stdout)
    pid, terminal = pty.fork()
    if pid == 0:
        os.execvpe("zsh", ["zsh", "-f", "-i"], environment | {"PATH": f"{BUILD}:{os.environ['PATH']}", "PS1": "> ", "TERM": "vt100"})
    test.addCleanup(os.waitpid, pid, 0)
    test.addCleanup(os.kill, pid, signal.SIGKILL)
    test.addCleanup(os.close, terminal)
    shown = b""

    def see(words: bytes) -> None:
        nonlocal shown
        until = time.monotonic() + 20
        while words not in shown and time.monotonic() < until:
            if select.select([terminal], [], [], 0.2)[0]:
                shown += os.read(terminal, 4096)
        test.assertIn(words, shown)
        shown = b""

    os.write(terminal, f"autoload -Uz compinit; compinit -u -D; source {script}; print rea''dy\n".encode())
    see(b"ready")
    for keys, finished in typed:
        os.write(terminal, keys)
        see(finished)


class Completion(unittest.TestCase):
    script: Path

    @classmethod
    def setUpClass(cls) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        cls.addClassCleanup(scratch.cleanup)
        cls.script = Path(scratch.name) / "meniscus.bash"
        with open(cls.script, "w") as file:
            subprocess.run([BUILD / "meniscus", "completion", "bash"], stdout=file, check=True, timeout=20)

    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        self.environment = os.environ | {"MENISCUS_CASES": str(CASES), "XDG_RUNTIME_DIR": scratch.name}

    def meniscus(self, *words: str, code: int = 0) -> str:
        done = subprocess.run([BUILD / "meniscus", *words], env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout

    def offers(self, *words: str, program: Path = BUILD / "meniscus") -> set[str]:
        """What bash offers for the last word, of words as bash takes them apart."""
        done = subprocess.run(
            ["bash", "-c", SPLIT, "bash", self.script, program, *words], env=self.environment, cwd=self.home,
            capture_output=True, text=True, timeout=20,
        )  # fmt: skip
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return set(done.stdout.split())

    def test_commands_are_those_of_the_table(self) -> None:
        commands = {c["name"] for c in json.loads(self.meniscus("help", "-o", "json"))["commands"]}
        self.assertEqual(self.offers(""), commands)
        self.assertEqual(self.offers("run-"), {"run-until"})
        self.assertEqual(self.offers("help", "doc"), {"doctor"})
        self.assertEqual(self.offers("--timeout", "5", "-o", "json", "watc"), {"watch"})

    def test_each_command_has_its_options(self) -> None:
        tables = json.loads(self.meniscus("help", "-o", "json"))
        for command in tables["commands"]:
            given = {o for o in self.offers(command["name"], "-") if o.startswith("--")}
            expected = {f"--{option['name']}" for option in command["options"]}
            self.assertTrue(expected <= given and {"--output", "--help"} <= given, command["name"])
        self.assertNotIn("--walls", self.offers("load", "--"))

    def test_values_are_offered_where_they_are_known(self) -> None:
        self.assertEqual(self.offers("run", "dambreak2"), {"dambreak2d", "dambreak2d-interfacial", "dambreak2d-interfacial-square"})
        self.assertEqual(self.offers("status", "-o", ""), {"text", "json"})
        self.assertEqual(self.offers("status", "--output", "=", "j"), {"json"})
        self.assertEqual(self.offers("keys", "new", "ada", "--role", "o"), {"operator"})
        self.assertEqual(self.offers("keys", ""), {"new", "list", "remove"})
        self.assertEqual(self.offers("lease", ""), {"take", "renew", "release"})
        self.assertEqual(self.offers("query", ""), {"probes", "at", "box"})
        self.assertEqual(self.offers("render", "--colours", "c"), {"cividis", "coolwarm"})
        self.assertEqual(self.offers("wait", "--for", ""), {"state=", "time=", "step="})
        self.assertEqual(self.offers("wait", "--for", "state", "=", "R"), {"READY", "RUNNING", "RECOVERING"})
        self.assertIn("DONE", self.offers("wait", "--for", "state", "="))
        self.assertEqual(self.offers("set", "scheme.c"), {"scheme.cfl="})
        self.assertEqual(self.offers("load", "x", "--set", "grav"), {"gravity="})
        self.assertEqual(self.offers("run", "x", "--set", "res"), {"resolution="}, "which no run can be set to, and each case")
        self.assertEqual(self.offers("set", "res"), set())
        self.assertEqual(self.offers("load", "x", "--set", "domain.m"), {"domain.min=", "domain.max="})
        self.assertEqual(self.offers("set", "gravity", "=", ""), set())
        self.assertEqual(self.offers("get", "end_"), {"end_time"})
        self.assertEqual(self.offers("watch", "--timeout", ""), set())

    def test_files_directories_and_daemons_are_offered_where_they_are_meant(self) -> None:
        (self.home / "a directory").mkdir()
        (self.home / "dam.yaml").touch()
        (self.home / "meniscus" / "lab").mkdir(parents=True)
        (self.home / "meniscus" / "lab" / "control.ipc").touch()
        self.assertEqual(self.offers("load", "dam.y"), {"dam.yaml"})
        self.assertEqual(self.offers("log", "a"), {"a", "directory"})
        self.assertEqual(self.offers("log", "d"), set())
        self.assertEqual(self.offers("-d", "la"), {"lab"})

    def test_names_are_never_run(self) -> None:
        """They may be somebody else's, as of a directory in /tmp."""
        evil = "$(touch ran)"
        place, cases, program = self.home / "meniscus" / evil, self.home / "cases", self.home / "program"
        place.mkdir(mode=0o700, parents=True)
        cases.mkdir()
        (place / "control.ipc").touch()
        for name in (evil, "two words", "tank"):
            (cases / f"{name}.yaml").touch()
        program.write_text(f"#!/bin/sh\nprintf '%s\\n' '{evil}' '`touch ran`' tank '*'\n")
        program.chmod(0o755)
        self.environment["MENISCUS_CASES"] = str(cases)
        self.assertEqual(self.offers("-d", ""), set())
        self.assertEqual(self.meniscus("completion", "cases"), "tank\n")
        self.assertEqual(self.meniscus("completion", "daemons"), "")
        self.assertEqual(self.offers("-d", "ta", program=program), {"tank"})
        self.assertEqual(self.offers("-d", "$(t", program=program), {"$(touch", "ran)"})
        self.assertFalse((self.home / "ran").exists())

    def test_both_scripts_parse_and_name_every_command(self) -> None:
        commands = json.loads(self.meniscus("help", "-o", "json"))["commands"]
        for shell in ("bash", "zsh"):
            script = self.meniscus("completion", shell)
            self.assertEqual(script, json.loads(self.meniscus("completion", shell, "-o", "json"))["text"])
            for command in commands:
                self.assertRegex(script, rf"(?m)^ *{command['name']}\)$")
            if shutil.which(shell):
                subprocess.run([shell, "-n"], input=script, text=True, check=True, timeout=20)
        self.assertEqual(set(self.meniscus("completion", "cases").split()), {p.stem for p in CASES.glob("*.yaml")})
        self.meniscus("completion", "fish", code=2)

    def test_the_daemon_and_the_dashboard_are_completed_by_their_help(self) -> None:
        daemon, dashboard = BUILD / "meniscusd", BUILD / "meniscus-dashboard"
        (self.home / "kept").mkdir()
        for program, words, offered in (
            (daemon, ("--l",), {"--listen", "--load", "--log", "--log-level"}),
            (daemon, ("--load", "dambreak3"), {"dambreak3d"}),
            (daemon, ("--load", "=", "dambreak3"), {"dambreak3d"}),
            (daemon, ("--state-dir", "ke"), {"kept"}),
            (daemon, ("--set", "end_t"), {"end_time="}),
            (daemon, ("--set", "resol"), {"resolution="}),
            (daemon, ("--log-level", "w"), {"warning"}),
            (daemon, ("-o", ""), {"json"}),
            (daemon, ("--threads", ""), set()),
            (dashboard, ("--ht",), {"--http", "--http-plain", "--http-token"}),
            (dashboard, ("--http-token", "ke"), {"kept"}),
            (dashboard, ("-d", ""), set()),
        ):  # fmt: skip
            self.assertEqual(self.offers(*words, program=program), offered, words)

    def test_zsh_offers_states_behind_state(self) -> None:
        script = self.meniscus("completion", "zsh")
        offer = script[: script.index("# Of meniscusd")]
        self.assertRegex(offer, r"(?s)state=\)\n *if compset -P state=; then\n *_meniscus_offer @states\n *return\n")
        self.assertRegex(script, r"--for=\[[^\n]*_meniscus_offer state= time= step='")
        if shutil.which("zsh"):
            stand_in = 'compset() { [[ $PREFIX == $2* ]] && PREFIX=${PREFIX#$2}; }\n_call_program() { shift; "$@"; }\n' \
                       'compadd() { [[ $1 == -a ]] && print -l $found || print -- "${@: -1}"; }\n'
            for word, expected in (("state=R", {s for s in self.meniscus("completion", "states").split()}), ("", {"state=", "time=", "step="})):
                done = subprocess.run(
                    ["zsh", "-c", f"{stand_in}{offer}\nPREFIX='{word}'\n_meniscus_offer state= time= step="], capture_output=True,
                    env=self.environment | {"PATH": f"{BUILD}:{os.environ['PATH']}"}, text=True, timeout=20,
                )  # fmt: skip
                self.assertEqual(set(done.stdout.split()), expected, done.stderr)

    @unittest.skipUnless(shutil.which("zsh"), "needs zsh")
    def test_zsh_finishes_what_is_typed(self) -> None:
        finish_in_zsh(self, self.environment, self.home, ((b"meniscus run-u\t", b"ntil"), (b"\x15meniscus run sloshing2d-si\t", b"ngle"),
                                (b"\x15meniscus status -o js\t", b"on"), (b"\x15meniscus load x --set resol\t", b"resolution"), (b"\x15meniscus render --colours vir\t", b"idis"),
                                (b"\x15meniscusd --state\t", b"-dir"), (b"\x15meniscusd --load dambreak3\t", b"d "), (b"\x15meniscusd --load=sloshing2d-si\t", b"ngle"),
                                (b"\x15meniscus-dashboard --http-t\t", b"oken"), (b"\x15meniscusd --log-level w\t", b"arning")))  # fmt: skip

    def test_the_bash_script_is_clean(self) -> None:
        done = subprocess.run(["shellcheck", "-s", "bash", self.script], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout)


class WithDaemon(DaemonTest):
    def test_names_are_those_of_the_daemon(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("step", "3")
        checkpoints = {Path(self.ask("checkpoint")["path"]).name}
        self.assertEqual(checkpoints, {path.name for path in (self.home / "state" / "dambreak2d").glob("checkpoint-*")})
        with tempfile.NamedTemporaryFile("w", suffix=".bash") as script:
            script.write(self.meniscus("completion", "bash").stdout)
            script.flush()
            for words, offered in ((("query", "probes", "fro"), {"front"}), (("stream", "fields", "press"), {"pressure"}),
                                   (("query", "at", "press"), {"pressure"}), (("render", "--field", "vel"), {"velocity"}),
                                   (("restore", ""), checkpoints), (("-d", "default", "restore", "check"), checkpoints),
                                   (("--daemon", "=", "default", "query", "fro"), {"front"}),
                                   (("-d", "another", "restore", ""), set()), (("restore", "-d", "another", ""), set())):  # fmt: skip
                done = subprocess.run(["bash", "-c", SPLIT, "bash", script.name, BUILD / "meniscus", *words],
                                      env=self.environment, capture_output=True, text=True, timeout=60)
                self.assertEqual(set(done.stdout.split()), offered, (words, done.stderr))
        if shutil.which("zsh"):
            name = checkpoints.pop().encode()
            elsewhere = {"MENISCUS_DAEMON": "another"}
            finish_in_zsh(self, self.environment | elsewhere, self.home, ((b"meniscus -d default restore check\t", name[len("check"):]),))


if __name__ == "__main__":
    unittest.main()

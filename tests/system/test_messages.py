#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Messages say what happened, what is allowed and what to do, in words that the program at hand knows."""

import asyncio
import inspect
import json
import os
import socket
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, free_ports  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402

PORT = free_ports()
CASE = """
dimensions: 2
resolution: 16
domain: {min: [0, 0], max: [2, 1]}
gravity: [0, -1]
fluids: [{name: w, density: 1000, sound_speed: 20, shape: [{box: {min: [0, 0], max: [1, 0.5]}}]}]
walls: [{name: t, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}]
end_time: 0.1
"""


def is_loopback(host: str) -> bool:
    try:
        found = socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_STREAM)
    except OSError:
        return False
    return all(str(one[4][0]).startswith("127.") for one in found)


class Messages(DaemonTest):
    options = ["--tcp", str(PORT)]

    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]

    def said_by_both(self, endpoint: str, code: int, kind: "type[meniscus.MeniscusError]") -> str:
        theirs = self.meniscus("status", "--daemon", endpoint, code=code).stderr
        with self.assertRaises(kind) as caught:
            meniscus.Client(endpoint)
        return theirs + str(caught.exception)

    def test_this_machine_is_known_by_all_its_loopback_names(self) -> None:
        for host in ["127.1", "127.0.1", "localhost", "LOCALHOST", "localhost.", "[::ffff:127.0.0.1]", "[::ffff:7f00:1]", "0x7f000001"] + [socket.gethostname()] * is_loopback(socket.gethostname()):
            with self.subTest(host):
                endpoint = f"tcp://{host}:{PORT}"
                self.assertEqual(self.ask("status", "--daemon", endpoint)["state"], "EMPTY")
                with meniscus.Client(endpoint) as client:
                    self.assertEqual(client.status().state, "EMPTY")
        for host in "127.1.2.3", "127.255.255.254", "[::ffff:127.9.9.9]":  # all of 127.0.0.0/8, where no daemon is
            self.assertEqual(self.said_by_both(f"tcp://{host}:{PORT}", 69, meniscus.UnavailableError).count("nobody listens at tcp://127."), 2)
        for host in "ip6-localhost", "IP6-loopback":  # where --tcp is not: no key would help
            self.assertEqual(self.said_by_both(f"tcp://{host}:{PORT}", 69, meniscus.UnavailableError).count("nobody listens at tcp://[::1]:"), 2)

    def test_another_machine_takes_a_key_that_any_program_can_be_given(self) -> None:
        for host in "192.0.2.7", "127.example.org", "localhost.example.org", "[::ffff:192.0.2.7]", "[::7f00:1]", "127":
            text = self.said_by_both(f"tcp://{host}:{PORT}", 77, meniscus.DeniedError)
            self.assertEqual(text.count("is no loopback address, so it takes a key: "), 2)
            self.assertIn("set MENISCUS_KEY to its file", text)
            self.assertEqual(text.count("tcp://127.0.0.1:PORT"), 2)

    def test_what_stands_for_all_addresses_is_no_address_of_a_daemon(self) -> None:
        for host in "0.0.0.0", "0", "0x0", "00.0", "*", "[::]", "[::0]", "[::ffff:0.0.0.0]":
            text = self.said_by_both(f"tcp://{host}:{PORT}", 2, meniscus.RefusedError)
            self.assertEqual(text.count(f'"tcp://{host}:{PORT}" stands for all addresses of a machine, where a daemon may listen'), 2)
            self.assertEqual(text.count(f"write tcp://127.0.0.1:{PORT} for this machine, or the name or address of another"), 2)
        for wrong in "tcp://a:0", "tcp://a:65534", "tcp://a", "tcp://:5", "tcp://a b:5", "tcp://[x]:5":
            text = self.said_by_both(wrong, 2, meniscus.RefusedError)
            self.assertEqual(text.count("is not an endpoint; allowed is tcp://HOST:PORT with 1 <= PORT <= 65533"), 2)

    def test_a_point_is_one_word(self) -> None:
        self.meniscus("load", "dambreak2d", "--set", "resolution=10")
        said = self.meniscus("query", "at", "pressure", "1", "0.5", code=2).stderr
        self.assertIn('"1" is one number, and a point has two or three: write them as one word with commas between, as in 1,0.5', said)
        said = self.meniscus("query", "at", "pressure", "1,0.5", "1,0.5,0", code=2).stderr
        self.assertIn('"1,0.5,0" has 3 coordinates, and "1,0.5" has 2', said)

    def test_half_of_a_surrogate_pair_is_complained_of_and_a_whole_one_is_a_character(self) -> None:
        with meniscus.Client(f"tcp://127.0.0.1:{PORT}", timeout=50) as client:
            for pair in ({"title": '"\ud83d\ude00"'}, {"title": "\ud83d\ude00"}):
                client.load("dambreak2d", {"resolution": 10, **pair})
                self.assertEqual(client.status().title, "\U0001f600")
            for half in (lambda: client.load({"title": "a\ud83d"}), lambda: client.load("dambreak2d", {"title": "\ud83d"}),
                         lambda: client.load("dambreak2d", name="\ud83d"), lambda: client.query("\ud83d"),
                         lambda: client.set({"gravity": ["\ud83d"]})):
                with self.assertRaisesRegex(meniscus.MeniscusError, "half of a surrogate pair is no character.*write the character itself") as caught:
                    half()
                self.assertEqual(caught.exception.code, "INVALID_ARGUMENT")

    def test_no_text_that_cannot_be_sent_ends_in_an_exception_of_python(self) -> None:
        """All public methods that take text, by their signatures: whichever argument has half of a surrogate pair is named."""
        known = {"what": "fields", "names": "pressure", "field": "pressure", "case": "dambreak2d", "assignments": {}, "points": [[0, 0]], "time": 1,
                 "version": 1, "name": "a", "seconds": 3, "request_id": "0" * 32}  # fmt: skip
        texts = {"case": ("\ud800", Path("\ud800"), "a\0b"), "assignments": ({"\udc80": 1}, {"end_time": "\udc80"}, {"gravity": ["\udc80"]}),
                 "overrides": ({"\udc80": 1},), "states": ("\udc80", ["\udc80"]), "fields": ("\udc80", ["\udc80"]), "since": (meniscus.Cursor(file="\udc80"),),
                 "exact": ("\udc80", {"\udc80": 1}, {"pressure": "\udc80"})}  # fmt: skip
        told = set()
        with meniscus.Client(f"tcp://127.0.0.1:{PORT}", timeout=50) as client:
            client.load("dambreak2d", {"resolution": 10})
            for kind in (meniscus.Client, meniscus.Simulation):
                for method, function in inspect.getmembers(kind, inspect.isfunction):
                    if method.startswith("_"):
                        continue
                    arguments = list(inspect.signature(function).parameters.values())[1:]
                    for argument in arguments:
                        is_text = "str" in str(argument.annotation) or argument.name in texts
                        for text in texts.get(argument.name, ("a\udc80", "\ud83d")) if is_text else ():
                            given = {a.name: known[a.name] for a in arguments if a.name in known and a.kind != a.VAR_POSITIONAL} | {argument.name: text}
                            positional = given.pop(argument.name) if argument.kind == argument.VAR_POSITIONAL else None
                            first = [given.pop("what")] if positional and "what" in given else []
                            with self.subTest(method=method, argument=argument.name, text=ascii(text)), self.assertRaises(meniscus.MeniscusError) as caught:
                                done = function(client, *first, *([positional] if positional else []), **given)
                                if hasattr(done, "__enter__"):
                                    done.__enter__()
                            self.assertIn(argument.name, str(caught.exception))
                            self.assertEqual(caught.exception.path, argument.name)
                            told.add((method, argument.name))
            self.assertEqual(client.status().breakpoints, ())
        self.assertLessEqual({("lease", "holder"), ("stream", "names"), ("stream", "since"), ("stream", "pack"), ("subscribe", "topics"), ("get", "paths"),
                              ("query", "probes"), ("load", "name"), ("load", "overrides"), ("breakpoint", "condition"), ("restore", "checkpoint"),
                              ("points", "field"), ("particles", "fields"), ("snapshot", "fields"), ("set", "assignments"), ("cancel", "request_id"),
                              ("wait", "states")}, told)  # fmt: skip

    def test_nor_does_a_name_or_a_path_that_there_cannot_be(self) -> None:
        for words in ({"daemon": "\udc80"}, {"daemon": "a\0b"}, {"daemon": "ipc://\ud800"}, {"daemon": "tcp://\udc80:5"}, {"key": "\ud800"}, {"key": "a\0b"},
                      {"server_key": "\udc80"}, {"server_key": "a\0b"}):  # fmt: skip
            with self.subTest(words):
                given = {"daemon": f"tcp://127.0.0.1:{PORT}", **words}
                with self.assertRaises(meniscus.RefusedError) as caught:
                    meniscus.Client(**given)
                self.assertEqual(caught.exception.path, *words)
                with self.assertRaises(meniscus.RefusedError):
                    asyncio.run(meniscus.AsyncClient(**given).connect())
        for wrong in "\ud800", "a\0b":
            for kind in (meniscus.Snapshot, meniscus.Snapshots, meniscus.ProbeSeries):
                with self.assertRaises(meniscus.RefusedError):
                    kind(wrong)
        os.environ["MENISCUS_DAEMON"] = "\udc80"
        self.addCleanup(os.environ.pop, "MENISCUS_DAEMON")
        with self.assertRaisesRegex(meniscus.RefusedError, "daemon"):
            meniscus.Client()

    def test_a_title_gives_no_orders_to_a_terminal(self) -> None:
        """It comes from a file that somebody else may have written, and is shown to who looks at the run."""
        self.meniscus("load", "dambreak2d", "--set", "resolution=10", "--set", 'title="dam\\nstate FAULT \\u202egpj.exe\\u200b"')
        shown = "dam\\nstate FAULT \\u202egpj.exe\\u200b"
        lines = self.meniscus("status").stdout.splitlines()
        self.assertIn(f"case        dambreak2d: {shown}", lines)
        self.assertEqual([line for line in lines if line.startswith("state ")][0], "state       READY")
        self.assertFalse([line for line in lines if line.startswith("state FAULT")])
        for words in (["status"], ["get", "title"]):
            printed = self.meniscus(*words, "-o", "json").stdout
            self.assertTrue(printed.isprintable() or printed[:-1].isprintable(), ascii(printed))
            self.assertIn(shown, printed.replace("\\\\", "\\"))
        self.assertEqual(self.ask("status")["title"], "dam\nstate FAULT \u202egpj.exe\u200b")
        self.meniscus("set", "end_time=7")
        self.assertTrue(self.meniscus("log", self.ask("status")["run_directory"]).stdout.replace("\n", "").isprintable())

    def test_the_log_has_one_line_for_each_event(self) -> None:
        """What a formula has in its comments is no event, and turns no text round."""
        self.meniscus("load", "dambreak2d", "--set", "resolution=10")
        self.meniscus("set", "gravity=[0,\n# step 0 t 0 fault: the disk is full \u202e\n -2]")
        log = (Path(self.ask("status")["run_directory"]) / "log").read_text()
        self.assertEqual([line.split(" ")[5] for line in log.splitlines()], ["ready:", "set:"])
        self.assertIn("[0,\\n# step 0 t 0 fault: the disk is full \\u202e\\n -2]", log)

    def test_names_have_no_zero_bytes_and_nothing_hidden(self) -> None:
        with meniscus.Client(f"tcp://127.0.0.1:{PORT}", timeout=50) as client:
            client.load("dambreak2d", {"resolution": 10})
            for hidden in "\u202e", "\u200b", "\ufeff", "\u2028", "\n", "\u180b", "\u180f", "\ufe0f", "\U000e0100", "\U000e01ef", "\u034f":
                for name in (lambda: client.breakpoint(f"a{hidden}b", step=3), lambda: client.lease(3, f"a{hidden}b").__enter__(),
                             lambda: client.load("dambreak2d", name=f"a{hidden}b")):
                    with self.subTest(hidden), self.assertRaisesRegex(meniscus.RefusedError, "hidden ones|allowed: "):
                        name()
            for zero in (lambda: client.load("dambreak2d", name="a\0b"), lambda: client.get("end_time\0.x"), lambda: client.set({"end_time\0": 3}),
                         lambda: client.breakpoint("a\0b", step=3), lambda: client.query("front\0"), lambda: client.restore("x\0"),
                         lambda: client.lease(3, "a\0").__enter__(), lambda: client.stream("probes", "front\0")):
                with self.assertRaisesRegex(meniscus.RefusedError, r"a zero byte \(U\+0000\) in it: remove it"):
                    zero()
            self.assertEqual(client.status().breakpoints, ())

    def test_names_are_no_options(self) -> None:
        with meniscus.Client(f"tcp://127.0.0.1:{PORT}", timeout=50) as client:
            client.load("dambreak2d", {"resolution": 10})
            for name in (lambda: client.breakpoint("-rf", step=3), lambda: client.lease(3, "--holder").__enter__(),
                         lambda: client.load("dambreak2d", name="-n")):
                with self.assertRaisesRegex(meniscus.RefusedError, "dash|none of '.' and '-'"):
                    name()
            self.assertEqual((client.status().breakpoints, client.status().lease_holder), ((), None))

    def test_what_programs_print_gives_no_orders_to_a_terminal(self) -> None:
        """Names of files, words of the command line and names of hosts, in messages of ours and of libraries."""
        bad = "a\x1b[31mb\u202ec\x9b"
        run = ["run", "dambreak2d", "--set", "resolution=6", "--set", "end_time=0.001", "--set", "threads=1", "--out", bad]
        dashboard = BUILD / "meniscus-dashboard"
        for words in (run, run, ["replay", bad, "--verify"], ["log", bad], ["init", bad], ["init", bad], [bad], ["--" + bad], ["run", bad + ".yaml"],
                      ["check", bad + ".yaml"], ["render", bad + ".hdf", "--out", "x.png"], ["render", bad], ["export", bad + "/probes.hdf"],
                      ["ls", "--" + bad], ["status", "--daemon", bad], ["keys", "list", "--keys", bad], ["doctor", "--state-dir", bad]):
            self.assert_harmless([BUILD / "meniscus", *words])
        for words in ([bad], ["--" + bad], ["--http", bad], ["--load", bad, "--state-dir", bad], ["--log-level", bad], ["--quota", bad], ["-n", bad]):
            self.assert_harmless([BUILD / "meniscusd", *words])
        for words in ([["--" + bad], ["-d", bad, "--http", bad], [bad]] if dashboard.exists() else []):
            self.assert_harmless([dashboard, *words])
        self.assertIn("a\\u001b[31mb\\u202ec\\u009b", self.assert_harmless([BUILD / "meniscusd", bad]))

    def assert_harmless(self, words: "list[Any]") -> str:
        """All that a program prints, which ends by itself."""
        done = subprocess.run(words, env=self.environment, capture_output=True, timeout=60, cwd=self.home, check=False)
        said = (done.stdout + done.stderr).decode()
        self.assertTrue(said.replace("\n", "").replace("\t", "").isprintable(), f"{words}: {said!a}")
        return said

    def test_a_case_is_copied_as_it_is(self) -> None:
        case = self.home / "odd.yaml"
        case.write_text(CASE + "# \u202e \u200b\n")
        self.assertEqual(self.meniscus("init", "-", "--from", str(case)).stdout, case.read_text())

    def test_names_that_mean_something_else_are_refused_with_what_is_reserved(self) -> None:
        case = self.home / "names.yaml"
        case.write_text(CASE)
        reserved = "choose another name. Reserved are "
        probe, constant, refused = "{name: %s, mass: {}}", "{name: %s, value: 1}", "neither a dot nor a dash"
        for entry, item, names, why in (
            ("probes", probe, ("time", "step"), reserved), ("probes", probe, ("-p", "--help", ".p"), refused),
            ("walls", "{name: %s, shape: [{box: {min: [0, 0], max: [1, 1]}}]}", ("-w",), refused),
            ("constants", constant, ("sin", "pi", "step", "dx", "t", "_ENV", "_G", "and", "nil"), reserved),
        ):
            for name in names:
                with self.subTest(name):
                    setting = f"{entry}=[{item % name}]"
                    error = self.ask("load", str(case), "--set", setting, code=65)["error"]
                    self.assertEqual(error["path"], f"{entry}[0].name")
                    self.assertIn(why, error["message"])
                    self.assertTrue(error["message"].startswith("--set "), error["message"])
                    self.meniscus("run", str(case), "--out", str(self.home / "out"), "--set", setting, code=65)
        for name in "_a", "a1", "sinus", "steps", "ENV":
            self.meniscus("load", str(case), "--set", f"constants=[{constant % name}]", "--set", f"gravity=[0, -{name}]")
        self.meniscus("load", str(case), "--set", "probes=[%s, %s]" % (probe % "time-2", probe % "t"))
        self.assertIn("begin with a dot or a dash", self.meniscus("keys", "new", "--role", "viewer", "--keys", str(self.home / "keys"), "--", "-k", code=2).stderr)

    def test_a_checkpoint_that_there_is_not_is_said_with_those_that_there_are(self) -> None:
        directory = self.ask("load", "dambreak2d", "--set", "resolution=6", "--set", "threads=1", "--set", "output.checkpoints_kept=9")["message"]
        for words in (["restore"], ["restore", "nope"]):
            said = self.meniscus(*words, code=1).stderr
            self.assertRegex(said, rf"there is no checkpoint .*in '{directory}'.*; `meniscus checkpoint` writes one, `meniscus reset` begins anew\n")
        for _ in range(6):
            self.meniscus("step", "5")
            self.meniscus("checkpoint")
        for name in ("nope", "30", "checkpoint-0000000007.hdf"):
            told = self.ask("restore", name, code=1)["error"]
            newest = ", ".join(f"checkpoint-00000000{step}.hdf" for step in (30, 25, 20, 15))
            self.assertEqual(told["message"], f'there is no checkpoint "{name}" in \'{directory}\', which has {newest} and 2 older ones; '
                                              "name one of them, or none for the newest")  # fmt: skip
            self.assertEqual((told["status"], told["path"]), ("not found", "checkpoint"))
        self.assertEqual(self.ask("status")["step"], 30)
        self.meniscus("stop")

    def test_hints_of_a_run_without_a_daemon_name_no_command_of_one(self) -> None:
        """What they advise works: the same command again, with --resume auto."""
        out = str(self.home / "hints")
        slow = ["--set", "resolution=6", "--set", "output.probe_interval=1e-5", "--set", "end_time=12", "--set", "output.checkpoint_interval=0.5"]
        limited = f'ulimit -f 100; exec {BUILD}/meniscus "$@"'
        for words, code in ((["run", "dambreak2d", *slow, "--out", out], 74), (["run", "dambreak2d", "--out", "/proc/x"], 74),
                            (["run", "dambreak2d", "--set", "resolution=5", "--set", "limits.density_max=1.00001", "--out", f"{out}2"], 70),
                            (["log", "/nothing"], 74), (["replay", "/nothing", "--verify"], 74), (["check", "nothing"], 65)):  # fmt: skip
            with self.subTest(words=words):
                done = subprocess.run(["bash", "-c", limited, "bash", *words, "-o", "json"], env=self.environment, capture_output=True, text=True, timeout=120)
                error = json.loads(done.stdout)["error"]
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertNotRegex(error["hint"] + done.stderr, "`?meniscus (resume|status|wait|restore|load|capabilities)|restore a checkpoint|load the case")
        self.meniscus("run", "dambreak2d", *slow, "--out", out, "--resume", "auto")

    def test_faults_advise_what_can_help(self) -> None:
        case = self.home / "case.yaml"
        case.write_text(CASE)
        for setting, advice, useless in (
            ("limits.density_max=1.00001", "try wider limits.density_min and density_max", "finer resolution"),
            ("limits.time_step_floor=0.99", "then mend that, or lower limits.time_step_floor", "finer resolution"),
        ):
            with self.subTest(setting):
                done = subprocess.run([BUILD / "meniscus", "run", case, "--out", self.home / "out", "-o", "json", "--set", "gravity=[0, -30*t]",
                                       "--set", setting], env=self.environment, capture_output=True, text=True, timeout=60)
                error = json.loads(done.stdout)["error"]
                self.assertEqual(error["status"], "diverged", done.stderr)
                self.assertIn(advice, error["message"])
                self.assertNotIn(useless, error["message"] + error["hint"])


if __name__ == "__main__":
    unittest.main()

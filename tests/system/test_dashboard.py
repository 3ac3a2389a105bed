#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make check CI=1
"""The dashboard: whom its gateway lets in, what it does with browsers that misbehave, and a person who clicks in real ones."""

import contextlib
import http.client
import json
import os
import re
import resource
import socket
import struct
import subprocess
import sys
import time
import unittest
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from browser import BINARY, TEXT, Browser  # noqa: E402
from daemon import BUILD, ROOT, SMALL, DaemonTest, free_ports, of_nightly  # noqa: E402


class DashboardTest(DaemonTest):
    gateway: "subprocess.Popen[bytes]"
    port: int

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.gateway, cls.port = cls.start_gateway("gateway", "--no-token")

    @classmethod
    def start_gateway(cls, name: str, *options: str) -> "tuple[subprocess.Popen[bytes], int]":
        log = cls.home / f"{name}.log"
        with open(log, "wb") as file:
            gateway = subprocess.Popen([BUILD / "meniscus-dashboard", "--http", "0", *options], env=cls.environment, stderr=file)

        def end() -> None:
            gateway.terminate()
            assert gateway.wait(timeout=60) == 0, log.read_text()

        cls.addClassCleanup(end)
        until = time.monotonic() + 20
        while time.monotonic() < until:
            found = re.search(r"is at http://[\w.-]+:(\d+)/", log.read_text())
            if found:
                return gateway, int(found[1])
            time.sleep(0.02)
        raise AssertionError(f"no port in the log: {log.read_text()}")

    def browser(self, greet: bool = True, port: int = 0, **how: Any) -> Browser:
        browser = Browser(port or self.port, **how)
        self.addCleanup(browser.socket.close)
        if greet:
            self.assertEqual(browser.status, 101)
            browser.say(do="hello")
            browser.until("hello")
        return browser

    def still_serves(self) -> None:
        with self.browser() as other:
            other.until("status")

    def memory_kib(self) -> int:
        return int(re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{self.gateway.pid}/status").read_text())[1])  # type: ignore[index]


class Strangers(DashboardTest):
    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        (cls.home / "token-of-two").write_text("0123456789abcdef\n")
        (cls.home / "token-of-two").chmod(0o600)

    def fetch(self, path: str, method: str = "GET", **headers: str) -> "tuple[int, http.client.HTTPMessage, bytes]":
        with contextlib.closing(http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)) as connection:
            connection.request(method, path, headers=headers)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()

    def test_the_page_is_served_whole_and_runs_nothing_but_its_own(self) -> None:
        for path, kind in {"/": "text/html", "/app.js": "text/javascript", "/app.css": "text/css", "/icon.svg": "image/svg+xml"}.items():
            code, headers, body = self.fetch(path)
            self.assertEqual((code, len(body)), (200, int(headers["Content-Length"])), path)
            self.assertTrue(headers["Content-Type"].startswith(kind))
            self.assertIn("script-src 'self';", headers["Content-Security-Policy"])
            self.assertNotIn("unsafe", headers["Content-Security-Policy"])
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")

    def test_one_that_may_write_no_file_serves(self) -> None:
        """`ulimit -f 0`, and what it says goes to a file."""
        port = free_ports()
        words = ["bash", "-c", 'ulimit -f 0; exec "$@"', "bash", BUILD / "meniscus-dashboard", "--http", str(port), "--no-token"]
        with open(self.home / "limited.log", "wb") as log, subprocess.Popen(words, env=self.environment, stderr=log) as gateway:
            def serves() -> bool:
                self.assertIsNone(gateway.poll())
                with contextlib.suppress(ConnectionError), contextlib.closing(http.client.HTTPConnection("127.0.0.1", port)) as way:
                    way.request("GET", "/")
                    return way.getresponse().status == 200
                return False

            self.wait_until(serves)
            gateway.terminate()
            self.assertEqual(gateway.wait(60), 0)

    def test_nothing_else_is_served(self) -> None:
        for path in ("/index.html", "/../etc/passwd", "/%2e%2e/etc/passwd", "//etc/passwd", "/app.js/"):
            self.assertIn(self.fetch(path)[0], (403, 404), path)
        self.assertEqual(self.fetch("/", Host="evil.example")[0], 403)

    def test_pages_of_other_sites_open_no_socket(self) -> None:
        for how in ({"origin": None}, {"origin": "null"}, {"origin": "http://evil.example"}, {"origin": "http://localhost:1"},
                    {"host": "evil.example", "origin": "same"}):
            self.assertNotEqual(self.browser(greet=False, **how).status, 101, how)
        self.assertEqual(self.browser(greet=False, host="localhost:8080").status, 101)

    def test_who_does_not_greet_is_shown_out(self) -> None:
        browser = self.browser(greet=False)
        browser.say(do="start", id=1)
        self.assertEqual(browser.closed(), (1008, b"hello"))

    def test_with_a_token_only_who_knows_it_sees_anything(self) -> None:
        token = self.home / "token"
        token.write_text("0123456789abcdef\n")
        token.chmod(0o600)
        _, port = self.start_gateway("token", "--http-token", str(token))
        for words in ({}, {"token": ""}, {"token": "0123456789abcdee"}, {"token": "0123456789abcdef0"}):
            browser = self.browser(greet=False, port=port)
            browser.say(do="hello", **words)
            self.assertEqual(browser.closed(), (1008, b"token"), words)
        browser = self.browser(greet=False, port=port)
        browser.say(do="hello", token="0123456789abcdef")
        browser.until("status")

    def test_who_was_not_told_the_address_is_kept_out_by_default(self) -> None:
        tokens = set()
        for name in ("one", "two"):
            _, port = self.start_gateway(name)
            found = re.search(r"is at (http://127\.0\.0\.1:(\d+)/#token=([0-9a-f]{32}))\n", (self.home / f"{name}.log").read_text())
            assert found, "no address to open"
            self.assertEqual(int(found[2]), port)
            tokens.add(found[3])
            stranger = self.browser(greet=False, port=port)
            stranger.say(do="hello")
            self.assertEqual(stranger.closed(), (1008, b"token"))
            browser = self.browser(greet=False, port=port)
            browser.say(do="hello", token=found[3])
            browser.until("status")
        self.assertEqual(len(tokens), 2)

    def test_a_token_of_a_file_is_not_printed(self) -> None:
        token = self.home / "secret"
        token.write_text("fedcba9876543210\n")
        token.chmod(0o600)
        self.start_gateway("secret", "--http-token", str(token))
        self.assertNotIn("fedcba", (self.home / "secret.log").read_text())

    def test_other_machines_are_served_for_a_token_and_a_word_of_consent_only(self) -> None:
        _, port = self.start_gateway("everywhere", "--http", "0.0.0.0:0", "--http-plain")
        self.assertIn(f" is at http://{socket.gethostname()}:{port}/#token=", (self.home / "everywhere.log").read_text(), "an address to open")
        stranger = self.browser(greet=False, port=port)
        stranger.say(do="hello")
        self.assertEqual(stranger.closed(), (1008, b"token"))
        for options, words in ((("--http", "0.0.0.0:0", "--no-token"), "without --no-token"),
                               (("--http", "0.0.0.0:0", "--no-token", "--http-plain"), "without --no-token"),
                               (("--http", "0.0.0.0:0"), "not encrypted"),
                               (("--http-token", str(self.home / "token-of-two"), "--no-token"), "exclude each other"), (("--http", "x"), "takes a port"), (("--frames", "0"), "--frames takes"),
                               (("sloshing2d",), "no use"), (("--nonsense",), "--help")):
            done = subprocess.run([BUILD / "meniscus-dashboard", *options], env=self.environment, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(words, done.stderr)

    def test_a_port_that_is_taken_is_one_plain_sentence(self) -> None:
        done = subprocess.run([BUILD / "meniscus-dashboard", "--http", str(self.port)], env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertRegex(done.stderr, rf"\A.*cannot listen at 127\.0\.0\.1 port {self.port}, which another program has, [^\n]*\n\Z")

    def test_what_cannot_begin_ends_with_a_failure(self) -> None:
        """The limit on threads does not hold for root, who becomes somebody else, and so may not find the program by its path."""
        def no_thread() -> None:
            if os.getuid() == 0:
                os.setuid(34567)
            resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))

        with open(BUILD / "meniscus-dashboard", "rb") as program:
            done = subprocess.run(["meniscus-dashboard", "--http", "0"], executable=f"/proc/self/fd/{program.fileno()}",
                                  pass_fds=[program.fileno()], env=self.environment, capture_output=True, text=True, timeout=20,
                                  preexec_fn=no_thread)  # fmt: skip
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stderr, "meniscus-dashboard: the system gives no thread\n")


class Misbehaviour(DashboardTest):
    """What one browser does costs the others nothing."""

    def test_what_cannot_be_understood_is_answered_and_nothing_else(self) -> None:
        browser = self.browser()
        for words, path in ((b"{", ""), (b"[1]", "do"), (b'{"do":"shutdown"}', "do"), (b'{"do":"step","id":3,"count":-1}', "count")):
            browser.frame(words)
            error = browser.until("reply")["error"]
            self.assertEqual((error["status"], error["path"]), ("invalid", path))
        self.assertEqual(browser.ask(do="load", id=4, name="../../etc/passwd")["error"]["path"], "name")

    def test_bad_frames_cost_their_sender_the_connection(self) -> None:
        for send, codes in (
            (lambda b: b.frame(b'{"do":"history"}', kind=BINARY), (1003,)),
            (lambda b: b.frame(b"x" * (65 << 10)), (1009,)),
            (lambda b: [b.frame(b"x" * 9000, kind=TEXT if k == 0 else 0, last=False) for k in range(9)], (1009, 1006)),
            (lambda b: b.frame(b"\xff\xfe"), (1007, 1006)),
            (lambda b: b.frame(b"", kind=11), (1002, 1006)),
            (lambda b: b.socket.sendall(os.urandom(5000)), (1002, 1006, 1005, 1009)),
        ):
            browser = self.browser()
            with contextlib.suppress(ConnectionError):
                send(browser)
            self.assertIn(browser.closed()[0], codes)
            self.still_serves()

    def test_who_is_in_the_midst_of_a_picture_learns_why_all_the_same(self) -> None:
        self.meniscus("load", *SMALL, "--set", "resolution=200")
        browser = self.browser(receive=4096)
        for _ in range(20):  # several times what the system takes of one connection
            browser.say(do="show", field="velocity", limit=100000)
            time.sleep(0.1)
            browser.say(do="drawn", count=1)
        browser.frame(b'{"do":"history"}', kind=BINARY)
        time.sleep(0.5)
        self.assertEqual(browser.closed(), (1003, b"text only"))

    def test_a_message_may_come_in_pieces(self) -> None:
        browser = self.browser()
        browser.history()
        browser.frame(b'{"do":"hi', last=False)
        browser.frame(b"sto", kind=0, last=False)
        browser.frame(b'ry"}', kind=0)
        browser.history()

    def test_who_does_not_read_or_draw_gets_little_and_others_all(self) -> None:
        self.meniscus("load", *SMALL, "--set", "end_time=1000", "--set", "output.probe_interval=1e-6")
        silent = [self.browser() for _ in range(8)]
        for browser in silent:
            browser.say(do="show", field="velocity", limit=100000)
        quick = self.browser()
        quick.say(do="show", field="velocity", limit=100000)
        self.meniscus("start")
        before, steps = self.memory_kib(), set()
        until = time.monotonic() + 5
        while time.monotonic() < until:
            steps.add(quick.picture()["step"])
            quick.say(do="drawn", count=1)
        self.assertGreater(len(steps), 20)
        self.assertLess(self.memory_kib() - before, 100 << 10)
        # It has had two, and then the newest one, with how many gave way.
        late = silent[0]
        first = [late.picture() for _ in range(2)]
        late.say(do="drawn", count=2)
        newest = late.picture()
        self.assertGreater(newest["step"], first[1]["step"] + 20)
        self.assertGreater(newest["skipped"], 10)

    def test_browsers_that_vanish_are_forgotten(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("start")
        for _ in range(40):
            browser = self.browser()
            browser.say(do="show", field="pressure", limit=100000)
            browser.picture()
            browser.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            browser.socket.close()
        self.still_serves()

    def test_one_browser_more_than_there_may_be_is_turned_away(self) -> None:
        here = [self.browser() for _ in range(32)]
        self.assertNotEqual(self.browser(greet=False).closed()[0], 0)
        here[0].socket.close()
        until = time.monotonic() + 10
        while time.monotonic() < until:
            late = self.browser(greet=False)
            with contextlib.suppress(EOFError, ConnectionError):
                late.say(do="hello")
                late.until("hello")
                return
        self.fail("nobody is let in when there is room again")

    def test_those_who_say_nothing_keep_nobody_out(self) -> None:
        greeted = self.browser()
        silent = [self.browser(greet=False) for _ in range(70)]
        late = self.browser()
        self.assertEqual(silent[0].socket.recv(1), b"")
        silent[-1].say(do="hello")
        silent[-1].until("hello")
        for browser in (greeted, late):
            browser.say(do="history")
            browser.until("history")


class Steering(DashboardTest):
    def test_commands_take_effect_and_all_see_it(self) -> None:
        one, two = self.browser(), self.browser()
        self.assertEqual(one.ask(do="load", id=1, name="dambreak2d", settings=["resolution=20"])["state"], "READY")
        two.until("event", state="READY", what="ready")
        about = two.until("about")
        while "case" not in about:
            about = two.until("about")
        self.assertEqual([fluid["name"] for fluid in about["fluids"]], ["water", "air"])
        self.assertEqual(about["fluids"][0]["colour"], "#1f78b4")
        self.assertEqual(one.ask(do="step", id=2, count=10)["step"], 10)
        self.assertEqual(one.ask(do="set", id=3, settings=["end_time=3", "gravity=[0, -2]"])["effect_step"], 10)
        self.assertEqual(float(self.ask("get", "end_time")["values"]["end_time"]["value"]), 3)
        error = two.ask(do="set", id=4, settings=["end_time=never"])["error"]
        self.assertEqual((error["status"], error["path"]), ("invalid", "end_time"))
        error = two.ask(do="start", id=5)["error"]
        self.assertIn("possible in READY", error["message"])
        self.assertIn("meniscus status", error["hint"])
        self.assertRegex(two.ask(do="checkpoint", id=6)["path"], r"checkpoint-\d+\.hdf$")
        records = two.ask(do="journal", id=7)["records"]
        self.assertEqual([r["command"] for r in records if r["kind"] == "command"][:3], ["load", "step", "set"])
        self.assertNotIn("hash", [r["kind"] for r in records])
        self.assertEqual([r["arguments"] for r in records if r["kind"] == "command"][:3], ["dambreak2d", "10", None])
        journal = Path(self.ask("status")["run_directory"]) / "journal"
        before = journal.stat().st_size
        self.meniscus("snapshot")  # of which there is no event
        self.assertGreater(journal.stat().st_size, before)
        two.until("status", journal_bytes=journal.stat().st_size)

    def test_what_is_scheduled_is_listed_and_done_or_called_off(self) -> None:
        self.meniscus("load", *SMALL)
        one, two = self.browser(), self.browser()
        self.assertIn("scheduled: pause", one.ask(do="pause", id=1, at_time=5)["message"])
        self.assertIn("scheduled: set", one.ask(do="set", id=2, settings=["gravity=[0, -2]"], at_step=7)["message"])
        listed = two.until("status")["scheduled"]
        while len(listed) < 2:
            listed = two.until("status")["scheduled"]
        self.assertEqual([(s["at_step"], s["at_time"]) for s in listed], [(None, 5), (7, None)])
        self.assertIsNone(two.ask(do="cancel", id=3, request=listed[0]["id"]).get("error"))
        self.assertEqual(two.ask(do="cancel", id=4, request="7")["error"]["status"], "invalid")
        error = one.ask(do="snapshot", id=5, at_step=1, at_time=1)["error"]
        self.assertIn("at_step or at_time", error["message"])
        self.assertIn("no use for", one.ask(do="start", id=6, at_step=3)["error"]["message"])
        one.ask(do="step", id=7, count=10)
        self.assertEqual(self.ask("get", "gravity")["values"]["gravity"]["value"], "[0, -2]")
        self.assertEqual(self.ask("status")["scheduled"], [])

    def test_a_long_command_does_not_keep_others_waiting(self) -> None:
        self.meniscus("load", *SMALL, "--set", "end_time=1000")
        browser = self.browser()
        browser.say(do="run_until", id=1, time=900)
        self.meniscus("wait", "--for", "state=RUNNING", "--timeout", "60")
        began = time.monotonic()
        self.assertEqual(browser.ask(do="pause", id=2)["state"], "PAUSED")
        self.assertLess(time.monotonic() - began, 30)

    def test_what_is_ended_on_request_tells_how_far_it_has_come(self) -> None:
        self.meniscus("load", *SMALL, "--set", "end_time=1000")
        browser = self.browser()
        for words in ({"do": "step", "count": 99999999999}, {"do": "run_until", "time": 900}):
            browser.say(id=1, **words)
            self.meniscus("wait", "--for", "state=RUNNING", "--timeout", "60")
            self.meniscus("pause")
            reply = browser.until("reply", id=1)
            self.assertEqual((reply["error"]["status"], reply["error"]["message"], reply["state"]), ("interrupted", "paused on request", "PAUSED"))
            now = self.ask("status")
            self.assertEqual((reply["step"], reply["time"]), (now["step"], now["time"]))

    def test_a_lease_is_honoured(self) -> None:
        self.meniscus("load", *SMALL)
        one, two = self.browser(), self.browser()
        epoch = one.ask(do="lease", id=1, seconds=20, holder="anna")["lease_epoch"]
        self.assertEqual(two.until("status", lease_holder="anna")["lease_holder"], "anna")
        error = two.ask(do="step", id=2, count=1)["error"]
        self.assertEqual(error["status"], "held")
        self.assertIn("anna", error["message"])
        self.assertEqual(one.ask(do="step", id=3, count=1, lease=epoch)["state"], "PAUSED")
        one.ask(do="release", id=4, lease=epoch)
        self.assertEqual(two.ask(do="step", id=5, count=1)["state"], "PAUSED")

    def test_a_late_comer_has_the_past_and_pictures_are_thinned_as_wished(self) -> None:
        self.meniscus("load", *SMALL, "--set", "output.probe_interval=1e-6")
        first = self.browser()
        first.until("about")
        self.meniscus("step", "30")
        first.until("samples")
        time.sleep(0.3)
        late = self.browser()
        probes = late.history()
        self.assertGreaterEqual(len(probes["P05"]["t"]), 30)
        self.assertEqual(probes["P05"]["unit"], "Pa")
        late.say(do="show", field="pressure", limit=1000)
        few = late.picture()
        self.assertEqual((few["step"], few["all"], few["every"], few["unit"]), (30, 4280, 4, "Pa"))
        self.assertTrue(900 < few["particles"] < 1250, few)
        late.say(do="show", field="phase", limit=100000, walls=True)
        late.say(do="drawn", count=1)
        many = late.picture()
        self.assertEqual((many["particles"], many["every"]), (self.ask("status")["particles"], 1))

    def test_a_gateway_that_comes_late_has_the_past_from_the_beginning(self) -> None:
        self.meniscus("load", *SMALL, "--set", "output.probe_interval=1e-6")
        self.meniscus("step", "30")
        _, port = self.start_gateway("late", "--no-token")
        browser = self.browser(port=port)
        times: "list[float]" = []
        while len(times) < 31:  # it comes without being asked for, and may begin with nothing
            times = browser.history().get("P05", {"t": []})["t"]
        self.assertEqual((len(times), times[0], times[-1]), (31, 0, self.ask("status")["time"]))
        self.assertEqual(times, sorted(set(times)))

    def heard_until(self, browser: Browser, what: str) -> "list[dict[str, Any]]":
        """Events and lines of the log, to the first event of that name."""
        heard: "list[dict[str, Any]]" = []
        while not heard or heard[-1].get("what") != what:
            kind, data = browser.hear()
            heard += [m for m in [json.loads(data)] if m["topic"] in ("event", "log")] if kind == TEXT else []
        return heard

    def test_what_happened_before_is_told_once_and_with_its_time_of_day(self) -> None:
        browser = self.browser()
        browser.history()  # comes after what is remembered
        time.sleep(3)  # what comes soon after the gateway does may have been before
        self.meniscus("load", *SMALL, "--set", "threads=1000")  # which is warned of
        self.meniscus("step", "1")
        told = self.heard_until(browser, "paused")
        _, port = self.start_gateway("second", "--no-token")  # which reads the log, and to which the daemon repeats the last of each
        time.sleep(3)
        second = self.browser(port=port)
        self.meniscus("set", "gravity=[0, -1]")
        again = self.heard_until(second, "set")
        texts = [m["text"] for m in again]
        for message in told:
            self.assertRegex(message["when"], r"^\d{4}-\d\d-\d\dT")
            if message.get("what") != "loading":  # then the run had no log yet
                self.assertEqual(texts.count(message["text"]), 1, (message, texts))
        self.assertTrue(all(re.match(r"\d{4}-\d\d-\d\dT", m["when"]) for m in again))
        self.assertEqual([m["what"] for m in self.heard_until(browser, "set")], ["set"])

    def test_a_picture_that_is_refused_is_told_and_asked_for_with_patience(self) -> None:
        self.meniscus("load", *SMALL, "--set", "end_time=1000")
        self.meniscus("start")
        one, two = self.browser(), self.browser()
        one.say(do="show", field="no_such_field", limit=7, walls=True)
        two.say(do="show", field="pressure", limit=1000)
        refused = one.until("refused")
        self.assertEqual((refused["field"], refused["limit"], refused["walls"]), ("no_such_field", 7, True))
        self.assertEqual(refused["error"]["status"], "not found")
        self.assertIn("no_such_field", refused["error"]["message"])
        again, until = 0, time.monotonic() + 5
        while time.monotonic() < until:
            kind, data = one.hear()
            again += kind == TEXT and json.loads(data)["topic"] == "refused"
        self.assertIn(again, (1, 2))
        two.picture()  # the others have theirs

    def test_a_daemon_that_dies_is_missed_and_found_again(self) -> None:
        browser = self.browser()
        browser.until("daemon", alive=True)
        for _ in range(4):  # also while a status is under way
            self.kill_daemon_for(browser)
            browser.until("daemon", alive=True)
            browser.until("status")
        self.assertEqual(browser.ask(do="load", id=1, name="dambreak2d", settings=["resolution=20"])["state"], "READY")

    def kill_daemon_for(self, browser: Browser) -> None:
        cls = type(self)
        cls.daemon.kill()
        cls.daemon.wait()
        began = time.monotonic()
        error = browser.until("daemon", alive=False)["error"]
        self.assertLess(time.monotonic() - began, 15)  # half a second, where processors are free
        self.assertEqual(error["status"], "unavailable")
        self.assertTrue(error["hint"])
        self.assertIn("error", browser.ask(do="start", id=9))
        with contextlib.suppress(FileNotFoundError):
            (cls.home / "run" / "meniscus" / "default" / "control.ipc").unlink()
        cls.start_daemon()


class Page(DaemonTest):
    def test_the_logic_of_the_page(self) -> None:
        done = subprocess.run(["node", "--test", ROOT / "client" / "dashboard" / "web" / "test"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout)

    def browse(self, script: str) -> None:
        pictures = Path(os.environ.get("PICTURES", self.home))
        done = subprocess.run(
            ["node", ROOT / "tests" / "system" / script, BUILD, pictures], env=self.environment, capture_output=True, text=True, timeout=150,
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    @of_nightly
    def test_a_person_can_do_everything_in_a_browser(self) -> None:
        self.browse("dashboard.mjs")
        self.assertEqual(self.ask("status")["state"], "EMPTY")

    @of_nightly
    def test_a_space_is_drawn_and_all_else_works_without(self) -> None:
        self.meniscus("load", "dambreak3d", "--set", "resolution=10")
        self.browse("dashboard_view.mjs")
        self.meniscus("stop")

    @of_nightly
    def test_many_particles_cover_the_fluid_and_few_of_them_too(self) -> None:
        self.meniscus("load", "dambreak2d", "--set", "resolution=100")
        self.browse("dashboard_many.mjs")

    @of_nightly
    def test_a_run_that_has_stopped_by_itself_is_offered_only_what_is_possible(self) -> None:
        self.browse("dashboard_fault.mjs")

    @of_nightly
    def test_a_run_on_its_way_back_is_shown_and_can_be_stopped(self) -> None:
        self.meniscus("load", "dambreak2d", "--set", "resolution=8", "--set", "end_time=1000", "--set", "output.checkpoint_interval=1000")
        began = time.monotonic()
        while time.monotonic() < began + 15:
            self.meniscus("step", "2000")
        pictures = Path(os.environ.get("PICTURES", self.home))
        script = subprocess.Popen(
            ["node", ROOT / "tests" / "system" / "dashboard_back.mjs", BUILD, pictures], env=self.environment,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )
        said = []
        with script:
            assert script.stdout
            for line in script.stdout:  # what it wants done to the daemon
                said.append(line)
                if line == "do: kill\n":
                    type(self).daemon.kill()
                    type(self).daemon.wait()
                elif line == "do: start\n":
                    type(self).start_daemon()
        self.assertEqual(script.returncode, 0, "".join(said))
        self.assertEqual(self.ask("status")["state"], "EMPTY")


if __name__ == "__main__":
    unittest.main()

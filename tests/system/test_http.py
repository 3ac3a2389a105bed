#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The daemon over HTTP: metrics as Prometheus scrapes them, health in each state, who is refused, and clients that misbehave.
tests/protocol/test_daemon_http.c looks at single bytes, under the sanitizers too."""

import contextlib
import http.client
import json
import re
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any, Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, SMALL, DaemonTest, at_length, free_ports, of_nightly  # noqa: E402
from exposition import Family, parse  # noqa: E402

OPEN_METRICS = "application/openmetrics-text;version=1.0.0,text/plain;version=0.0.4;q=0.5"
IDLE_LIMIT_S = 10  # of server/http/http.c
DIVERGES = ["--set", "limits.density_max=1.0001", "--set", "gravity=[0, -100]"]
ENOUGH = 100  # scrapes, to tell their waits from others
PROMTOOL = shutil.which("promtool")


def own_address() -> str:
    """By which other machines call this one, or that of loopback where there are none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # nothing is sent
        except OSError:
            return "127.0.0.1"
        return str(probe.getsockname()[0])


def port_of(log: Path, address: str = "127.0.0.1") -> int:
    until = time.monotonic() + 20
    while time.monotonic() < until:
        found = re.search(re.escape(f"metrics at http://{address}:") + r"(\d+)/metrics", log.read_text())
        if found:
            return int(found[1])
        time.sleep(0.02)
    raise AssertionError(f"no port in the log: {log.read_text()}")


def fetch(port: int, path: str, method: str = "GET", **headers: str) -> "tuple[int, http.client.HTTPMessage, str]":
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
    with contextlib.closing(connection):
        connection.request(method, path, headers={name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read().decode()


class HttpTest(DaemonTest):
    options = ["--http", "0"]
    port: int

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.port = port_of(cls.home / "log")

    def scrape(self) -> "dict[str, Family]":
        code, headers, text = fetch(self.port, "/metrics")
        self.assertEqual((code, headers["Content-Type"]), (200, "text/plain; version=0.0.4; charset=utf-8"))
        return parse(text)

    def ready(self, parameters: str = "?run=loaded") -> "tuple[int, dict[str, Any]]":
        code, headers, text = fetch(self.port, "/readyz" + parameters)
        self.assertEqual(headers["Content-Type"], "application/json")
        return code, json.loads(text)


class Metrics(HttpTest):
    def test_a_page_of_another_site_learns_nothing(self) -> None:
        """Its browser calls us by the site's name, which has been pointed here."""
        before = self.scrape()["meniscus_http_answers_total"].value(code="403")
        code, _, text = fetch(self.port, "/metrics", Host=f"evil.example:{self.port}")
        self.assertEqual(code, 403)
        self.assertNotIn("meniscus_", text)
        self.assertEqual(self.scrape()["meniscus_http_answers_total"].value(code="403"), before + 1)

    def test_names_types_and_units_are_as_the_conventions_have_them(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("step", "5")
        plain = self.scrape()
        code, headers, text = fetch(self.port, "/metrics", Accept=OPEN_METRICS)
        self.assertEqual(code, 200)
        self.assertTrue(headers["Content-Type"].startswith("application/openmetrics-text; version=1.0.0"))
        of_open = parse(text, open_metrics=True)
        suffixed = {name + {"counter": "_total", "info": "_info"}.get(family.type, "") for name, family in of_open.items()}
        self.assertEqual(suffixed, set(plain))
        self.assertGreater(len(plain), 40)
        for name in plain:
            self.assertRegex(name, r"^(meniscus|process)_[a-z_]+$")

    @of_nightly
    def test_promtool_has_nothing_to_say(self) -> None:
        if not PROMTOOL:
            self.skipTest("promtool is missing: it is in the package prometheus")
        self.meniscus("load", *SMALL)
        self.meniscus("step", "5")
        text = fetch(self.port, "/metrics")[2]
        done = subprocess.run([PROMTOOL, "check", "metrics"], input=text, capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))

    def test_the_manual_lists_each_metric_with_its_type_and_no_other(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("start")
        self.meniscus("wait", "--for", "step=20", "--timeout", "60")
        there = {name: family.type for name, family in self.scrape().items()}
        manual = (ROOT / "server" / "http" / "README.md").read_text()
        listed = dict(re.findall(r"^\| `((?:meniscus|process)_\w+)[^|]*\| (gauge|counter) \|", manual, re.MULTILINE))
        self.assertEqual(listed, there)

    def test_numbers_agree_with_the_status(self) -> None:
        self.meniscus("load", *SMALL, "--set", "output.probe_interval=1e-6")
        before = self.scrape()
        self.meniscus("step", "30")
        status, metrics = self.ask("status"), self.scrape()

        def value(name: str, **labels: str) -> float:
            return metrics[name].value(**labels)

        self.assertEqual(value("meniscus_run_step"), status["step"])
        self.assertEqual(value("meniscus_run_time_seconds"), status["time"])
        self.assertEqual(value("meniscus_run_time_step_seconds"), status["time_step"])
        self.assertEqual(value("meniscus_run_end_time_seconds"), status["end_time"])
        self.assertEqual(value("meniscus_solver_threads"), status["threads"])
        self.assertEqual(value("meniscus_solver_memory_bytes"), status["memory_bytes"])
        self.assertEqual(sum(metrics["meniscus_particles"].samples.values()), status["particles"])
        for kind in ("fluid", "wall"):
            counted = sum(n for labels, n in metrics["meniscus_particles"].samples.items() if ("kind", kind) in labels)
            fluid = status["fluid_particles"]
            self.assertEqual(counted, fluid if kind == "fluid" else status["particles"] - fluid)
        for timer in status["timers"]:
            self.assertEqual(value("meniscus_solver_pass_seconds_total", **{"pass": timer["name"]}), timer["seconds"])
            self.assertEqual(value("meniscus_solver_pass_calls_total", **{"pass": timer["name"]}), timer["calls"])
        self.assertEqual(value("meniscus_run_state", state="PAUSED"), 1)
        self.assertEqual(sum(metrics["meniscus_run_state"].samples.values()), 1)
        probes = self.ask("query", "probes")["values"]
        self.assertGreater(len(probes), 0)
        self.assertEqual(len(metrics["meniscus_probe_value"].samples), len(probes))
        for probe, now in probes.items():
            self.assertAlmostEqual(value("meniscus_probe_value", probe=probe, unit=now["unit"]), now["value"])
        self.assertEqual(value("meniscus_steps_total") - before["meniscus_steps_total"].value(), 30)
        self.assertGreater(value("meniscus_stepping_seconds_total"), before["meniscus_stepping_seconds_total"].value())

    def test_steps_that_leave_densities_off_are_counted_and_told_once(self) -> None:
        """A start in disorder with one correction a step."""
        self.meniscus("load", "taylor-green2d", "--set", "resolution=20", "--set", "scheme.incompressible.density_corrections=1")
        self.assertEqual(self.ask("status")["uncorrected"], 0)
        self.meniscus("step", "10")
        status, metrics = self.ask("status"), self.scrape()
        self.assertGreater(status["uncorrected"], 1)
        self.assertEqual(metrics["meniscus_solver_uncorrected_total"].value(), status["uncorrected"])
        log = (Path(status["run_directory"]) / "log").read_text()
        self.assertEqual(log.count("scheme.incompressible.density_tolerance: step 1 leaves densities off by"), 1)
        self.assertEqual(log.count("density_tolerance"), 1)
        self.assertIn(f"off by more than the case allows after {status['uncorrected']} steps", self.meniscus("status").stdout)

    def test_counters_rise_while_it_runs(self) -> None:
        self.meniscus("load", *SMALL, "--set", "output.probe_interval=1e-6", "--set", "end_time=1000")
        self.meniscus("start")
        self.meniscus("wait", "--for", "step=20", "--timeout", "60")
        before = self.scrape()
        self.meniscus("wait", "--for", f"step={int(before['meniscus_run_step'].value()) + 50}", "--timeout", "60")
        self.meniscus("checkpoint")
        after = self.scrape()
        for name in ("meniscus_steps_total", "meniscus_stepping_seconds_total", "meniscus_heartbeats_total",
                     "meniscus_control_requests_total", "process_cpu_seconds_total"):
            self.assertGreater(after[name].value(), before[name].value(), name)
        for name, labels in (("meniscus_telemetry_bytes_total", {"topic": "probe"}),
                             ("meniscus_telemetry_messages_total", {"topic": "progress"}),
                             ("meniscus_output_files_total", {"kind": "checkpoint"}),
                             ("meniscus_output_seconds_total", {"kind": "checkpoint"}),
                             ("meniscus_http_answers_total", {"code": "200"})):
            self.assertGreater(after[name].value(**labels), before[name].value(**labels), name)
        self.assertAlmostEqual(after["meniscus_output_latest_timestamp_seconds"].value(kind="checkpoint"), time.time(), delta=60)
        for name, family in after.items():
            if family.type == "counter" and not name.startswith("meniscus_solver"):
                for labels, value in before[name].samples.items():
                    self.assertGreaterEqual(family.samples[labels], value, f"{name} {labels}")

    def test_what_the_process_uses_is_what_proc_says(self) -> None:
        metrics = self.scrape()
        resident = int(Path(f"/proc/{self.daemon.pid}/statm").read_text().split()[1]) * resource.getpagesize()
        self.assertAlmostEqual(metrics["process_resident_memory_bytes"].value(), resident, delta=resident / 4)
        fds = len(list(Path(f"/proc/{self.daemon.pid}/fd").iterdir()))
        self.assertAlmostEqual(metrics["process_open_fds"].value(), fds, delta=3)
        self.assertAlmostEqual(metrics["process_start_time_seconds"].value(), (self.home / "state").stat().st_ctime, delta=3600)
        disk = shutil.disk_usage(self.home)
        self.assertEqual(metrics["meniscus_disk_size_bytes"].value(), disk.total)
        self.assertAlmostEqual(metrics["meniscus_disk_free_bytes"].value(), disk.free, delta=disk.total / 20)

    def test_build_and_names(self) -> None:
        self.meniscus("load", *SMALL)
        metrics = self.scrape()
        labels = dict(next(iter(metrics["meniscus_build_info"].samples)))
        build = self.ask("capabilities")
        self.assertEqual(labels["version"], build["version"])
        self.assertEqual(labels["compiler"], build["compiler"])
        self.assertEqual(labels["commit"], build.get("commit", ""))
        self.assertIn(labels["level"], build["build"])
        self.assertEqual(metrics["meniscus_daemon_info"].value(name="default"), 1)
        self.assertEqual(metrics["meniscus_run_info"].value(case="dambreak2d", scheme="riemann"), 1)

    def test_a_title_with_hidden_characters_is_shown_with_its_escapes(self) -> None:
        self.meniscus("load", *SMALL, "--set", 'title="dam\\nstate\\t\\u202egpj.exe\\u200b"')
        for accept in "text/plain", "application/openmetrics-text":
            text = fetch(self.port, "/metrics", Accept=accept)[2]
            self.assertTrue(text.replace("\n", "").isprintable())
            self.assertIn(r'title="dam\\nstate\\t\\u202egpj.exe\\u200b"', text)


class Access(HttpTest):
    """A daemon that listens to those who have a key."""

    far: str

    @classmethod
    def start_daemon(cls) -> None:
        cls.environment["MENISCUS_KEYS"] = str(cls.home / "keys")
        for name, role in (("vera", "viewer"), ("otto", "operator"), ("olga", "operator")):
            subprocess.run([BUILD / "meniscus", "keys", "new", name, "--role", role], env=cls.environment, check=True,
                           stdout=subprocess.DEVNULL)
        cls.far = f"tcp://127.0.0.1:{free_ports()}"
        cls.options = [*HttpTest.options, "--listen", cls.far]
        super().start_daemon()

    def await_rise(self, name: str, before: "dict[str, Family]", **labels: str) -> None:
        until = time.monotonic() + 20
        while self.scrape()[name].value(**labels) <= before[name].value(**labels):
            self.assertLess(time.monotonic(), until, f"{name} {labels}")

    def await_keys(self, **roles: int) -> "dict[str, Family]":
        """The daemon reads keys again when it sees that they changed, which need not be before the next scrape."""
        until = time.monotonic() + 20
        while True:
            families = self.scrape()
            found = families["meniscus_access_keys"].samples
            if found == {(("role", role),): n for role, n in roles.items()}:
                return families
            self.assertLess(time.monotonic(), until, found)

    def test_who_was_not_let_in_is_counted_by_reason(self) -> None:
        failed, key = "meniscus_access_handshakes_failed_total", str(self.home / "old.key")
        made = Path(self.ask("keys", "new", "old", "--role", "viewer")["file"])
        shutil.copy2(made, key)
        self.meniscus("keys", "remove", "old")
        before = self.await_keys(viewer=1, operator=2, admin=0)
        self.meniscus("status", "--daemon", self.far, "--key", key, code=77)
        self.await_rise(failed, before, reason="key")
        where = "127.0.0.1", int(self.far.rsplit(":", 1)[1])
        with socket.create_connection(where) as plain, contextlib.suppress(ConnectionResetError):
            plain.sendall(b"\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL".ljust(64, b"\0"))
            while plain.recv(64):
                pass
        self.await_rise(failed, before, reason="protocol")
        with socket.create_connection(where):
            pass
        self.await_rise(failed, before, reason="silence")
        self.meniscus("start", "--daemon", self.far, "--key", str(self.home / "keys" / "vera.key"), code=77)
        self.await_rise("meniscus_access_denied_total", before)

    def test_the_journal_and_the_lease_are_told_of(self) -> None:
        self.meniscus("load", *SMALL)
        before = self.scrape()
        self.assertEqual(before["meniscus_lease_seconds"].value(), 0)
        epoch = str(self.ask("lease", "--ttl", "60")["lease_epoch"])
        after = self.scrape()
        self.assertAlmostEqual(after["meniscus_lease_seconds"].value(), 60, delta=20)
        # The command, and that somebody was told.
        self.assertEqual(after["meniscus_journal_records_total"].value(), before["meniscus_journal_records_total"].value() + 2)
        self.assertGreater(after["meniscus_journal_seconds_total"].value(), before["meniscus_journal_seconds_total"].value())
        self.assertEqual(after["meniscus_journal_failures_total"].value(), 0)
        self.meniscus("lease", "release", "--lease", epoch)
        self.assertEqual(self.scrape()["meniscus_lease_seconds"].value(), 0)


class Health(HttpTest):
    def test_readiness_follows_the_run(self) -> None:
        self.assertEqual(fetch(self.port, "/healthz")[0], 200)
        code, told = self.ready()
        self.assertEqual((code, told["ready"], told["state"]), (503, False, "EMPTY"))
        self.assertIn("meniscus load CASE", told["reason"])
        self.meniscus("load", *SMALL, "--set", "end_time=0.5")
        self.assertEqual(self.ready(), (200, {"ready": True, "state": "READY", "case": "dambreak2d"}))
        self.meniscus("step", "1")
        self.assertEqual(self.ready(), (200, {"ready": True, "state": "PAUSED", "case": "dambreak2d"}))
        self.meniscus("resume")
        self.meniscus("wait", "--for", "state=DONE", "--timeout", "100")
        self.assertEqual(self.ready(), (200, {"ready": True, "state": "DONE", "case": "dambreak2d"}))
        self.meniscus("stop")
        self.assertEqual(self.ready()[0], 503)

    def test_a_daemon_that_takes_commands_is_ready_whether_it_has_a_run_or_not(self) -> None:
        self.assertEqual(self.ready(""), (200, {"ready": True, "state": "EMPTY"}))
        self.meniscus("load", *SMALL, *DIVERGES)
        self.meniscus("start")
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        code, told = self.ready("")
        self.assertEqual((code, told["ready"], told["state"], told["fault_reason"]), (200, True, "FAULT", "diverged"))
        code, _, text = fetch(self.port, "/readyz?run=there")
        self.assertEqual((code, "run=loaded" in text), (400, True))

    def test_a_fault_is_not_ready_says_why_and_is_counted(self) -> None:
        faults = self.scrape()["meniscus_faults_total"].value(reason="diverged")
        self.meniscus("load", *SMALL, *DIVERGES)
        self.meniscus("start")
        self.meniscus("wait", "--for", "state=FAULT", "--timeout", "60")
        code, told = self.ready()
        self.assertEqual((code, told["ready"], told["state"], told["fault_reason"]), (503, False, "FAULT", "diverged"))
        self.assertEqual(told["reason"], self.ask("status")["fault"])
        self.assertEqual(fetch(self.port, "/healthz")[0], 200)
        metrics = self.scrape()
        self.assertEqual(metrics["meniscus_faults_total"].value(reason="diverged"), faults + 1)
        self.assertEqual(metrics["meniscus_run_state"].value(state="FAULT"), 1)
        self.meniscus("reset")
        self.assertEqual(self.ready()[0], 200)


class Cost(HttpTest):
    """What scrapes cost the solver: no step waits for one."""

    def threads(self) -> "dict[int, tuple[int, int]]":
        """Of the daemon, by number: niceness, and how often it has waited for something, of its own accord."""
        found = {}
        for task in Path(f"/proc/{self.daemon.pid}/task").iterdir():
            waits = re.search(r"^voluntary_ctxt_switches:\s+(\d+)", (task / "status").read_text(), re.MULTILINE)
            assert waits
            found[int(task.name)] = int((task / "stat").read_text().rsplit(")", 1)[1].split()[16]), int(waits[1])
        return found

    def test_the_solver_waits_for_no_scrape(self) -> None:
        self.meniscus("load", *SMALL, "--set", "end_time=1000", "--set", "threads=1", "--set", "output.probe_interval=0",
                      "--set", "output.snapshot_interval=0")
        self.meniscus("start")
        (solver,) = (number for number, (nice, _) in self.threads().items() if nice == 10)
        before, quiet = self.measure(solver, lambda: time.sleep(0.02))
        with contextlib.closing(http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)) as connection:
            steps, hammered = self.measure(solver, lambda: self.ask_again(connection))
        self.assertGreater(min(before, steps), 0)
        self.assertGreater(self.scrapes, ENOUGH)
        # It may wait now and then for the desk, which is told of progress; not for those who look.
        self.assertLess(hammered, quiet + self.scrapes / 20)

    def test_who_answers_comes_last_when_processors_are_short(self) -> None:
        fetch(self.port, "/metrics")
        self.assertEqual([nice for nice, _ in self.threads().values()].count(19), 1)

    def ask_again(self, connection: http.client.HTTPConnection) -> None:
        connection.request("GET", "/metrics")
        self.assertEqual(connection.getresponse().read()[:2], b"# ")
        self.scrapes += 1

    def measure(self, solver: int, meanwhile: "Callable[[], None]") -> "tuple[int, int]":
        """Steps done in four seconds, or in as many as enough scrapes take, and waits of the solver's thread, while something else is done again
        and again."""
        self.scrapes = 0
        step, waits = self.ask("status")["step"], self.threads()[solver][1]
        began = time.monotonic()
        while time.monotonic() < began + 4 or (0 < self.scrapes <= ENOUGH and time.monotonic() < began + 120):
            meanwhile()
        return self.ask("status")["step"] - step, self.threads()[solver][1] - waits


class Crowd(HttpTest):
    """Clients that hold connections."""

    def connect(self, n: int, words: bytes) -> "list[socket.socket]":
        sockets = []
        for _ in range(n):
            client = socket.create_connection(("127.0.0.1", self.port), timeout=30)
            self.addCleanup(client.close)
            with contextlib.suppress(ConnectionError):
                client.sendall(words)
            sockets.append(client)
        return sockets

    def test_a_thousand_silent_clients_do_not_stop_the_next_one(self) -> None:
        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(limits[0], min(4096, limits[1])), limits[1]))  # shells allow 1024
        before = self.scrape()
        for words in (b"", b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nX-Slow: "):
            self.connect(1000, words)
            metrics = self.scrape()
            self.assertLessEqual(metrics["meniscus_http_connections"].value(), 64)
            self.assertLess(metrics["process_open_fds"].value(), before["process_open_fds"].value() + 100)
            # Older connections were closed for this one; it did not wait for the idle limit.
            crowded_out = metrics["meniscus_http_crowded_out_total"].value()
            self.assertGreater(crowded_out, before["meniscus_http_crowded_out_total"].value())
            before = metrics

    def test_clients_that_never_read_cost_no_more_than_their_bounds(self) -> None:
        self.meniscus("load", *SMALL)
        before = self.scrape()["process_resident_memory_bytes"].value()
        for _ in range(4):
            self.connect(64, b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n" * 200)
        after = self.scrape()["process_resident_memory_bytes"].value()
        self.assertLess(after - before, 16 << 20)
        self.assertEqual(self.ask("status")["state"], "READY")

    def test_who_says_nothing_is_shown_out_after_the_idle_limit(self) -> None:
        (client,) = self.connect(1, b"GET /met")
        began = time.monotonic()
        client.settimeout(60)
        with contextlib.suppress(ConnectionError):
            client.recv(100)
        waited = time.monotonic() - began
        self.assertGreater(waited, IDLE_LIMIT_S / 2)
        if at_length():
            self.assertLess(waited, 2 * IDLE_LIMIT_S)


class Refused(unittest.TestCase):
    """Daemons that do not start, or ask for a token."""

    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory(prefix="mns-")
        self.addCleanup(scratch.cleanup)
        self.home = Path(scratch.name)
        (self.home / "run").mkdir(mode=0o700)
        self.token = self.home / "token"
        self.token.write_text("0123456789abcdef0123456789abcdef\n")
        self.token.chmod(0o600)

    def daemon(self, *options: str) -> "subprocess.Popen[str]":
        daemon = subprocess.Popen(
            [BUILD / "meniscusd", "--name", "h", "--state-dir", self.home / "state", *options],
            env={"XDG_RUNTIME_DIR": str(self.home / "run")}, stderr=open(self.home / "log", "w"), text=True,
        )
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        return daemon

    def refused(self, code: int, words: str, *options: str) -> None:
        daemon = self.daemon(*options)
        self.assertEqual(daemon.wait(timeout=60), code, (self.home / "log").read_text())
        self.assertRegex((self.home / "log").read_text(), words)
        self.assertFalse((self.home / "run" / "meniscus" / "h" / "control.ipc").exists())

    def test_other_machines_are_served_for_a_token_and_a_word_of_consent_only(self) -> None:
        """The token goes over the network for all to read, which whoever gives the address may not know."""
        for address in ("0.0.0.0:0", "[::]:0"):
            for more in ([], ["--http-token", str(self.token)], ["--http-plain"]):
                self.refused(2, "other machines reach .*not encrypted.*--http-plain.*--http-token FILE", "--http", address, *more)

    def test_what_cannot_be_meant_is_refused_with_what_can(self) -> None:
        for address in ("x", "70000", "127.0.0.1", "host:80", ""):
            self.refused(2, "--http takes a port .*127.0.0.1:9464", "--http", address)
        self.refused(2, "give both", "--http-token", str(self.token))
        self.refused(2, "give both", "--http-plain")
        self.refused(2, "leave out .*--http", "--http", "0", "--batch", "dambreak2d")

    def test_a_token_that_others_can_read_is_refused(self) -> None:
        self.token.chmod(0o644)
        self.refused(2, "chmod 600", "--http", "0", "--http-token", str(self.token))
        self.refused(74, "No such file", "--http", "0", "--http-token", str(self.home / "nothing"))

    def test_a_port_that_is_taken_is_refused(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as other:
            self.refused(74, "Address already in use", "--http", str(other.getsockname()[1]))

    def test_with_a_token_only_who_knows_it_is_answered(self) -> None:
        self.daemon("--http", "0", "--http-token", str(self.token))
        port = port_of(self.home / "log")
        for path in ("/metrics", "/readyz", "/"):
            code, headers, text = fetch(port, path)
            self.assertEqual((code, headers["WWW-Authenticate"]), (401, 'Bearer realm="meniscus"'))
            self.assertNotIn("meniscus_", text)
            self.assertEqual(fetch(port, path, Authorization="Bearer " + "x" * 32)[0], 401)
        word = "Bearer " + self.token.read_text().strip()
        self.assertEqual(fetch(port, "/healthz", Authorization=word)[0], 200)
        self.assertEqual(fetch(port, "/healthz")[0], 200)  # this machine may ask whether it lives
        self.assertEqual(fetch(port, "/healthz", Host="LOCALHOST.")[0], 200)
        code, _, text = fetch(port, "/healthz", Host="evil.example")
        self.assertEqual((code, "without --http-token" in text), (403, False))  # there is one
        self.assertIn("a request that shows no token must call this machine localhost, or by its address in digits", text)
        self.assertEqual(fetch(port, "/healthz", Host="evil.example", Authorization=word)[0], 200)
        answers = parse(fetch(port, "/metrics", Authorization=word)[2])["meniscus_http_answers_total"]
        self.assertEqual(answers.value(code="401"), 6)

    def test_other_machines_ask_whether_it_lives_by_an_option(self) -> None:
        here = own_address()
        for more, code in (((), 200 if here == "127.0.0.1" else 401), (("--http-liveness",), 200)):
            daemon = self.daemon("--http", f"{here}:0", "--http-token", str(self.token), "--http-plain", *more)
            port = port_of(self.home / "log", here)
            for path, wanted in (("/healthz", code), ("/readyz", 401)):
                connection = http.client.HTTPConnection(here, port, timeout=30)
                with contextlib.closing(connection):
                    connection.request("GET", path)
                    self.assertEqual(connection.getresponse().status, wanted)
            daemon.terminate()
            self.assertEqual(daemon.wait(30), 0)
        self.refused(2, "give all three", "--http", "0", "--http-liveness")

    def test_with_a_token_all_addresses_can_be_served(self) -> None:
        self.daemon("--http", "127.0.0.1:0")
        port_of(self.home / "log")
        self.addCleanup(lambda: None)
        other = self.home / "other"
        other.mkdir()
        log = open(other / "log", "w")
        self.addCleanup(log.close)
        daemon = subprocess.Popen(
            [BUILD / "meniscusd", "--name", "far", "--state-dir", other / "state", "--http", "0.0.0.0:0", "--http-token", self.token,
             "--http-plain"],
            env={"XDG_RUNTIME_DIR": str(self.home / "run")}, stderr=log,
        )
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        until = time.monotonic() + 20
        while not (found := re.search(r"http://0\.0\.0\.0:(\d+)/", (other / "log").read_text())) and time.monotonic() < until:
            time.sleep(0.02)
        assert found
        self.assertIn("HTTP is not encrypted", (other / "log").read_text())
        self.assertEqual(fetch(int(found[1]), "/metrics")[0], 401)


if __name__ == "__main__":
    unittest.main()

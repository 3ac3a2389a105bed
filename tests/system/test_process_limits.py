#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Limits that the system sets for a process, as batch systems, containers and service units do: said in a sentence, or made do with."""

import contextlib
import ctypes
import json
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.request
from pathlib import Path
from typing import Any

import h5py
import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, control_socket, free_ports, start_in, surroundings  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402

CASE = ["dambreak2d", "--set", "threads=1", "--set", "resolution=10", "--set", "end_time=0.1"]
DROP = ["cube-drop3d", "--set", "threads=2", "--set", "resolution=6", "--set", "end_time=0.0005"]  # surfaces take the longest arrays
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

    def rows(self, directory: str) -> "list[int]":
        with h5py.File(self.home / directory / "probes.hdf") as file:
            steps: "list[int]" = file["step"][:].tolist()
            return steps

    def test_a_run_that_meets_the_limit_goes_on_without_a_gap(self) -> None:
        """Probes write a file that grows beyond it; no checkpoint stands behind rows that are not there."""
        case = [*CASE, "--set", "resolution=6", "--set", "output.probe_interval=1e-5", "--set", "end_time=12", "--set", "output.checkpoint_interval=0.5"]
        run = [BUILD / "meniscus", "run", *case, "-o", "json", "--out"]
        undisturbed = json.loads(self.under("true", *run, "undisturbed", code=0).stdout)
        done = self.under("ulimit -f 100", *run, "r", code=74)
        told = json.loads(done.stdout)
        self.assertIn("File too large; raise the limit on the size of files (`ulimit -f`", done.stderr)
        self.assertRegex(done.stderr, rf"lost: the state at step {told['steps']} is not kept, a resume goes on from ")
        self.assertIn("raise the limit on the size of files (`ulimit -f`)", told["error"]["hint"])
        self.assertEqual(told["state"], "FAULT")
        self.assert_whole(self.home / "r")
        again = json.loads(self.under("true", *run, "r", "--resume", "auto", code=0).stdout)
        self.assertEqual(again["state_hash"], undisturbed["state_hash"])
        self.assertEqual(self.rows("r"), self.rows("undisturbed"))

    def test_what_is_printed_into_a_file_is_whole_or_refused(self) -> None:
        words = limited("ulimit -f 1", BUILD / "meniscus", "completion", "bash")
        with open(self.home / "out", "wb") as out:
            done = subprocess.run(words, env=self.environment, stdout=out, stderr=subprocess.PIPE, timeout=60)
        self.assertEqual(done.returncode, 74, done.stderr)
        self.assertIn(b"File too large", done.stderr)


class NoHome(Alone):
    """Containers and services may have no HOME."""

    def test_a_daemon_without_a_place_for_its_runs_is_refused(self) -> None:
        names = "HOME XDG_STATE_HOME STATE_DIRECTORY"
        done = self.under(f"unset {names}", "timeout", "10", BUILD / "meniscusd", code=2)
        self.assertRegex(done.stderr, r"as HOME is not set; give meniscusd --state-dir DIR, or set HOME to an absolute path\n$")
        self.assertEqual([path.name for path in self.home.iterdir() if path.name.startswith("meniscus")], [])
        told = self.under(f"unset {names}", BUILD / "meniscus", "doctor", code=1).stdout
        self.assertIn("HOME is not set", told)
        done = self.under("unset XDG_STATE_HOME STATE_DIRECTORY", "timeout", "10", BUILD / "meniscusd", code=2, HOME=".")
        self.assertRegex(done.stderr, "as HOME is no absolute path; give meniscusd --state-dir DIR, or set HOME to an absolute path\n$")
        self.assertFalse((self.home / ".local").exists())
        done = self.under("true", "timeout", "10", BUILD / "meniscusd", "--state-dir", "", code=2)
        self.assertIn("--state-dir takes the path of a directory", done.stderr)

    def test_so_has_each_command_that_needs_keys(self) -> None:
        names = "HOME XDG_STATE_HOME XDG_CONFIG_HOME MENISCUS_KEYS"
        listen = [BUILD / "meniscusd", "--state-dir", "s", "--listen", f"tcp://127.0.0.1:{free_ports()}"]
        for words in ([BUILD / "meniscus", "keys", "list"], [BUILD / "meniscus", "keys", "new", "eve", "--role", "viewer"],
                      [BUILD / "meniscus", "keys", "remove", "eve"], listen):  # fmt: skip
            done = self.under(f"unset {names}", *words, code=2)
            self.assertIn("there is no place for keys, as HOME is not set; set MENISCUS_KEYS to their directory, or HOME to an absolute path\n", done.stderr)
        told = json.loads(self.under(f"unset {names}", BUILD / "meniscus", "keys", "list", "-o", "json", code=2).stdout)
        self.assertEqual((told["error"]["status"], told["error"]["exit_code"]), ("invalid", 2))
        self.under("true", BUILD / "meniscus", "keys", "list", "--keys", "", code=2)
        self.assertEqual({path.name for path in self.home.iterdir()} & {"s", "meniscus"}, set())

    def test_relative_variables_of_xdg_do_not_count(self) -> None:
        """For the daemon, its clients and their keys alike."""
        name, relative = f"relative-{os.getpid()}", ("XDG_RUNTIME_DIR", "XDG_STATE_HOME", "XDG_CONFIG_HOME")
        self.environment |= {"HOME": str(self.home / "own"), "MENISCUS_DAEMON": name} | dict.fromkeys(relative, "here")
        for directory in "own", "here", "elsewhere":
            (self.home / directory).mkdir(mode=0o700)
        daemon = subprocess.Popen([BUILD / "meniscusd", "--name", name], env=self.environment, cwd=self.home, stderr=subprocess.DEVNULL)
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.terminate)
        socket_file = Path(f"/tmp/meniscus-{os.getuid()}/{name}/control.ipc")
        until = time.monotonic() + 20
        while not socket_file.exists() and time.monotonic() < until:
            time.sleep(0.01)
        look = f"import sys; sys.path.insert(0, '{BUILD}/python'); import meniscus; print(meniscus.Client().status().state)"
        for place in "true", "cd elsewhere":
            self.assertIn("EMPTY", self.under(place, BUILD / "meniscus", "status", code=0).stdout)
            self.assertIn("EMPTY", self.under(place, sys.executable, "-c", look, code=0).stdout)
        self.under("true", BUILD / "meniscus", "keys", "new", "eve", "--role", "viewer", code=0)
        self.assertTrue((self.home / "own/.config/meniscus/keys/eve.key").exists())
        self.assertTrue((self.home / f"own/.local/state/meniscus/{name}").is_dir())
        self.assertEqual(list((self.home / "here").iterdir()), [])
        told = self.under("true", BUILD / "meniscus", "doctor", code=0).stdout
        for variable in relative:
            self.assertIn(f"{variable} is here, which is no absolute path and does not count", told)


class Stacks(Alone):
    """`ulimit -s` and OMP_STACKSIZE: what a thread has for the arrays of a function."""

    RUN = [BUILD / "meniscus", "run", *DROP, "-o", "json"]

    def test_too_small_ones_of_openmp_are_refused_with_what_is_needed(self) -> None:
        for words in (self.RUN, [BUILD / "meniscusd", "--state-dir", "s"]):
            done = self.under("true", *words, code=2, OMP_STACKSIZE="200k")
            self.assertIn("stacks of 200 KiB, and the solver needs 512; set OMP_STACKSIZE=512k or more, or leave it out\n", done.stderr)
            for line in done.stdout.splitlines():
                self.assertEqual(json.loads(line)["exit_code"], 2)

    def test_those_that_no_thread_can_have_are_refused_in_the_same_way(self) -> None:
        for name, size in (("OMP_STACKSIZE", "16k"), ("OMP_STACKSIZE", "31k"), ("GOMP_STACKSIZE", "20"), ("OMP_STACKSIZE", "100000g")):
            for words in (self.RUN, [BUILD / "meniscus", "check", *DROP, "-o", "json"], [BUILD / "meniscusd", "--state-dir", "s"]):
                with self.subTest(f"{name}={size}", program=words[1]):
                    done = self.under("true", *words, code=2, **{name: size})
                    self.assertIn(f"cannot be started with {name}={size}; set {name}=512k", done.stderr)
                    self.assertNotIn("libgomp", done.stderr)
                    for line in done.stdout.splitlines():
                        self.assertEqual(json.loads(line)["exit_code"], 2)

    def test_what_computes_nothing_needs_none(self) -> None:
        self.under("true", BUILD / "meniscusd", "--schemes", code=0, OMP_STACKSIZE="200k")

    def test_standard_files_that_are_closed_are_none_of_ours(self) -> None:
        """As supervisors start programs: what is opened then must not take their places. Where the result cannot be printed it is 74, after the run."""
        for closed in ("<&- >&-", "<&- 2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            with self.subTest(closed):
                self.under("true", "bash", "-c", f'exec "$@" {closed}', "bash", BUILD / "meniscus", "run", *DROP, "--out", "c", "--overwrite",
                           code=74 if " >&-" in f" {closed}" else 0)  # fmt: skip
                self.assertTrue(list((self.home / "c").glob("checkpoint-*.hdf")))

    def test_what_is_named_is_enough(self) -> None:
        self.assertEqual(json.loads(self.under("true", *self.RUN, code=0, OMP_STACKSIZE="512k").stdout)["state"], "DONE")

    def test_a_small_limit_is_none(self) -> None:
        for small in ("ulimit -s 160", "ulimit -s 64", "ulimit -s 40"):
            with self.subTest(small):
                self.assertEqual(json.loads(self.under(small, *self.RUN, "--out", "o", "--overwrite", code=0).stdout)["state"], "DONE")
                self.under(small, BUILD / "meniscus", "check", *DROP, code=0)
                self.under(small, BUILD / "meniscus", "replay", "o", "--verify", code=0)
                snapshot = next((self.home / "o").glob("snapshot-*.hdf"))
                self.under(small, BUILD / "meniscus", "render", snapshot, "--out", "picture.png", code=0)
                self.under(small, BUILD / "meniscusd", "--schemes", code=0)

    def test_signals_arrive_as_without_it(self) -> None:
        """The main thread waits for another one, which has the stack: it may not take what that one is to read."""
        for number, code in ((signal.SIGTERM, 75), (signal.SIGINT, 75), (signal.SIGHUP, 75), (signal.SIGKILL, -9)):
            with self.subTest(number):
                words = limited("ulimit -s 40", BUILD / "meniscus", "run", *CASE, "--set", "end_time=1000", "--out", "r", "--overwrite")
                run = subprocess.Popen(words, env=self.environment, cwd=self.home, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE)  # fmt: skip
                self.addCleanup(run.kill)
                assert run.stderr
                run.stderr.read(1)  # of its progress
                run.send_signal(number)
                run.communicate(timeout=60)
                self.assertEqual(run.returncode, code)


class StacksOfDaemon(DaemonTest):
    """All of its threads, where the limit would give each less than it needs."""

    @classmethod
    def start_daemon(cls) -> None:
        program = cls.home / "limited"
        program.write_text(f'#!/bin/bash\nulimit -s 40\nexec {BUILD}/meniscusd "$@"\n')
        program.chmod(0o755)
        cls.http = free_ports()
        cls.options = ["--http", str(cls.http)]
        cls.daemon = start_in(cls.home, cls.environment, cls.options, program)

    def test_it_does_all_that_others_do(self) -> None:
        self.meniscus("load", *DROP)
        stream = subprocess.Popen([BUILD / "meniscus", "stream", "fields", "velocity", "--count", "2"], env=self.environment,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        self.addCleanup(stream.wait)
        self.addCleanup(stream.kill)
        self.meniscus("start")
        self.meniscus("wait", "--for", "state=DONE")
        for words in (["snapshot"], ["checkpoint"], ["query", "probes"], ["query", "at", "pressure", "0.1,0.1,0.1"], ["capabilities"]):
            self.meniscus(*words)
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http}/metrics", timeout=20) as page:
            self.assertIn(b"meniscus_", page.read())
        self.assertIsNone(self.daemon.poll())


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


class OpenFiles(DaemonTest):
    """`ulimit -n`: more connections than files, local ones and those over TCP."""

    LIMIT, CROWD = 1024, 1200

    @classmethod
    def start_daemon(cls) -> None:
        cls.port = free_ports()
        program = cls.home / "limited"
        program.write_text(f'#!/bin/bash\nulimit -n {cls.LIMIT}\nexec {BUILD}/meniscusd "$@"\n')
        program.chmod(0o755)
        cls.options = ["--tcp", str(cls.port)]
        cls.daemon = start_in(cls.home, cls.environment, cls.options, program)

    def files(self) -> int:
        return len(os.listdir(f"/proc/{self.daemon.pid}/fd"))

    def crowd(self, endpoint: str) -> None:
        """Subscribers who stay."""
        words = [BUILD / "tests" / "torture" / "subscribers", endpoint, str(self.CROWD), "600", "no such topic"]
        process = subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)

    def test_a_crowd_of_subscribers_costs_the_run_nothing(self) -> None:
        for endpoint in (f"ipc://{control_socket(self.home).with_name('telemetry.ipc')}", f"tcp://127.0.0.1:{self.port + 1}"):
            with self.subTest(endpoint):
                self.crowd(endpoint)
                self.wait_until(lambda: "connections are closed" in (self.home / "log").read_text())
                self.meniscus("load", *CASE, "--set", "output.snapshot_interval=0.01", "--name", endpoint[:3])
                self.meniscus("start")
                self.assertEqual(self.ask("wait", "--for", "state=DONE")["state"], "DONE")
                self.meniscus("checkpoint")
                self.assertEqual(self.ask("status", "--daemon", f"tcp://127.0.0.1:{self.port}")["state"], "DONE")
                self.assertLess(self.files(), self.LIMIT - 32)
                self.assertIsNone(self.daemon.poll())
                self.meniscus("stop")
                self.doCleanups()

    def test_a_crowd_that_sends_commands_leaves_files_for_the_run(self) -> None:
        directory = Path(self.ask("load", *CASE)["message"])
        crowd = [socket.socket(socket.AF_UNIX) for _ in range(self.CROWD)]
        for guest in crowd:
            self.addCleanup(guest.close)
            guest.connect(str(control_socket(self.home)))
        self.wait_until(lambda: self.files() > self.LIMIT - 192)
        os.kill(self.daemon.pid, signal.SIGUSR1)
        self.wait_until(lambda: bool(list(directory.glob("checkpoint-*.hdf"))))
        self.doCleanups()
        self.assertEqual(self.ask("status")["state"], "READY")

    def test_the_soft_limit_is_raised(self) -> None:
        program = 'ulimit -Sn 64; exec "$@"'
        home = Path(tempfile.mkdtemp(dir=self.home))
        environment = surroundings(home)
        daemon = subprocess.Popen(["bash", "-c", program, "bash", BUILD / "meniscusd", "--state-dir", home / "s"], env=environment,
                                  stderr=subprocess.DEVNULL)  # fmt: skip
        self.addCleanup(daemon.wait)
        self.addCleanup(daemon.kill)
        self.wait_until(control_socket(home).exists)
        soft, hard = resource.prlimit(daemon.pid, resource.RLIMIT_NOFILE)
        self.assertEqual(soft, hard)


class FewFiles(DaemonTest):
    """`ulimit -n` below what programs take: ZeroMQ would end them by a signal."""

    def under(self, limit: int, *words: "str | Path") -> Done:
        done = subprocess.run(limited(f"ulimit -n {limit}", *words), env=self.environment, capture_output=True, text=True, timeout=60, cwd=self.home)
        if done.returncode:
            self.assertEqual(done.returncode, 74, f"{words} at {limit}: {done.stdout}{done.stderr}")
            self.assertRegex(done.stderr, rf"takes at least \d+ open files, and the process may have {limit}.*`ulimit -n`")
        return done

    def test_each_program_works_or_says_how_many_it_takes(self) -> None:
        self.meniscus("load", *CASE, "--set", "end_time=1000", "--start")
        run = ["run", *CASE, "--set", "end_time=0.001", "--out", "r", "--overwrite", "-o", "json"]
        for words in (["status"], ["ls"], ["stream", "probes", "--count", "1"], ["query", "probes"], ["keys", "list"], run):
            with self.subTest(words[0]):
                codes = [self.under(limit, BUILD / "meniscus", *words).returncode for limit in (*range(4, 32, 3), 31, 32, 33, 64)]
                self.assertEqual(codes, sorted(codes, reverse=True))
                self.assertEqual(codes[-3:], [0, 0, 0])
        programs: "list[list[str | Path]]" = [[BUILD / "meniscusd", "--name", "few", "--state-dir", "few"],
                                              [BUILD / "meniscusd", "--name", "few", "--state-dir", "few", "--tcp", str(free_ports())]]
        if (BUILD / "meniscus-dashboard").exists():  # which needs more to be built
            programs.append([BUILD / "meniscus-dashboard", "--http", "0"])
        for words in programs:
            for limit in range(4, 64):
                with self.subTest(words[0], limit=limit):
                    self.assertEqual(self.under(limit, *words).returncode, 74)
        self.assertFalse((self.home / "few").exists())

    def test_scripts_are_told_in_json(self) -> None:
        for words in (["meniscusd", "--batch", *CASE], ["meniscus", "run", *CASE]):
            told = json.loads(self.under(12, BUILD / words[0], *words[1:], "-o", "json").stdout)
            self.assertEqual((told["error"]["exit_code"], told["error"]["status"]), (74, "limit reached"))

    def test_a_daemon_does_all_that_others_do_with_as_few_as_it_takes(self) -> None:
        for limit, more in ((64, []), (128, ["--tcp", str(free_ports()), "--http", str(free_ports())])):
            home = Path(tempfile.mkdtemp(dir=self.home))
            environment = surroundings(home)
            program = home / "limited"
            program.write_text(f'#!/bin/bash\nulimit -n {limit}\nexec {BUILD}/meniscusd "$@"\n')
            program.chmod(0o755)
            daemon = start_in(home, environment, more, program)
            self.addCleanup(daemon.wait)
            self.addCleanup(daemon.kill)
            watch = subprocess.Popen([BUILD / "meniscus", "watch", "-o", "json"], env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
            self.addCleanup(watch.communicate)
            self.addCleanup(watch.kill)
            for words in (["load", *CASE, "--set", "end_time=1000", "--start"], ["stream", "fields", "velocity", "--count", "2"],
                          ["snapshot"], ["checkpoint"], ["status"]):  # fmt: skip
                subprocess.run([BUILD / "meniscus", *words], env=environment, check=True, capture_output=True, timeout=60)
            assert watch.stdout
            self.assertTrue(watch.stdout.readline())

    def test_so_does_a_program_in_python(self) -> None:
        words = "import resource, meniscus, sys; n = int(sys.argv[1]); resource.setrlimit(resource.RLIMIT_NOFILE, (n, n)); meniscus.Client().status()"
        environment = self.environment | {"PYTHONPATH": str(BUILD / "python")}
        codes = []
        for limit in range(3, 33):
            done = subprocess.run([sys.executable, "-c", words, str(limit)], env=environment, capture_output=True, text=True, timeout=60)
            codes.append(done.returncode)
            if done.returncode:
                self.assertRegex(done.stderr, r"MeniscusError: a connection takes 16 open files, and of the \d+ that this process may have, (1 is|\d+ are) left")
        self.assertEqual(codes, sorted(codes, reverse=True))
        self.assertEqual((codes[0], codes[-1]), (1, 0))

    def test_files_that_the_program_is_started_with_count(self) -> None:
        for limit, last, told in ((40, 29, "20 are"), (32, 10, "1 is")):
            words = limited(f'ulimit -n {limit}; for fd in {{10..{last}}}; do eval "exec $fd</dev/null"; done', BUILD / "meniscus", "status")
            done = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 74)
            self.assertRegex(done.stderr, rf"may have {limit}, of which {told} in use already; raise the limit \(`ulimit -n`, LimitNOFILE=\) to \d+ or more")


class Crowds(DaemonTest):
    """More idle connections than places, of other programs on this machine: the user of this machine still gets in, and so does HTTP."""

    LIMIT, CROWD = 256, 400

    @classmethod
    def start_daemon(cls) -> None:
        cls.port, cls.http = free_ports(), free_ports()
        program = cls.home / "limited"
        program.write_text(f'#!/bin/bash\nulimit -n {cls.LIMIT}\nexec {BUILD}/meniscusd "$@"\n')
        program.chmod(0o755)
        cls.options = ["--tcp", str(cls.port), "--http", str(cls.http)]
        cls.daemon = start_in(cls.home, cls.environment, cls.options, program)

    def files(self) -> int:
        return len(os.listdir(f"/proc/{self.daemon.pid}/fd"))

    def assert_open_for_others(self) -> None:
        """Places are used up, and yet all who come now are answered."""
        self.wait_until(lambda: self.files() >= self.LIMIT * 9 // 16)  # of 5/8 for telemetry, some of which are open for a moment alone
        for address in (f"ipc://{control_socket(self.home)}", f"tcp://127.0.0.1:{self.port}"):
            self.wait_until(lambda: subprocess.run([BUILD / "meniscus", "status", "--daemon", address], env=self.environment,
                                                   capture_output=True, timeout=60).returncode == 0)  # fmt: skip
        for _ in range(40):
            self.assertEqual(self.ask("status")["state"], "EMPTY")
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http}/healthz", timeout=20) as page:
            self.assertEqual(page.status, 200)
        self.assertLess(self.files(), self.LIMIT - 16)

    def connect_raw(self, family: socket.AddressFamily, address: "str | tuple[str, int]") -> None:
        for _ in range(self.CROWD):
            guest = socket.socket(family)
            self.addCleanup(guest.close)
            guest.connect(address)

    def test_of_one_process_that_connects_and_says_nothing(self) -> None:
        for _ in range(self.CROWD):
            guest = zmq.Context.instance().socket(zmq.DEALER)
            guest.linger = 0
            self.addCleanup(guest.close)
            guest.connect(f"ipc://{control_socket(self.home)}")
        self.assert_open_for_others()
        self.assertIn(f"process {os.getpid()} has ", (self.home / "log").read_text())
        with self.assertRaisesRegex(meniscus.UnavailableError, "at once: its places for connections are used up"):
            meniscus.Client(f"ipc://{control_socket(self.home)}", timeout=20)  # of the same process

    def test_of_one_process_without_a_handshake(self) -> None:
        self.connect_raw(socket.AF_UNIX, str(control_socket(self.home)))
        self.assert_open_for_others()

    def test_of_one_process_to_telemetry(self) -> None:
        self.connect_raw(socket.AF_UNIX, str(control_socket(self.home).with_name("telemetry.ipc")))
        self.assert_open_for_others()

    def test_over_tcp(self) -> None:
        self.connect_raw(socket.AF_INET, ("127.0.0.1", self.port))
        self.assert_open_for_others()

    def test_over_http(self) -> None:
        self.connect_raw(socket.AF_INET, ("127.0.0.1", self.http))
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http}/healthz", timeout=20) as page:
            self.assertEqual(page.status, 200)
        self.assertEqual(self.ask("status")["state"], "EMPTY")

    def test_of_very_many_processes(self) -> None:
        children = []
        for _ in range(self.CROWD * 3 // 4):
            child = os.fork()
            if not child:
                guest = socket.socket(socket.AF_UNIX)
                guest.connect(str(control_socket(self.home)))
                signal.pause()
            children.append(child)
        try:
            self.assert_open_for_others()
        finally:
            for child in children:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)

    def test_a_handshake_that_does_not_end_is_ended(self) -> None:
        guest = socket.socket(socket.AF_UNIX)
        self.addCleanup(guest.close)
        guest.settimeout(20)  # of the 30 that ZeroMQ would wait
        guest.connect(str(control_socket(self.home)))
        while guest.recv(64):
            pass


class ClosedAtOnce(Alone):
    """What the command line says of a socket where each connection ends at once."""

    def test_it_names_places_that_are_used_up(self) -> None:
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(self.home / "s.ipc"))
            listener.listen()

            def close_all() -> None:
                with contextlib.suppress(OSError):
                    while True:
                        listener.accept()[0].close()

            thread = threading.Thread(target=close_all)
            thread.start()
            done = self.under("true", BUILD / "meniscus", "status", "--daemon", f"ipc://{self.home}/s.ipc", code=69)
            listener.shutdown(socket.SHUT_RDWR)
            thread.join()
        self.assertIn("closes each connection at once: its places for connections are used up", " ".join(done.stderr.split()))
        self.assertNotIn("plain text", done.stderr)


class Orphans(Alone):
    """Process 1 of a container gets the children of all that end there; so does a process that asks for it."""

    def children(self, parent: int) -> "dict[int, tuple[bool, str]]":
        """By their number: whether they are dead, and their command."""
        listed = subprocess.run(["ps", "--ppid", str(parent), "-o", "pid=,stat=,args="], capture_output=True, text=True).stdout
        words = [line.split(None, 2) for line in listed.splitlines()]
        return {int(pid): (state.startswith("Z"), command) for pid, state, command in words}

    def adopt(self, *words: "str | Path", ends: "tuple[int, ...]" = (0, 75)) -> None:
        """Start a program that takes orphans, from a shell that leaves it one at once and one later; end both."""
        later = '(sleep 0.3 & sleep 1000 &) ; sleep 0.1 & exec "$@"'

        def take_orphans() -> None:
            PR_SET_CHILD_SUBREAPER = 36
            ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)

        process = subprocess.Popen(["bash", "-c", later, "bash", *words], env=self.environment, cwd=self.home, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, preexec_fn=take_orphans, start_new_session=True)  # fmt: skip

        def end_all() -> None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

        self.addCleanup(end_all)

        until = time.monotonic() + 60
        left: "list[int]" = []
        while not left:
            self.assertLess(time.monotonic(), until, "dead children stay")
            self.assertIsNone(process.poll())
            time.sleep(0.05)
            children = self.children(process.pid)
            others = [command for dead, command in children.values() if dead or command in ("sleep 0.1", "sleep 0.3")]
            left = [] if others else [pid for pid, (_, command) in children.items() if command == "sleep 1000"]
        os.kill(left[0], signal.SIGKILL)
        while left[0] in self.children(process.pid):
            self.assertLess(time.monotonic(), until, "a dead child stays")
            time.sleep(0.05)
        process.terminate()
        self.assertIn(process.wait(60), ends)

    def test_a_daemon_takes_note_of_their_end(self) -> None:
        self.adopt(BUILD / "meniscusd", "--state-dir", self.home / "s")

    def test_so_does_one_that_has_a_gate(self) -> None:
        self.environment["MENISCUS_KEYS"] = str(self.home / "keys")
        subprocess.run([BUILD / "meniscus", "keys", "new", "eve", "--role", "viewer"], env=self.environment, check=True,
                       stdout=subprocess.DEVNULL)  # fmt: skip
        self.adopt(BUILD / "meniscusd", "--state-dir", self.home / "s", "--listen", f"tcp://127.0.0.1:{free_ports()}")

    def test_so_do_programs_that_look_at_daemons(self) -> None:
        self.adopt(BUILD / "meniscus", "top", "-o", "json", ends=(-signal.SIGTERM,))
        if (BUILD / "meniscus-dashboard").exists():  # which needs more to be built
            self.adopt(BUILD / "meniscus-dashboard", "--http", "0")

    def test_so_does_a_run_without_a_daemon(self) -> None:
        self.adopt(BUILD / "meniscus", "run", *CASE, "--set", "end_time=1000")


if __name__ == "__main__":
    unittest.main()

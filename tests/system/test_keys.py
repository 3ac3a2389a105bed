#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Keys as people use them: made, listed and removed on the command line, used by it, by the C library and by Python."""

import contextlib
import math
import os
import socket
import subprocess
import sys
import threading
import time
import unittest
import urllib.request
from pathlib import Path
from typing import List, Tuple

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, free_ports  # noqa: E402
from exposition import parse  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402

CROWD = 210  # more than get each live message


class Doorway:
    """A way to the daemon that ends the first so many connections in the midst of their handshakes, as a process that dies does."""

    def __init__(self, far: str, cuts: float, then_silent: bool = False) -> None:
        host, port = far.rsplit(":", 1)
        self._there = (host[len("tcp://"):], int(port))
        self._cuts, self._silent = cuts, then_silent
        self._listening = socket.create_server(("127.0.0.1", 0))
        self._open: List[socket.socket] = [self._listening]
        self.address = f"tcp://127.0.0.1:{self._listening.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def __enter__(self) -> str:
        return self.address

    def __exit__(self, *_: object) -> None:
        for each in self._open:
            each.close()

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                guest, _ = self._listening.accept()
                self._open.append(guest)
                if self._cuts > 0:
                    guest.recv(10)
                    guest.close()
                elif not self._silent:
                    there = socket.create_connection(self._there)
                    self._open.append(there)
                    for pair in ((guest, there), (there, guest)):
                        threading.Thread(target=self._carry, args=pair, daemon=True).start()
                self._cuts -= 1

    @staticmethod
    def _carry(source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(1 << 16):
                sink.sendall(data)
            sink.shutdown(socket.SHUT_WR)


class Keys(DaemonTest):
    far: str
    http: int
    keys: Path

    @classmethod
    def start_daemon(cls) -> None:
        cls.keys = cls.home / "keys"
        cls.environment["MENISCUS_KEYS"] = str(cls.keys)
        cls.far = f"tcp://127.0.0.1:{free_ports()}"
        for name, role in (("vera", "viewer"), ("otto", "operator"), ("ada", "admin")):
            subprocess.run([BUILD / "meniscus", "keys", "new", name, "--role", role], env=cls.environment, check=True,
                           stdout=subprocess.DEVNULL)
        cls.http = free_ports()
        cls.options = ["--listen", cls.far, "--http", str(cls.http)]
        super().start_daemon()

    def as_(self, name: str) -> Tuple[str, ...]:
        return ("--daemon", self.far, "--key", str(self.keys / f"{name}.key"))

    def test_a_key_does_what_its_role_may(self) -> None:
        self.assertEqual(self.ask("status", *self.as_("vera"))["state"], "EMPTY")
        refused = self.ask("load", "dambreak2d", *self.as_("otto"), code=77)["error"]
        self.assertEqual(refused["status"], "denied")
        self.assertIn("load takes the role admin", refused["message"])
        self.meniscus("load", "dambreak2d", "--set", "resolution=10", *self.as_("ada"))
        self.assertIn("operator", self.meniscus("start", *self.as_("vera"), code=77).stderr)
        self.meniscus("step", "2", *self.as_("otto"))
        self.meniscus("shutdown", *self.as_("otto"), code=77)
        self.assertEqual(self.ask("status", *self.as_("vera"))["step"], 2)

    def test_keys_are_listed_and_no_secret_among_them(self) -> None:
        listed = self.ask("keys", "list")
        roles = {key["name"]: key["role"] for key in listed["keys"]}
        self.assertEqual({name: roles[name] for name in ("vera", "otto", "ada")},
                         {"vera": "viewer", "otto": "operator", "ada": "admin"})
        text = self.meniscus("keys", "list").stdout + str(listed)
        self.assertIn(listed["server_key"], text)
        for file in self.keys.glob("*.key"):
            self.assertEqual(file.stat().st_mode & 0o7777, 0o600)
            secret = next(line.split()[1] for line in file.read_text().splitlines() if line.startswith("secret-key"))
            self.assertNotIn(secret, text)
        self.assertEqual(self.keys.stat().st_mode & 0o777, 0o700)

    def test_a_key_comes_and_goes_while_the_daemon_runs(self) -> None:
        made = self.ask("keys", "new", "eve", "--role", "viewer")
        self.assertIn("already", self.meniscus("keys", "new", "eve", "--role", "admin", code=1).stderr)
        copy = self.home / "eve.key"
        copy.write_bytes(Path(made["file"]).read_bytes())
        copy.chmod(0o600)
        with meniscus.Client(self.far, timeout=20, key=str(copy)) as client:
            self.assertEqual(client.status().state, "EMPTY")
            self.meniscus("keys", "remove", "eve")
            with self.assertRaises(meniscus.DeniedError):
                for _ in range(100):
                    client.status()
        self.assertFalse(Path(made["file"]).exists())
        self.assertIn("does not let in", self.meniscus("status", "--daemon", self.far, "--key", str(copy), code=77).stderr)
        self.meniscus("keys", "remove", "eve", code=1)

    def test_a_client_that_is_not_removed_goes_on(self) -> None:
        self.meniscus("keys", "new", "gone", "--role", "viewer")
        with meniscus.Client(self.far, timeout=20, key=str(self.keys / "otto.key")) as client:
            client.status()
            self.meniscus("keys", "remove", "gone")
            for _ in range(50):
                self.assertEqual(client.status().state, "EMPTY")

    def metric(self, name: str, **labels: str) -> float:
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http}/metrics", timeout=20) as answer:
            return parse(answer.read().decode())[name].value(**labels)

    def assert_listeners(self, n: int) -> None:
        until = time.monotonic() + 20
        while self.metric("meniscus_telemetry_clients") != n and time.monotonic() < until:
            time.sleep(0.05)
        self.assertEqual(self.metric("meniscus_telemetry_clients"), n)

    def test_a_crowd_that_is_cut_off_holds_up_nobody(self) -> None:
        made = self.ask("keys", "new", "crowd", "--role", "viewer")
        pair = dict(line.split() for line in Path(made["file"]).read_text().splitlines() if len(line.split()) == 2)
        context = zmq.Context()
        self.addCleanup(context.term)
        host, port = self.far.rsplit(":", 1)
        listeners = [context.socket(zmq.SUB) for _ in range(CROWD)]
        for listener in listeners:
            self.addCleanup(listener.close, linger=0)
            listener.curve_publickey, listener.curve_secretkey = pair["public-key"].encode(), pair["secret-key"].encode()
            listener.curve_serverkey = pair["server-key"].encode()
            listener.reconnect_ivl = -1
            listener.subscribe(b"")
            listener.connect(f"{host}:{int(port) + 1}")
        self.assert_listeners(CROWD)
        self.meniscus("load", "dambreak2d", "--set", "resolution=10", "--set", "output.probe_interval=0.0001", "--set", "end_time=1000")
        self.meniscus("step", "100")
        spared = self.metric("meniscus_telemetry_skipped_total", topic="probe")
        self.assertGreater(spared, 50)
        self.meniscus("keys", "remove", "crowd")
        self.assert_listeners(0)
        self.meniscus("step", "100")
        self.assertEqual(self.metric("meniscus_telemetry_skipped_total", topic="probe"), spared)

    def test_python_speaks_with_a_key_and_hears_why_not(self) -> None:
        self.meniscus("load", "dambreak2d", "--set", "resolution=10")
        with meniscus.Client(self.far, timeout=20, key=str(self.keys / "vera.key")) as client:
            messages = client.subscribe("event", timeout=10)
            self.assertEqual(next(messages).state, "READY")
            with self.assertRaises(meniscus.DeniedError) as refused:
                client.start()
            self.assertEqual(refused.exception.status, "denied")
            self.assertIn("operator", str(refused.exception))
        with self.assertRaisesRegex(meniscus.UnavailableError, "takes no plain text"):
            meniscus.Client(self.far, timeout=20)
        other = self.ask("keys", "list")["keys"][0]["public_key"]
        with self.assertRaisesRegex(meniscus.UnavailableError, "does not have the secret"):
            meniscus.Client(self.far, timeout=20, key=str(self.keys / "vera.key"), server_key=other)
        with self.assertRaisesRegex(meniscus.DeniedError, "is no loopback address, so it takes a key"):
            meniscus.Client("tcp://192.0.2.7:5555", timeout=20)

    def test_a_connection_that_is_lost_before_it_stands_is_made_again(self) -> None:
        """Whoever is told that its key is wrong while the gate is started anew goes and makes another."""
        key = str(self.keys / "vera.key")
        with Doorway(self.far, 2) as far, meniscus.Client(far, timeout=20, key=key) as client:
            self.assertEqual(client.status().state, "EMPTY")
        with Doorway(self.far, 2) as far:
            self.assertEqual(self.ask("status", "--daemon", far, "--key", key)["state"], "EMPTY")
        with Doorway(self.far, 1, then_silent=True) as far:
            with self.assertRaisesRegex(meniscus.UnavailableError, "lost before it stood, and trying again"):
                meniscus.Client(far, timeout=20, key=key)
        with Doorway(self.far, 1, then_silent=True) as far:
            lost = self.meniscus("status", "--daemon", far, "--key", key, code=69).stderr
            self.assertIn("lost before it stood, and trying again", lost)
        with Doorway(self.far, math.inf) as far:
            with self.assertRaisesRegex(meniscus.UnavailableError, "does not have the secret"):
                meniscus.Client(far, timeout=20, key=key)
            self.assertIn("does not have the secret", self.meniscus("status", "--daemon", far, "--key", key, code=69).stderr)

    def test_the_environment_names_the_key(self) -> None:
        self.environment["MENISCUS_KEY"] = str(self.keys / "vera.key")
        self.addCleanup(self.environment.pop, "MENISCUS_KEY")
        self.assertEqual(self.ask("status", "--daemon", self.far)["state"], "EMPTY")
        self.assertEqual(self.ask("status")["state"], "EMPTY")  # by name: no key is needed, and none is used
        self.meniscus("status", "--daemon", self.far, "--server-key", "short", code=1)

    def test_a_file_that_others_can_read_is_no_key(self) -> None:
        copy = self.home / "open.key"
        copy.write_bytes((self.keys / "vera.key").read_bytes())
        copy.chmod(0o644)
        for words in (["status"], ["load", "dambreak2d"]):
            lost = self.meniscus(*words, "--daemon", self.far, "--key", "nowhere.key", code=74)
            self.assertTrue(lost.stderr.startswith("meniscus: there is no file of a key"), lost.stderr)
        refused = self.meniscus("status", "--daemon", self.far, "--key", str(copy), code=74)
        self.assertIn("chmod 600", refused.stderr)
        with self.assertRaisesRegex(meniscus.StateError, "chmod 600"):
            meniscus.Client(self.far, key=str(copy))

    def test_a_pipe_is_no_key_and_holds_nothing_up(self) -> None:
        pipe = self.home / "pipe.key"
        os.mkfifo(pipe, 0o600)
        refused = self.meniscus("status", "--daemon", self.far, "--key", str(pipe), code=74, timeout=20)
        self.assertIn("is no file; keys are not read from it", " ".join(refused.stderr.split()))
        script = f"import meniscus; meniscus.Client({self.far!r}, key={str(pipe)!r}, timeout=5)"
        environment = {**self.environment, "PYTHONPATH": str(BUILD / "python")}
        done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, timeout=20)
        self.assertIn("StateError", done.stderr)
        self.assertIn("is no file; keys are not read from it", done.stderr)

    def test_while_others_can_read_the_key_of_the_daemon_nobody_is_let_in(self) -> None:
        own, vera = self.keys / "daemon.key", str(self.keys / "vera.key")
        own.chmod(0o640)
        self.addCleanup(own.chmod, 0o600)
        words = [BUILD / "meniscus", "status", "--daemon", self.far, "--key", vera]
        shut = subprocess.run(words, env=self.environment, capture_output=True, timeout=60)
        self.assertIn(shut.returncode, (69, 77))  # no answer, or a refusal while the gate leaves
        own.chmod(0o600)
        self.assertEqual(self.ask("status", "--daemon", self.far, "--key", vera)["state"], "EMPTY")

    def test_a_daemon_without_keys_does_not_listen(self) -> None:
        environment = self.environment | {"MENISCUS_KEYS": str(self.home / "none")}
        words = [str(BUILD / "meniscusd"), "--name", "none", "--state-dir", str(self.home / "none-state")]
        for more, code, part in ((["--listen", f"tcp://127.0.0.1:{free_ports()}"], 1, "meniscus keys new"),
                                 (["--tcp", "0.0.0.0:5555"], 2, "meniscus keys new"),
                                 (["--keys", "x"], 2, "--listen")):
            done = subprocess.run(words + more, env=environment, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(part, done.stderr)

    def test_wrong_words_are_explained(self) -> None:
        for words in (("keys",), ("keys", "make", "x"), ("keys", "new"), ("keys", "new", "x"), ("keys", "list", "x"),
                      ("keys", "new", "x", "--role", "king"), ("keys", "new", "../x", "--role", "admin"),
                      ("keys", "new", "local", "--role", "admin")):
            self.meniscus(*words, code=2)


if __name__ == "__main__":
    os.environ.pop("MENISCUS_KEY", None)
    unittest.main()

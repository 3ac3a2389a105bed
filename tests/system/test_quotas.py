#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Quotas for each key and role: a viewer who takes all that it can get leaves a place for every other key, for operators and for the user of this machine."""

import re
import secrets
import subprocess
import sys
import time
import unittest
import urllib.request
from pathlib import Path
from typing import Any

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, DaemonTest, control_socket, free_ports, start_in  # noqa: E402
from exposition import parse  # noqa: E402
from streaming import Taker  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import meniscus_pb2 as pb  # noqa: E402
from meniscus import stream_pb2 as sb  # noqa: E402

SMALL = ["dambreak2d", "--set", "resolution=8", "--set", "end_time=1000"]
LARGE = ["dambreak2d", "--set", "resolution=700"]  # takes seconds to place
HEAVY = ["dambreak2d", "--set", "resolution=100"]  # megabytes of positions
PARTICLES = dict(query=pb.Query(particles=pb.ParticleQuery(fields=["position", "velocity", "acceleration"], limit=10_000_000, walls=True)))
ROLES = {"vera": "viewer", "zoe": "viewer", "otto": "operator", "olga": "operator"}
PORT = {"control": 0, "telemetry": 1, "data": 2}


def documented() -> "dict[str, list[int | None]]":
    """The table of proto/README.md: of each viewer, all of them, each operator or admin, all of them, this machine."""
    rows = re.findall(r"^\| `quota ([a-z]+)` \|[^|]*\|(.*)\|$", (ROOT / "proto" / "README.md").read_text(), re.MULTILINE)
    return {name: [int(cell) if cell.strip().isdigit() else None for cell in cells.split("|")] for name, cells in rows}


def documented_limit(limit: str) -> int:
    """One that is the same for each client, as the page has it."""
    found = re.search(rf"^\| {re.escape(limit)} \| (\d+) \|", (ROOT / "proto" / "README.md").read_text(), re.MULTILINE)
    assert found, limit
    return int(found[1])


def in_a_second(of: str) -> int:
    return documented_limit(f"questions in a second while a run takes steps, of {of}")


class Asker:
    """A connection for commands that reads replies when it is asked to."""

    def __init__(self, test: "Far", who: str, ahead: int = 0) -> None:
        """ahead: messages that ZeroMQ takes before we do; 0: any number."""
        self.socket = zmq.Context.instance().socket(zmq.DEALER)
        self.socket.linger, self.socket.rcvhwm = 0, ahead
        test.addCleanup(self.socket.close)
        if who == "local":
            self.socket.connect(f"ipc://{control_socket(test.home)}")
        else:
            test.prove(self.socket, who)
            self.socket.connect(test.address("control"))
        self.replies: "dict[bytes, pb.Reply]" = {}

    def say(self, **command: Any) -> bytes:
        ident = secrets.token_bytes(16)
        self.socket.send(pb.Request(major=1, id=ident, **command).SerializeToString())
        return ident

    def hear(self, seconds: float) -> None:
        """All that comes, until nothing has for so long."""
        while self.socket.poll(int(1000 * seconds)):
            reply = pb.Reply.FromString(self.socket.recv())
            self.replies[reply.id] = reply

    def wait_for(self, ident: bytes) -> "pb.Reply":
        until = time.monotonic() + 30
        while ident not in self.replies and time.monotonic() < until:
            self.hear(0.05)
        return self.replies[ident]

    def ask(self, **command: Any) -> "pb.Reply":
        return self.wait_for(self.say(**command))

    def large(self) -> "tuple[pb.Reply, int]":
        """The reply to a question with large arrays, and their number."""
        self.say(**PARTICLES)
        assert self.socket.poll(30000), "no reply"
        frames = self.socket.recv_multipart()
        return pb.Reply.FromString(frames[0]), len(frames) - 1

    def refused(self) -> "list[pb.Reply]":
        return [reply for reply in self.replies.values() if reply.code == pb.RESOURCE_EXHAUSTED]


class Far(DaemonTest):
    """A daemon for those who have a key."""

    files = 0  # that it may open; 0: as many as we may
    quotas: "list[str]" = []
    far: int
    http: int

    @classmethod
    def start_daemon(cls) -> None:
        cls.environment["MENISCUS_KEYS"] = str(cls.home / "keys")
        cls.far, cls.http = free_ports(), free_ports()
        for name, role in ROLES.items():
            subprocess.run([BUILD / "meniscus", "keys", "new", name, "--role", role], env=cls.environment, check=True,
                           stdout=subprocess.DEVNULL)
        cls.options = ["--listen", f"tcp://127.0.0.1:{cls.far}", "--http", str(cls.http), *cls.quotas]
        program = BUILD / "meniscusd"
        if cls.files:
            program = cls.home / "few"
            program.write_text(f"#!/bin/sh\nulimit -n {cls.files}\nexec {BUILD / 'meniscusd'} \"$@\"\n")
            program.chmod(0o755)
        cls.daemon = start_in(cls.home, cls.environment, cls.options, program)

    def address(self, socket: str) -> str:
        return f"tcp://127.0.0.1:{self.far + PORT[socket]}"

    def pair(self, who: str) -> "dict[str, str]":
        lines = (self.home / "keys" / f"{who}.key").read_text().splitlines()
        return dict(line.split() for line in lines if line and not line.startswith("#"))

    def prove(self, socket: Any, who: str) -> None:
        pair = self.pair(who)
        socket.curve_publickey, socket.curve_secretkey = pair["public-key"].encode(), pair["secret-key"].encode()
        socket.curve_serverkey = pair["server-key"].encode()

    def metric(self, name: str) -> float:
        with urllib.request.urlopen(f"http://127.0.0.1:{self.http}/metrics", timeout=30) as page:
            return parse(page.read().decode())[name].value()


class Quotas(Far):
    def test_the_table_of_the_protocol_is_that_of_the_program(self) -> None:
        source = (ROOT / "server" / "run" / "quota.c").read_text()
        rows = re.findall(r"\[QUOTA_(\w+)\] *=.*?\{\{(.*)\}\}\}", source)
        there = {name.lower(): [int(n) if n.isdigit() else None for n in re.findall(r"\d+|NO_BOUND", row)] for name, row in rows}
        for row in there.values():
            row[4:] = row[4:5]  # this machine has one share
        self.assertGreaterEqual(len(there), 8)
        self.assertEqual(documented(), there)

    def test_waits_of_one_viewer_turn_out_its_own_alone(self) -> None:
        never = dict(wait=pb.Wait(states=[pb.DONE]))
        others = [Asker(self, who) for who in ("zoe", "otto", "local")]
        waits = [other.say(**never) for other in others]
        time.sleep(0.3)
        vera = Asker(self, "vera")
        for k in range(1100):
            vera.say(**never)
            if k % 32 == 31:
                vera.hear(0.02)
        vera.hear(0.5)
        self.assertEqual(len(vera.refused()), 1100 - documented()["waits"][0])
        self.assertTrue(any('the key "vera" has 128 waits' in reply.message for reply in vera.refused()), vera.refused()[-1])
        for other in others:
            other.hear(0.05)
            self.assertEqual(other.replies, {}, "a wait of another was turned out")
        self.meniscus("load", *SMALL)
        self.meniscus("set", "end_time=0.001")
        self.meniscus("start")
        for other, ident in zip(others, waits):
            self.assertEqual(other.wait_for(ident).code, pb.OK)

    def test_streams_of_one_viewer_leave_room_for_others(self) -> None:
        self.meniscus("load", *SMALL)
        most, counts = documented()["streams"][0], []
        takers = [Taker(self.address("data"), self.pair("vera")) for _ in range(2)]
        for taker in takers:
            self.addCleanup(taker.close)
            replies = [taker.ask(subscribe=sb.Subscribe(probes=sb.ProbeStream())) for _ in range(most * 5 // 8)]
            counts.append(sum(reply.code == pb.OK for reply in replies))
        self.assertEqual(sum(counts), most)
        self.assertIn('the key "vera" has 256 streams', replies[-1].message)
        for who in ("zoe", "otto"):
            taker = Taker(self.address("data"), self.pair(who))
            self.addCleanup(taker.close)
            taker.subscribe(probes=sb.ProbeStream())

    def test_commands_that_one_viewer_queues_leave_room_for_others(self) -> None:
        most = documented()["questions"][0]
        askers = {who: Asker(self, who) for who in ("vera", "zoe", "otto", "local")}
        for asker in askers.values():
            asker.ask(status=pb.GetStatus())
        with subprocess.Popen([BUILD / "meniscus", "load", *LARGE], env=self.environment, stderr=subprocess.DEVNULL) as load:
            self.wait_until(lambda: self.ask("status")["state"] == "LOADING")
            for _ in range(most + 30):
                askers["vera"].say(query=pb.Query())
            askers["vera"].hear(0.3)
            self.assertEqual(len(askers["vera"].refused()), 30)
            for who in ("zoe", "otto", "local"):
                for _ in range(10):
                    askers[who].say(query=pb.Query())
                askers[who].hear(0.1)
                self.assertEqual(askers[who].replies.keys() - set(list(askers[who].replies)[:1]), set(), f"{who} was refused")
            self.assertEqual(self.ask("status")["state"], "LOADING")
            askers["otto"].say(stop=pb.Stop())
            self.assertNotEqual(load.wait(60), 0)

    def test_scheduled_commands_of_one_operator_leave_room_for_others(self) -> None:
        self.meniscus("load", *SMALL)
        each, both = documented()["scheduled"][2:4]

        def accepted(who: str, n: int) -> int:
            asker = Asker(self, who)
            replies = [asker.ask(pause=pb.Pause(), at_step=1000 + k, no_wait=True) for k in range(n)]
            return sum(reply.code == pb.OK for reply in replies)

        self.assertEqual([accepted(who, 70) for who in ("otto", "olga")], [each, both - each])
        self.assertEqual(accepted("local", 3), 3)

    def test_replies_that_one_viewer_does_not_read_leave_room_for_others(self) -> None:
        self.meniscus("load", *HEAVY)
        most = documented()["unread"][0]
        assert most
        others = [Asker(self, who) for who in ("zoe", "otto", "local")]
        one = others[-1].large()
        self.assertEqual(one[0].code, pb.OK)
        size = sum(array.shape[0] * array.shape[1] * 8 for array in one[0].arrays)
        self.assertGreater(size, 4 << 20)
        for who, says in (("vera", "replies that are not read, and one key has no more"), ("local", r"this connection has \d+ MiB of replies")):
            deaf = [Asker(self, who, ahead=1) for _ in range(2 if who == "vera" else 1)]
            for asker in deaf:
                for _ in range(((most << 20) // len(deaf) + (64 << 20)) // size):
                    asker.say(**PARTICLES)
            self.wait_until(lambda: self.metric("meniscus_control_unread_bytes") >= most << 20)
            for other in others:
                reply, n = other.large()
                self.assertEqual((reply.code, n), (pb.OK, one[1]), reply.message)
            refused = self.refusals(deaf)
            self.assertTrue(any(re.search(says, text) for text in refused), refused)
            self.wait_until(lambda: self.metric("meniscus_control_unread_bytes") == 0)

    @staticmethod
    def refusals(askers: "list[Asker]") -> "list[str]":
        """What is said in replies that were not read before."""
        texts = []
        for asker in askers:
            while asker.socket.poll(1000):
                texts.append(pb.Reply.FromString(asker.socket.recv_multipart()[0]).message)
        return texts

    def test_connections_of_one_viewer_leave_room_for_others(self) -> None:
        most = documented()["control"][0]
        askers = [Asker(self, "vera") for _ in range(most + 20)]
        idents = [asker.say(status=pb.GetStatus()) for asker in askers]

        def answered() -> int:
            for asker in askers:
                asker.hear(0.002)
            return sum(ident in asker.replies for asker, ident in zip(askers, idents))

        before = self.metric("meniscus_access_shown_out_total")
        self.wait_until(lambda: answered() == len(askers))
        refused = [reply.message for asker in askers for reply in asker.refused()]
        self.assertEqual(set(refused), {f'the key "vera" has {most} connections for commands, and one key has no more; close one'})
        self.assertEqual(len(refused), 20)
        self.wait_until(lambda: self.metric("meniscus_access_shown_out_total") >= before + 20)
        key = str(self.home / "keys" / "vera.key")
        told = self.meniscus("status", "--daemon", self.address("control"), "--key", key, code=1).stderr
        self.assertIn("connections for commands, and one key has no more; close one", " ".join(told.split()))
        with self.assertRaisesRegex(meniscus.MeniscusError, "connections for commands, and one key has no more; close one"):
            meniscus.Client(self.address("control"), timeout=20, key=key)
        for who in ("zoe", "otto"):
            self.assertEqual(Asker(self, who).ask(status=pb.GetStatus()).code, pb.OK)

    def listener(self, who: str, topics: "list[bytes]") -> Any:
        listener = zmq.Context.instance().socket(zmq.SUB)
        listener.linger, listener.reconnect_ivl = 0, -1
        self.addCleanup(listener.close)
        self.prove(listener, who)
        listener.connect(self.address("telemetry"))
        for topic in topics:
            listener.subscribe(topic)
        return listener

    def test_subscriptions_of_one_viewer_have_an_end(self) -> None:
        most, before = documented()["telemetry"][0], self.metric("meniscus_access_shown_out_total")
        for _ in range(most + 30):
            self.listener("vera", [b"event"])
        self.wait_until(lambda: self.metric("meniscus_telemetry_clients") >= most)
        self.wait_until(lambda: self.metric("meniscus_access_shown_out_total") >= before + 30)
        self.wait_until(lambda: self.metric("meniscus_telemetry_clients") == most)
        self.listener("otto", [b"event"])
        self.wait_until(lambda: self.metric("meniscus_telemetry_clients") == most + 1)
        greedy = self.listener("zoe", [b"%d" % k for k in range(70)])
        modest = self.listener("zoe", [b"event"])
        self.wait_until(lambda: self.metric("meniscus_telemetry_clients") == most + 2)
        greedy.close()
        self.meniscus("load", *SMALL)
        self.assertTrue(modest.poll(20000))


class Pace(Far):
    """Questions without end while a run takes steps."""

    def setUp(self) -> None:
        self.meniscus("load", *HEAVY, "--set", "end_time=1000")
        self.meniscus("start")

    def test_one_question_after_the_other_is_heard_so_often_in_a_second(self) -> None:
        for who, of in (("vera", "viewers"), ("otto", "operators and admins with a key"), ("local", "this machine")):
            most, asker = in_a_second(of), Asker(self, who)
            asker.ask(status=pb.GetStatus())
            begun, n = time.monotonic(), 0
            while time.monotonic() < begun + 2:
                reply = asker.ask(status=pb.GetStatus()) if n % 2 else asker.ask(query=pb.Query(probes=pb.ProbeQuery()))
                self.assertEqual(reply.code, pb.OK)
                n += 1
            self.assertLessEqual(n, 2.5 * most)  # a quarter of a second's at once, and the clock's doubt

    def test_all_that_is_asked_at_once_is_answered_in_order_before_a_command(self) -> None:
        asker = Asker(self, "otto")
        idents = [asker.say(status=pb.GetStatus()) for _ in range(100)]
        idents += [asker.say(set=pb.Set(assignments=[pb.Assignment(path="end_time", value="900")]))]
        asker.wait_for(idents[-1])
        self.assertEqual(list(asker.replies), idents)
        self.assertEqual({reply.code for reply in asker.replies.values()}, {pb.OK})

    def test_a_flood_keeps_no_other_waiting_and_is_answered(self) -> None:
        for who, others in (("vera", ("zoe", "otto", "local")), ("local", ("local", "vera"))):
            flood, n = Asker(self, who), 3000
            askers = [Asker(self, other) for other in others]
            for asker in (flood, *askers):
                asker.ask(status=pb.GetStatus())
            for _ in range(n):
                flood.say(status=pb.GetStatus())
            for asker in askers:
                began = time.monotonic()
                self.assertEqual(asker.ask(status=pb.GetStatus()).code, pb.OK)
                self.assertLess(time.monotonic() - began, 2)
            began = time.monotonic()
            self.assertEqual(Asker(self, "otto").ask(lease=pb.Lease(ttl_ms=1000, holder="otto")).code, pb.OK)
            self.assertLess(time.monotonic() - began, 2)
            self.meniscus("pause")
            self.wait_until(lambda: flood.hear(0.1) or len(flood.replies) == n + 1)
            codes = [reply.code for reply in flood.replies.values()]
            self.assertGreater(codes.count(pb.OK), 1024)
            self.assertEqual(codes.count(pb.OK) + codes.count(pb.RESOURCE_EXHAUSTED), n + 1)
            time.sleep(1)  # the lease ends
            self.meniscus("resume")

    def test_a_connection_may_end_while_its_questions_wait(self) -> None:
        """At any moment between two heartbeats."""
        for k in range(6):
            for connect, frame in ((lambda: Asker(self, "local").socket, pb.Request(major=1, status=pb.GetStatus())),
                                   (lambda: Taker(f"ipc://{control_socket(self.home).with_name('data.ipc')}").socket, sb.StreamRequest(major=1, cancel=sb.CancelItem(stream=1)))):
                socket = connect()
                socket.sndtimeo = 20000
                for _ in range(3000):
                    frame.id = secrets.token_bytes(16)
                    socket.send(frame.SerializeToString())
                time.sleep(0.4 * k)
                socket.close(linger=0)
        time.sleep(3)
        self.assertIsNone(self.daemon.poll())
        self.assertEqual(Asker(self, "local").ask(status=pb.GetStatus()).code, pb.OK)

    def test_a_question_that_waits_is_answered_at_its_deadline(self) -> None:
        asker = Asker(self, "vera")
        idents = [asker.say(status=pb.GetStatus()) for _ in range(80)]
        late = asker.say(status=pb.GetStatus(), deadline_ms=50)
        asker.hear(2)
        self.assertLess(list(asker.replies).index(late), len(idents) - 20)

    def test_streams_that_come_and_go_have_a_pace(self) -> None:
        taker = Taker(self.address("data"), self.pair("vera"))
        self.addCleanup(taker.close)
        begun, n = time.monotonic(), 0
        while time.monotonic() < begun + 2:
            stream = taker.subscribe(probes=sb.ProbeStream()).stream
            taker.ask(unsubscribe=sb.Unsubscribe(stream=stream))
            n += 2
        self.assertLessEqual(n, 2.5 * in_a_second("viewers"))

    def test_what_is_refused_counts_as_a_question(self) -> None:
        asker, n = Asker(self, "vera"), 0
        asker.ask(status=pb.GetStatus())
        until = time.monotonic() + 2
        while time.monotonic() < until:
            self.assertEqual(asker.ask(pause=pb.Pause()).code, pb.PERMISSION_DENIED)
            n += 1
        self.assertLessEqual(n, 2.5 * in_a_second("viewers"))


class Chosen(Far):
    """With quotas of the command line."""

    quotas = ["--quota", "streams=3,5", "--quota", "control=2", "--quota", "waits=1,2", "--quota", "data=2"]

    def test_the_command_line_says_how_much_a_key_may_hold(self) -> None:
        self.meniscus("load", *SMALL)
        for who, most in (("vera", 3), ("otto", 5)):
            taker = Taker(self.address("data"), self.pair(who))
            self.addCleanup(taker.close)
            codes = [taker.ask(subscribe=sb.Subscribe(probes=sb.ProbeStream())).code for _ in range(7)]
            self.assertEqual(codes.count(pb.OK), most)
        askers = [Asker(self, "vera") for _ in range(4)]
        for asker in askers:
            asker.say(status=pb.GetStatus())
        for asker in askers:
            asker.hear(0.5)
        self.assertEqual([len(asker.refused()) for asker in askers].count(0), 2)
        takers = [Taker(self.address("data"), self.pair("zoe")) for _ in range(3)]
        replies = [taker.ask(subscribe=sb.Subscribe(probes=sb.ProbeStream())) for taker in takers]
        self.assertEqual([reply.code for reply in replies], [pb.OK, pb.OK, pb.RESOURCE_EXHAUSTED])
        self.assertIn('the key "zoe" has 2 connections for streams, and one key has no more', replies[-1].message)
        for taker in takers:
            taker.close()

    def test_what_cannot_be_meant_is_refused_with_what_can(self) -> None:
        for text, says in (("x=1", "the names are control, telemetry"), ("streams", "as in streams=64,128"), ("streams=", "as in"),
                           ("streams=1,", "as in"), ("streams=1,2,3", "as in"), ("streams=-1", "as in"),
                           ("streams=1025", "each key has 0 to 1024"), ("scheduled=1", "each key has 0 to 0"),
                           ("commands=99999999999999999999", "found \"commands=99999999999999999999\"")):
            done = subprocess.run([BUILD / "meniscusd", "--name", "other", "--quota", text], env=self.environment, capture_output=True, text=True,
                                  timeout=60)
            self.assertEqual(done.returncode, 2, text)
            self.assertIn(says, " ".join(done.stderr.split()))


class FewFiles(Far):
    """Where a process may open 1024 files."""

    files = 1024

    def test_connections_that_say_nothing_have_an_end(self) -> None:
        for _ in range(300):
            socket = zmq.Context.instance().socket(zmq.DEALER)
            socket.linger, socket.reconnect_ivl = 0, -1
            self.addCleanup(socket.close)
            self.prove(socket, "vera")
            socket.connect(self.address("control"))
        self.wait_until(lambda: self.metric("meniscus_access_shown_out_total") >= 200)
        self.assertEqual(Asker(self, "otto").ask(status=pb.GetStatus()).code, pb.OK)


if __name__ == "__main__":
    unittest.main()

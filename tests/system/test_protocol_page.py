#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""What proto/README.md says of limits and of single cases is so."""

import re
import secrets
import subprocess
import sys
import time
import unittest
from pathlib import Path
from typing import Any

import zmq
from google.protobuf import json_format

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, SMALL, DaemonTest, control_socket, free_ports, start_in  # noqa: E402
from streaming import Taker, sb  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import meniscus_pb2 as pb  # noqa: E402

PAGE = (ROOT / "proto" / "README.md").read_text()

# Where the program has each limit: a file, and what stands before the number there.
SOURCES = {
    "bytes of a request": ("common/wire/frame.h", r"FRAME_MAX = "),
    "bytes of a request for streams": ("common/wire/frame.h", r"FRAME_STREAM = "),
    "bytes of a request that is refused by a reply": ("common/wire/frame.h", r"FRAME_TAKEN = "),
    "the same, from afar": ("common/wire/frame.h", r"FRAME_TAKEN_FAR = "),
    "the same of a request for streams, from afar": ("common/wire/frame.h", r"FRAME_STREAM_FAR = "),
    "bytes of a subscription to telemetry": ("server/net/gate_keeper.c", r"SUBSCRIPTION = "),
    "subscriptions of one connection from afar": ("server/net/gate_keeper.c", r"SUBSCRIPTIONS_EACH = "),
    "bytes that a client from afar sends without the end of a message": ("server/net/links.c", r"ENDLESS = "),
    "bytes of commands from afar that the daemon has not taken, of one connection": ("server/net/relay.c", r"UPWARD_MOST = "),
    "entries of a `get` or `set`": ("server/net/here.h", r"ENTRIES_MAX = "),
    "coordinates of the points of a `query`": ("server/net/look.h", r"LOOK_COORDINATES = "),
    "particles of a `query`, unless it says `limit`": ("proto/meniscus.proto", r"limit = 4 \[default = "),
    "bytes of the arrays of a `query`": ("server/net/look.h", r"LOOK_BYTES = "),
    "commands of one connection that wait and write a file": ("server/run/mailbox.h", r"MAILBOX_FILES = "),
    "questions in a second while a run takes steps, of viewers": ("server/net/pace.h", r"PACE_VIEWERS = "),
    "questions in a second while a run takes steps, of operators and admins with a key": ("server/net/pace.h", r"PACE_STEERERS = "),
    "questions in a second while a run takes steps, of this machine": ("server/net/pace.h", r"PACE_LOCAL = "),
    "questions of one connection that wait while a run takes steps": ("server/net/pace.h", r"PACE_EACH = "),
    "their bytes": ("server/net/pace.h", r"PACE_EACH_BYTES = "),
    "questions of a pool that wait while a run takes steps": ("server/net/pace.h", r"PACE_POOL = "),
    "their bytes together": ("server/net/pace.h", r"PACE_POOL_BYTES = "),
    "requests in a second that are read while a run takes steps": ("server/net/pace.h", r"PACE_READ = "),
    "connections that wait for one reply": ("server/net/exchange.h", r"EXCHANGE_SENDERS = "),
    "breakpoints": ("server/run/breakpoint.h", r"BREAKPOINTS = "),
    "replies remembered, of what changed something": ("server/net/ledger.h", r"LEDGER_DEEDS = "),
    "replies remembered, of questions, and as many refusals": ("server/net/ledger.h", r"LEDGER_OTHERS = "),
    "seconds that a refusal is remembered": ("server/net/answers.c", r"REFUSED_S = "),
    "versions of the case": ("server/run/versions.h", r"VERSIONS_KEPT = "),
    "bytes of replies that one connection has not read": ("server/net/outgoing.h", r"OUTGOING_UNREAD = "),
    "fields of a stream": ("server/net/subscribe.h", r"STREAM_FIELDS_MAX = "),
    "bytes of a chunk": ("server/net/subscribe.h", r"STREAM_CHUNK = "),
    "bytes of credit": ("server/net/subscription.h", r"CREDIT_MOST = "),
    "streams of one connection": ("server/net/streams_inside.h", r"STREAMS_EACH = "),
    "seconds that a stream is kept without its connection": ("server/net/stream_pump.c", r"GONE_FOR = "),
    "seconds between two heartbeats": ("server/net/stream_pump.c", r"HEARTBEAT = "),
    "seconds of silence after which a client has lost its connection": ("tests/support/page_client.py", r"SILENCE = "),
    "MiB for streams, `--stream-memory`": ("server/main.c", r"in MiB \("),
    "seconds of a handshake, at socket files and `--tcp`": ("server/net/access.c", r"HANDSHAKE_LOCAL_S = "),
    "seconds of a handshake from afar": ("server/net/access.c", r"HANDSHAKE_S = "),
    "connections over HTTP": ("server/http/guests.h", r"GUESTS = "),
}


TAKEN = "bytes of a request that is refused by a reply"


def documented(limit: str) -> int:
    """The number that the page has for a limit."""
    found = re.search(rf"^\| {re.escape(limit)} \| (\d+) \|", PAGE, re.MULTILINE)
    assert found, limit
    return int(found[1])


def number_in(file: str, before: str) -> int:
    found = re.search(before + r"(?:\(uint64_t\))?(?:UINT64_C\()?(\d+)\)?(?: << (\d+))?", (ROOT / file).read_text())
    assert found, f"{file} does not have {before}"
    return int(found[1]) << int(found[2] or 0)


class Limits(unittest.TestCase):
    def test_the_table_has_the_limits_of_the_program_and_no_other(self) -> None:
        _, _, section = PAGE.partition("All others are the same for each client:\n")
        section, _, _ = section.partition("\n## ")
        table = {name: int(number) for name, number in re.findall(r"^\| ([^|]+) \| (\d+) \|", section, re.MULTILINE)}
        self.assertEqual(table, {name: number_in(*where) for name, where in SOURCES.items()})


class Sentences(DaemonTest):
    def setUp(self) -> None:
        self.control = zmq.Context.instance().socket(zmq.DEALER)
        self.control.linger = 0
        self.addCleanup(self.control.close)
        self.control.connect(f"ipc://{control_socket(self.home)}")

    def give(self, **command: Any) -> "pb.Reply":
        self.control.send(pb.Request(major=1, id=secrets.token_bytes(16), **command).SerializeToString())
        self.assertTrue(self.control.poll(30000), "no reply")
        return pb.Reply.FromString(self.control.recv_multipart()[0])

    def test_a_load_into_a_name_that_is_there_makes_another_directory(self) -> None:
        for directory in ("twice", "twice.2", "twice.3"):
            self.assertEqual(Path(self.ask("load", *SMALL, "--name", "twice")["path"]).name, directory)

    def test_a_query_takes_as_many_points_as_fit_into_a_request(self) -> None:
        self.meniscus("load", *SMALL)
        found = re.search(r"(\d+),000 points in the plane", PAGE)
        assert found
        n = 1000 * int(found[1])
        reply = self.give(query=pb.Query(points=pb.PointQuery(field="pressure", points=[0.1] * (2 * n))))
        self.assertEqual((reply.code, list(reply.arrays[0].shape)), (pb.OK, [n]))

    def padded(self, size: int, **command: Any) -> bytes:
        """A request of that size, by a text that is too long for everything."""
        bare = pb.Request(major=1, id=b"0123456789abcdef", **command)
        room = size - len(bare.SerializeToString()) - 16
        request = pb.Request(major=1, id=b"0123456789abcdef", load=pb.Load(name="x" * room))
        return bytes(request.SerializeToString())

    def test_a_request_that_is_too_long_is_answered(self) -> None:
        """Up to the length that the page names; one that is longer ends its connection, and no other."""
        for size in (documented("bytes of a request") + 100, 4 << 20, 24 << 20, documented(TAKEN) - 100):
            self.control.send(self.padded(size))
            self.assertTrue(self.control.poll(30000), f"no reply to {size} bytes")
            reply = pb.Reply.FromString(self.control.recv())
            self.assertEqual((reply.code, reply.id), (pb.RESOURCE_EXHAUSTED, b"0123456789abcdef"))
            self.assertRegex(reply.message, r"a request may have 1048576 bytes, this one has \d+; send it in parts")
        reply = self.give(query=pb.Query(points=pb.PointQuery(field="pressure", points=[0.1] * 3_000_000)))
        self.assertEqual(reply.code, pb.RESOURCE_EXHAUSTED)
        self.control.send(bytes(documented(TAKEN) + 1))
        self.assertFalse(self.control.poll(2000))
        self.assertEqual(self.ask("status")["state"], "EMPTY")

    def test_a_request_for_streams_that_is_too_long_is_answered(self) -> None:
        most = documented("bytes of a request for streams")
        taker = Taker(f"ipc://{control_socket(self.home).with_name('data.ipc')}")
        self.addCleanup(taker.close)
        for size in (most, 1 << 20, 8 << 20):
            reply = taker.ask(subscribe=sb.Subscribe(fields=sb.FieldStream(fields=[sb.FieldWish(name="x" * size)])))
            self.assertEqual(reply.code, pb.RESOURCE_EXHAUSTED)
            self.assertIn(f"may have {most} bytes", reply.message)

    def test_clients_do_not_send_what_is_too_long(self) -> None:
        long = "x" * 100_000
        words = [f"{name}={long}" for name in "abcdefghijkl"]
        self.assertIn("bytes, a daemon takes 1048576; send it in parts", self.meniscus("set", *words, code=1).stderr)
        with meniscus.Client(f"ipc://{control_socket(self.home)}", timeout=20) as client:
            with self.assertRaisesRegex(meniscus.MeniscusError, "bytes, a daemon takes 1048576; send it in parts"):
                client.set({word[0]: long for word in words})
            with self.assertRaisesRegex(meniscus.MeniscusError, "bytes, a daemon takes 65536; ask for fewer"):
                with client.stream("fields", long) as stream:
                    next(iter(stream))
        self.assertIn("bytes, a daemon takes 65536; send it in parts", self.meniscus("stream", "fields", long, code=1).stderr)

    def test_an_item_without_bytes_takes_credit_for_its_frame(self) -> None:
        self.meniscus("load", *SMALL)
        taker = Taker(f"ipc://{control_socket(self.home).with_name('data.ipc')}")
        self.addCleanup(taker.close)
        stream = taker.subscribe(events=sb.EventStream(), credit=0).stream
        self.meniscus("step", "1")
        self.assertTrue(taker.quiet(0.3))
        taker.grant(stream, 1000)
        first = taker.item().head
        self.assertEqual((first.size, first.HasField("event")), (0, True))
        spent = taker.received
        self.assertGreater(spent, 0)
        for k in range(1000 // spent + 2):
            self.meniscus("step", "1")
        while not taker.quiet(0.3):
            taker.item()
        self.assertLessEqual(taker.received, 1000)
        taker.grant(stream, 1000)
        self.assertFalse(taker.quiet(5))

    def test_after_a_crash_the_state_is_empty_then_recovering_and_then_what_it_was(self) -> None:
        self.meniscus("load", *SMALL)
        self.meniscus("step", "300")
        self.daemon.kill()
        self.daemon.wait()
        type(self).daemon = start_in(self.home, self.environment, self.options)
        seen = []
        until = time.monotonic() + 60
        while (not seen or seen[-1] != "PAUSED") and time.monotonic() < until:
            state = pb.State.Name(self.give(status=pb.GetStatus()).state)
            if state not in seen:
                seen.append(state)
        order = ["EMPTY", "RECOVERING", "PAUSED"]
        self.assertEqual(seen, [state for state in order if state in seen])

    def test_the_json_of_protobuf_has_other_names(self) -> None:
        self.meniscus("load", *SMALL)
        told = json_format.MessageToDict(self.give(status=pb.GetStatus()))
        self.assertIn("caseVersion", told)
        self.assertIsInstance(told["daemonEpoch"], str)
        self.assertEqual(json_format.ParseDict({"case_version": 3}, pb.Reply()).case_version, 3)
        self.assertIn("case_version", self.ask("status"))


class Afar(DaemonTest):
    @classmethod
    def start_daemon(cls) -> None:
        cls.environment["MENISCUS_KEYS"] = str(cls.home / "keys")
        cls.far = f"tcp://127.0.0.1:{free_ports()}"
        for name in ("vera", "zoe"):
            subprocess.run([BUILD / "meniscus", "keys", "new", name, "--role", "viewer"], env=cls.environment, check=True, stdout=subprocess.DEVNULL)
        cls.options = ["--listen", cls.far]
        super().start_daemon()

    def pair(self, name: str) -> "dict[str, str]":
        lines = (self.home / "keys" / f"{name}.key").read_text().splitlines()
        return dict(line.split() for line in lines if line and not line.startswith("#"))

    def test_a_request_for_streams_that_is_too_long_is_answered(self) -> None:
        address, _, port = self.far.rpartition(":")
        taker = Taker(f"{address}:{int(port) + 2}", self.pair("zoe"))
        self.addCleanup(taker.close)
        room = documented("the same of a request for streams, from afar") - 1000
        reply = taker.ask(subscribe=sb.Subscribe(fields=sb.FieldStream(fields=[sb.FieldWish(name="x" * room)])))
        self.assertEqual(reply.code, pb.RESOURCE_EXHAUSTED)

    def test_a_dealer_whose_key_was_removed_blocks_in_send(self) -> None:
        pair = self.pair("vera")
        dealer = zmq.Context.instance().socket(zmq.DEALER)
        self.addCleanup(dealer.close)
        dealer.linger, dealer.sndtimeo = 0, 500
        dealer.curve_publickey, dealer.curve_secretkey = pair["public-key"].encode(), pair["secret-key"].encode()
        dealer.curve_serverkey = pair["server-key"].encode()
        dealer.connect(self.far)
        request = pb.Request(major=1, id=b"0123456789abcdef", status=pb.GetStatus()).SerializeToString()
        dealer.send(request)
        self.assertTrue(dealer.poll(20000))
        self.meniscus("keys", "remove", "vera")

        def blocks() -> bool:
            try:
                dealer.send(request)
            except zmq.Again:
                return True
            return False

        self.wait_until(blocks)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Frames that earlier versions of this major version sent (tests/recorded): today's daemon answers their requests so that they can read it, today's
clients read their replies, and no number of their schema has got another meaning."""

import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any, Callable, Iterator

import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, start_in, surroundings  # noqa: E402
from recorded import VERSIONS, Protocol, Recorded  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import case_pb2, meniscus_pb2, packing, packing_pb2, stream_pb2  # noqa: E402
from meniscus.values import read_telemetry  # noqa: E402

TODAY = (case_pb2, meniscus_pb2, packing_pb2, stream_pb2)
FLEETING = {"steps_per_second", "eta_s", "ns_per_particle_step"}  # said when they are known


def said(message: Any, path: str = "") -> Iterator[str]:
    """The names of all that a message says."""
    for field, value in message.ListFields():
        if field.name in FLEETING:
            continue
        yield path + field.name
        if field.type == field.TYPE_MESSAGE:
            for part in value if field.label == field.LABEL_REPEATED else [value]:
                yield from said(part, f"{path}{field.name}.")


class Schema(unittest.TestCase):
    """What a number stood for, it stands for today, or it is reserved: it is never given to anything else."""

    def today(self) -> "tuple[dict[str, Any], dict[str, Any]]":
        messages, enums = {}, {}

        def enter(path: str, message: Any) -> None:
            messages[path] = message
            enums.update({f"{path}.{enum.name}": enum for enum in message.enum_type})
            for nested in message.nested_type:
                enter(f"{path}.{nested.name}", nested)

        for module in TODAY:
            file = Protocol.describe(module.DESCRIPTOR)
            enums.update({f".meniscus.{enum.name}": enum for enum in file.enum_type})
            for message in file.message_type:
                enter(f".meniscus.{message.name}", message)
        return messages, enums

    def compare(self, path: str, old: Any, messages: "dict[str, Any]") -> None:
        self.assertIn(path, messages)
        now = {field.number: field for field in messages[path].field}
        reserved = [number for span in messages[path].reserved_range for number in range(span.start, span.end)]
        for field in old.field:
            with self.subTest(field=f"{path}.{field.name} = {field.number}"):
                if field.number not in now:
                    self.assertIn(field.number, reserved)
                    continue
                same = now[field.number]
                self.assertEqual((field.type, field.label, field.type_name), (same.type, same.label, same.type_name))
                self.assertEqual(field.HasField("oneof_index"), same.HasField("oneof_index"))
        for nested in old.nested_type:
            self.compare(f"{path}.{nested.name}", nested, messages)

    def test_no_number_has_got_another_meaning(self) -> None:
        messages, enums = self.today()
        for version in VERSIONS:
            for file in Recorded(version).protocol.files.file:
                for message in file.message_type:
                    self.compare(f".meniscus.{message.name}", message, messages)
                for enum in file.enum_type:
                    now = {value.number: value.name for value in enums[f".meniscus.{enum.name}"].value}
                    for value in enum.value:
                        self.assertEqual(now.get(value.number), value.name, f"{version}: {enum.name}")


class Daemon(unittest.TestCase):
    """Today's daemon and what older clients send. They read its replies by the schema they have."""

    def with_daemon(self, version: str, run: "Callable[[Recorded, Path, zmq.Context[Any]], None]") -> None:
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch, zmq.Context() as context:
            home = Path(scratch)
            daemon = start_in(home, surroundings(home), [])
            try:
                run(Recorded(version), home / "run" / "meniscus" / "default", context)
            finally:
                daemon.kill()
                daemon.wait()
                context.destroy(0)

    def ask(self, socket: "zmq.Socket[bytes]", request: bytes) -> "list[bytes]":
        socket.send(request)
        self.assertTrue(socket.poll(20000), "no reply")
        return socket.recv_multipart()

    def dialogue(self, recorded: Recorded, sockets: Path, context: "zmq.Context[Any]") -> None:
        protocol, epoch = recorded.protocol, 0
        with context.socket(zmq.DEALER) as control:
            control.connect(f"ipc://{sockets}/control.ipc")
            for name, request, reply in recorded.commands():
                asked, then = protocol.read("Request", request), protocol.read("Reply", reply)
                if epoch and asked.lease_epoch:  # of a lease that today's daemon has given
                    asked.lease_epoch = epoch
                    request = asked.SerializeToString()
                now = protocol.read("Reply", self.ask(control, request)[0])
                epoch = now.lease.epoch if name == "lease" and now.lease.epoch else epoch
                with self.subTest(version=recorded.path.name, request=str(asked)):
                    self.assertEqual((now.id, now.code, now.state), (then.id, then.code, then.state), now.message)
                    aside = {"message"} if not then.code else set()  # a sentence for people
                    self.assertEqual(set(said(then)) - set(said(now)) - aside, set())

    def streams(self, recorded: Recorded, sockets: Path, context: "zmq.Context[Any]") -> None:
        protocol = recorded.protocol
        with context.socket(zmq.DEALER) as control, context.socket(zmq.DEALER) as data:
            control.connect(f"ipc://{sockets}/control.ipc")
            data.connect(f"ipc://{sockets}/data.ipc")
            first = {name: request for name, request, _ in reversed(list(recorded.commands()))}
            for name in ("load", "step", "snapshot"):
                self.assertEqual(protocol.read("Reply", self.ask(control, first[name])[0]).code, 0)
            for name, request, answer, item, _ in recorded.streams():
                with self.subTest(version=recorded.path.name, stream=name):
                    then = protocol.read("StreamMessage", answer).reply
                    now = protocol.read("StreamMessage", self.ask(data, request)[0]).reply
                    self.assertEqual((now.code, list(now.columns)), (0, list(then.columns)), now.message)
                    self.assertEqual(set(said(then)) - set(said(now)), set())
                    self.assert_item(protocol, data, now.stream, protocol.read("StreamMessage", item).item)

    def assert_item(self, protocol: Protocol, data: "zmq.Socket[bytes]", stream: int, then: Any) -> None:
        """The first piece of the first item of a stream says what it said then. Probes have none while the run stands still."""
        while data.poll(3000):
            frames = data.recv_multipart()
            item = protocol.read("StreamMessage", frames[0]).item
            if item.stream == stream and len(frames) == 2:
                self.assertEqual({name for name in said(then) if name[:4] not in ("next", "arra")} - set(said(item)), set())
                self.assertEqual([a.name for a in item.arrays], [a.name for a in then.arrays])
                return
        self.fail("no item came")

    def test_recorded_requests_are_answered_as_they_were(self) -> None:
        for version in VERSIONS:
            self.with_daemon(version, self.dialogue)

    def test_recorded_subscriptions_are_answered_as_they_were(self) -> None:
        for version in VERSIONS:
            if Recorded(version).protocol.has("StreamRequest"):
                self.with_daemon(version, self.streams)


def kind_of(request: Any) -> str:
    kind = str(request.WhichOneof("command"))
    return f"query {request.query.WhichOneof('what')}" if kind == "query" else kind


class Replayed(threading.Thread):
    """Answers each command with the last reply to one of its kind that was recorded, one with a result if there is any, a refused one if refused. The
    bytes are the same but for the id."""

    def __init__(self, recorded: Recorded, context: "zmq.Context[Any]", path: str, refused: bool) -> None:
        super().__init__(daemon=True)
        self.known: "dict[str, tuple[bytes, bytes, list[bytes]]]" = {}
        ranks: "dict[str, tuple[bool, bool]]" = {}
        for path_of in sorted(recorded.path.glob("*.request")):
            packed = path_of.with_suffix(".reply").read_bytes()
            kind, reply = kind_of(recorded.protocol.read("Request", path_of.read_bytes())), recorded.protocol.read("Reply", packed)
            rank = bool(reply.code and refused), bool(reply.WhichOneof("result"))
            if (not reply.code or refused) and rank >= ranks.get(kind, rank):
                ranks[kind] = rank
                self.known[kind] = packed, reply.id, [array.read_bytes() for array in sorted(recorded.path.glob(f"{path_of.stem}.array*"))]
        self.over = False
        self.socket = context.socket(zmq.ROUTER)
        self.socket.bind(f"ipc://{path}")

    def run(self) -> None:
        while not self.over:
            if not self.socket.poll(50):
                continue
            sender, packed = self.socket.recv_multipart()
            request = meniscus_pb2.Request.FromString(packed)
            reply, before, frames = self.known[kind_of(request)]
            self.socket.send_multipart([sender, reply.replace(b"\n\x10" + before, b"\n\x10" + request.id, 1), *frames])
        self.socket.close(0)


class Clients(unittest.TestCase):
    """Today's clients and what older daemons send."""

    def with_daemon(self, version: str, refused: bool, run: "Callable[[str], None]", change: "Callable[[Replayed], None]" = lambda _: None) -> None:
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch, zmq.Context() as context:
            path = f"{scratch}/control.ipc"
            replayed = Replayed(Recorded(version), context, path, refused)
            change(replayed)
            replayed.start()
            try:
                with self.subTest(version=version):
                    run(f"ipc://{path}")
            finally:
                replayed.over = True
                replayed.join()

    def test_the_python_client_reads_recorded_replies(self) -> None:
        def talk(endpoint: str) -> None:
            with meniscus.Client(endpoint, timeout=20) as client:
                self.assertEqual((client.status().state, client.status().case_name), ("RUNNING", "recorded"))
                self.assertIn("run_until", client.capabilities().commands)
                self.assertEqual(client.get("gravity")["gravity"].value, "[0, -1]")
                self.assertGreater(client.query("energy")["energy"].value, 0)
                self.assertEqual(client.points("pressure", [0.5, 0.25]).shape, (1,))
                self.assertEqual(client.particles(["velocity"])["velocity"].shape[1], 2)
                self.assertEqual((client.step(3).state, client.run_until(0.0625).time), ("PAUSED", 0.0625))
                self.assertTrue(str(client.checkpoint().path).endswith(".hdf") and str(client.snapshot().path).endswith(".hdf"))
                for command in (client.pause, client.resume, client.reset, client.restore, client.stop):
                    command()

        for version in VERSIONS:
            self.with_daemon(version, False, talk)

    def test_the_python_client_reads_recorded_refusals(self) -> None:
        def talk(endpoint: str) -> None:
            with meniscus.Client(endpoint, timeout=20) as client:
                for command, code in ((client.start, "FAILED_PRECONDITION"), (lambda: client.query("none"), "NOT_FOUND"),
                                      (lambda: client.cancel(bytes(16)), "NOT_FOUND"), (lambda: client.set({"gravity": "[7]"}), "INVALID_ARGUMENT")):
                    with self.assertRaises(meniscus.MeniscusError) as refusal:
                        command()
                    self.assertEqual(refusal.exception.code, code)
                    self.assertTrue(str(refusal.exception))

        for version in VERSIONS:
            self.with_daemon(version, True, talk)

    def test_a_code_of_a_later_version_is_a_failure(self) -> None:
        """Protobuf reads it as absent, and what is absent as OK. It stands behind the id."""
        def later(replayed: Replayed) -> None:
            packed, before, frames = replayed.known["step"]
            self.assertEqual(packed[18:20], b"\x10\0")
            replayed.known["step"] = packed[:18] + b"\x10\x63" + packed[20:], before, frames

        def talk(endpoint: str) -> None:
            with meniscus.Client(endpoint, timeout=20) as client, self.assertRaises(meniscus.MeniscusError) as refusal:
                client.step()
            self.assertEqual(refusal.exception.code, "UNKNOWN")
            done = subprocess.run([BUILD / "meniscus", "--daemon", endpoint, "step"], capture_output=True, text=True, timeout=60)
            self.assertNotEqual(done.returncode, 0)

        self.with_daemon(VERSIONS[-1], False, talk, later)

    def test_the_command_line_reads_recorded_replies(self) -> None:
        def talk(endpoint: str) -> None:
            for words, wanted in ((["status"], "RUNNING"), (["get", "gravity"], "[0, -1]"), (["step", "3"], "PAUSED"), (["checkpoint"], ".hdf"),
                                  (["pause"], "PAUSED"), (["query", "probes", "energy"], "energy")):
                done = subprocess.run([BUILD / "meniscus", "--daemon", endpoint, *words], capture_output=True, text=True, timeout=60)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(wanted, done.stdout + done.stderr)

        for version in VERSIONS:
            self.with_daemon(version, False, talk)

    def test_recorded_telemetry_is_read(self) -> None:
        for version in VERSIONS:
            recorded = Recorded(version)
            for path in sorted(recorded.path.glob("*.telemetry")):
                with self.subTest(version=version, topic=path.stem):
                    message = meniscus_pb2.Telemetry.FromString(path.read_bytes())
                    self.assertEqual(list(said(message)), list(said(recorded.protocol.read("Telemetry", path.read_bytes()))))
                    self.assertEqual(read_telemetry(path.stem, message, 0).topic, path.stem)

    def test_recorded_items_are_unpacked(self) -> None:
        for version in VERSIONS:
            for name, _, answer, item, data in Recorded(version).streams():
                with self.subTest(version=version, stream=name):
                    columns = stream_pb2.StreamMessage.FromString(answer).reply.columns
                    first, at = stream_pb2.StreamMessage.FromString(item).item, 0
                    self.assertEqual(len(data), first.size if first.arrays else min(first.size, 262144))
                    for array in first.arrays:
                        values = packing.unpack(array, data[at : at + array.packed_bytes], 1 << 20)
                        self.assertTrue(values.size)
                        at += array.packed_bytes
                    self.assertEqual(bool(columns), name != "snapshots")


if __name__ == "__main__":
    unittest.main()

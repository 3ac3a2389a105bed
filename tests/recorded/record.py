#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Record a dialogue with a daemon of some version: record.py SOURCES DIRECTORY

SOURCES is a tree of that version, built; DIRECTORY gets the schema, the frames byte for byte, and all of them as text in dialogue.txt. Commands that the
version does not have are left out.
"""

import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import zmq
from google.protobuf import text_format

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import start_in, surroundings  # noqa: E402
from recorded import Protocol  # noqa: E402

CASE = """
dimensions: 2 resolution: 6 domain { min: [0, 0] max: [2, 1] } gravity: ["0", "-1"] end_time: 1000 threads: 1
fluids { name: "water" density: 1000 sound_speed: 20 shape { box { min: [0, 0] max: [1, 0.5] } } }
fluids { name: "air" density: 1 sound_speed: 20 }
walls { name: "tank" shape { outside: true box { min: [0, 0] max: [2, 1] } } }
probes { name: "front" front { fluid: "water" } } probes { name: "energy" kinetic_energy {} }
"""

# Each is sent when the one before was answered. EPOCH: of the lease given last.
COMMANDS = [
    "capabilities {}", "status {}", "start {}", f'load {{ case {{ {CASE} }} name: "recorded" }}', "status {}", 'get { paths: "gravity" paths: "end_time" }',
    'set { assignments { path: "gravity" value: "[0, -2]" } }', 'set { assignments { path: "gravity" value: "[7]" } }', "rollback { version: 1 }",
    'breakpoint { name: "late" step: 1000 }', 'breakpoint { name: "late" remove: true }', "step { count: 3 }", "run_until { time: 0.0625 }",
    'query { probes { names: "energy" } }', 'query { points { field: "pressure" points: [0.5, 0.25] } }',
    'query { particles { min: [0, 0] max: [0.5, 0.25] fields: "velocity" } }', 'query { probes { names: "none" } }', "wait { step: 1 }", "checkpoint {}",
    "snapshot {}", "resume {}", "status {}", "pause {}", "restore {}", 'cancel { id: "0123456789abcdef" }', "reset {}",
    'lease { ttl_ms: 60000 holder: "anna" }', 'lease_epoch: EPOCH set { assignments { path: "gravity" value: "[0, -3]" } }',
    "lease_epoch: EPOCH lease { release: true }", "at_step: 2 no_wait: true checkpoint {}", "if_step: 7 step {}", "start {}", "pause {}", "stop {}",
    "shutdown {}",
]

STREAMS = [
    ("fields", 'fields { fields { name: "position" } fields { name: "pressure" exactness { bound: 0.5 } } } when { first: true } codec: CODEC_LZ4'),
    ("probes", "probes {}"),
    ("series", "probes {} delivery: LOSSLESS"),
    ("snapshots", "snapshots {}"),
]


class Recorder:
    """Sends, and keeps what goes either way."""

    def __init__(self, protocol: Protocol, home: Path, target: Path) -> None:
        self.protocol, self.target = protocol, target
        self.context = zmq.Context()
        self.control, self.data = self.context.socket(zmq.DEALER), self.context.socket(zmq.DEALER)
        self.control.connect(f"ipc://{home}/run/meniscus/default/control.ipc")
        self.data.connect(f"ipc://{home}/run/meniscus/default/data.ipc")
        self.telemetry = self.context.socket(zmq.SUB)
        self.telemetry.connect(f"ipc://{home}/run/meniscus/default/telemetry.ipc")
        self.telemetry.subscribe(b"")
        self.words: list[str] = []
        self.n = self.epoch = 0
        self.asked: dict[int, str] = {}
        self.opened: dict[int, str] = {}

    def keep(self, name: str, kind: str, data: bytes) -> Any:
        message = self.protocol.read(kind, data)
        (self.target / name).write_bytes(data)
        self.words += [f"# {name}: {kind}", text_format.MessageToString(message)]
        return message

    def command(self, text: str) -> None:
        request = self.protocol.new("Request")
        words = text.split(" {")[0].split()
        if any(word.rstrip(":") not in request.DESCRIPTOR.fields_by_name for word in words if word.endswith(":") or word == words[-1]):
            return
        self.n += 1
        text_format.Parse(f"major: 1 {text.replace('EPOCH', str(self.epoch))}", request)
        request.id = struct.pack("<QQ", self.n, 0)
        if "minor" in request.DESCRIPTOR.fields_by_name:  # as the clients of that time did
            request.minor, request.session = 0, b"recorded"
        name, packed = words[-1], request.SerializeToString()
        self.keep(f"{self.n:02}-{name}.request", "Request", packed)
        self.control.send(packed)
        if not self.control.poll(20000):
            raise SystemExit(f"no reply to {text}")
        frames = self.control.recv_multipart()
        reply = self.keep(f"{self.n:02}-{name}.reply", "Reply", frames[0])
        for k, array in enumerate(frames[1:]):
            (self.target / f"{self.n:02}-{name}.array{k}").write_bytes(array)
        if name == "lease" and reply.lease.epoch:
            self.epoch = reply.lease.epoch

    def subscribe(self) -> None:
        """Before the first step; their items come with it, and when the run stands still."""
        for name, text in STREAMS:
            request = self.protocol.new("StreamRequest")
            text_format.Parse(f"major: 1 subscribe {{ {text} credit: 8388608 }}", request)
            self.n += 1
            request.id = struct.pack("<QQ", self.n, 1)
            packed = request.SerializeToString()
            self.keep(f"{self.n:02}-{name}.subscribe", "StreamRequest", packed)
            self.data.send(packed)
            self.asked[self.n] = f"{self.n:02}-{name}"

    def listen(self, seconds: float) -> None:
        """Keep the answer and the first message of the first item of each stream."""
        until = time.monotonic() + seconds
        while time.monotonic() < until and self.data.poll(200):
            frames = self.data.recv_multipart()
            message = self.protocol.read("StreamMessage", frames[0])
            if message.HasField("reply"):
                name = self.asked[struct.unpack("<QQ", message.reply.id)[0]]
                self.opened[message.reply.stream] = name
                self.keep(f"{name}.answer", "StreamMessage", frames[0])
            elif message.item.stream in self.opened and len(frames) == 2:
                name = self.opened.pop(message.item.stream)
                self.keep(f"{name}.item", "StreamMessage", frames[0])
                (self.target / f"{name}.bytes").write_bytes(frames[1])

    def hear(self) -> None:
        """Keep the first of each topic."""
        while self.telemetry.poll(500):
            topic, data = self.telemetry.recv_multipart()
            if not (self.target / f"{topic.decode()}.telemetry").exists():
                self.keep(f"{topic.decode()}.telemetry", "Telemetry", data)


def main() -> None:
    sources, target = Path(sys.argv[1]), Path(sys.argv[2])
    target.mkdir(parents=True)
    files = [name for name in ("case", "meniscus", "packing", "stream") if (sources / "proto" / f"{name}.proto").exists()]
    subprocess.run(["protoc", f"-I{sources}/proto", f"--descriptor_set_out={target}/protocol.desc", *(f"{name}.proto" for name in files)], check=True)
    with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
        home = Path(scratch)
        daemon = start_in(home, surroundings(home), [], sources / "build" / "meniscusd")
        recorder = Recorder(Protocol(target / "protocol.desc"), home, target)
        for text in COMMANDS:
            if recorder.protocol.has("StreamRequest") and text.startswith("step"):
                recorder.subscribe()
            recorder.command(text)
            if text.startswith(("step", "snapshot")):
                recorder.listen(5)
        recorder.hear()
        daemon.wait(timeout=20)
        recorder.context.destroy(0)
    (target / "dialogue.txt").write_text("\n".join(recorder.words).replace(str(home), "/home"))


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: BSD-3-Clause
"""Frames of earlier versions of the protocol, as they went over the sockets, with the schema of their time: tests/recorded has a directory for each."""

from pathlib import Path
from typing import Any, Iterator

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

HERE = Path(__file__).resolve().parents[1] / "recorded"
VERSIONS = sorted(path.parent.name for path in HERE.glob("*/protocol.desc"))


class Protocol:
    """The messages of a schema, as `protoc --descriptor_set_out` has written it down."""

    def __init__(self, path: Path) -> None:
        self.files = descriptor_pb2.FileDescriptorSet.FromString(path.read_bytes())
        pool = descriptor_pool.DescriptorPool()
        for file in self.files.file:
            pool.Add(file)
        self._pool, self._factory = pool, message_factory.MessageFactory(pool)

    @staticmethod
    def describe(file: Any) -> Any:
        """What a file of generated messages was made of."""
        described = descriptor_pb2.FileDescriptorProto()
        file.CopyToProto(described)
        return described

    def has(self, name: str) -> bool:
        return any(name == message.name for file in self.files.file for message in file.message_type)

    def new(self, name: str) -> Any:
        return self._factory.GetPrototype(self._pool.FindMessageTypeByName(f"meniscus.{name}"))()

    def read(self, name: str, data: bytes) -> Any:
        message = self.new(name)
        message.ParseFromString(data)
        return message


class Recorded:
    """What was said in one version: NN-command.request and .reply; NN-what.subscribe, .answer, .item and .bytes; topic.telemetry."""

    def __init__(self, version: str) -> None:
        self.path = HERE / version
        self.protocol = Protocol(self.path / "protocol.desc")

    def commands(self) -> Iterator[tuple[str, bytes, bytes]]:
        """In the order in which they were sent: name, request, reply."""
        for path in sorted(self.path.glob("*.request")):
            yield path.stem[3:], path.read_bytes(), path.with_suffix(".reply").read_bytes()

    def streams(self) -> Iterator[tuple[str, bytes, bytes, bytes, bytes]]:
        """Name, request, answer, and an item with its bytes."""
        for path in sorted(self.path.glob("*.subscribe")):
            yield path.stem[3:], path.read_bytes(), *(path.with_suffix(end).read_bytes() for end in (".answer", ".item", ".bytes"))  # type: ignore[misc]

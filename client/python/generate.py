# SPDX-License-Identifier: BSD-3-Clause
"""Make the Python modules of the protocol: generate.py PROTO_DIRECTORY PACKAGE_DIRECTORY

Runs protoc, then turns the imports between the modules, and the modules' own names, into those within the package: protoc knows no
packages but those of the directory layout, and the .proto files lie flat.
"""

import pathlib
import re
import subprocess
import sys

SOURCES = ("case.proto", "meniscus.proto", "journal.proto", "packing.proto", "stream.proto")


def generate(proto: pathlib.Path, package: pathlib.Path) -> None:
    """Write NAME_pb2.py of each of them, with its .pyi, into the package directory."""
    package.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        ["protoc", f"-I{proto}", f"--python_out={package}", f"--pyi_out={package}", *SOURCES], check=True
    )
    for name in (source.replace(".proto", f"_pb2.{kind}") for source in SOURCES for kind in ("py", "pyi")):
        module = package / name
        text = re.sub(r"^import (case|meniscus|packing)_pb2 as", r"from . import \1_pb2 as", module.read_text(), flags=re.MULTILINE)
        # Messages are pickled by the name of their module.
        text = re.sub(r"(BuildTopDescriptorsAndMessages\(DESCRIPTOR, )'\w+'", r"\1__name__", text)
        module.write_text(text)


if __name__ == "__main__":
    generate(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))

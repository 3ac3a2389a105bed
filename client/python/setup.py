# SPDX-License-Identifier: BSD-3-Clause
"""Build the package: the only step that pyproject.toml cannot say is the generation of the protocol's modules."""

import pathlib
import sys

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from generate import generate  # noqa: E402


class BuildWithProtocol(build_py):
    """Copy the modules, then add the generated ones."""

    def run(self) -> None:
        super().run()
        generate(HERE.parent.parent / "proto", pathlib.Path(self.build_lib) / "meniscus")


setup(cmdclass={"build_py": BuildWithProtocol})

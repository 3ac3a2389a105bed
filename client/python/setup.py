# SPDX-License-Identifier: BSD-3-Clause
"""Build the package: what pyproject.toml cannot say is that the protocol's modules are generated, and where the cases are."""

import pathlib
import shutil
import sys

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from generate import generate  # noqa: E402


class BuildWithProtocol(build_py):
    """Copy the modules, then add the generated ones and the cases that come with Meniscus."""

    def run(self) -> None:
        super().run()
        root, package = HERE.parent.parent, pathlib.Path(self.build_lib) / "meniscus"
        generate(root / "proto", package)
        (package / "cases").mkdir(exist_ok=True)
        for case in (root / "server/cases").glob("*.yaml"):
            shutil.copy(case, package / "cases")


setup(cmdclass={"build_py": BuildWithProtocol})

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""The example notebooks of the Python client do what they say, cell by cell, with a real daemon."""

import os
import sys
import unittest
from pathlib import Path

import nbformat
from jupyter_client import KernelManager
from nbclient import NotebookClient

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, DaemonTest  # noqa: E402

PATHS = os.pathsep.join([str(BUILD / "python"), *filter(None, [os.environ.get("PYTHONPATH")])])
NOTEBOOKS = sorted((ROOT / "client/python/examples").glob("*.ipynb"))


class Notebooks(DaemonTest):
    """One kernel for all of them, as it takes longer to start than they do. Each begins with an empty namespace."""

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.kernel = KernelManager(kernel_name="python3")
        environment = cls.environment | {"PYTHONPATH": PATHS, "IPYTHONDIR": str(cls.home / "ipython")}
        cls.kernel.start_kernel(cwd=str(cls.home), env=environment)
        cls.addClassCleanup(lambda: cls.kernel.shutdown_kernel(now=True))

    def execute(self, name: str) -> list:
        """All outputs of a notebook. A cell that raises ends the test with what it raised."""
        notebook = nbformat.read(ROOT / "client/python/examples" / name, as_version=4)
        notebook.cells.insert(0, nbformat.v4.new_code_cell("%reset -f"))
        NotebookClient(notebook, km=self.kernel, timeout=60).execute()
        return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]

    def test_steer(self) -> None:
        outputs = self.execute("steer.ipynb")
        pictures = [output for output in outputs if "image/png" in output.get("data", {})]
        self.assertEqual(len(pictures), 1)  # which grew in place
        self.assertTrue(any("dam break" in output.get("data", {}).get("text/html", "") for output in outputs))

    def test_results(self) -> None:
        outputs = self.execute("results.ipynb")
        self.assertEqual(sum("image/png" in output.get("data", {}) for output in outputs), 1)

    def test_asynchronous(self) -> None:
        texts = [output.get("text", "") for output in self.execute("asynchronous.ipynb")]
        self.assertIn("PAUSED\n", texts)

    def test_every_notebook_is_executed_here_and_kept_without_outputs(self) -> None:
        self.assertEqual({f"test_{file.stem}" for file in NOTEBOOKS} - set(dir(self)), set())
        for file in NOTEBOOKS:
            notebook = nbformat.read(file, as_version=4)
            nbformat.validate(notebook)
            for cell in notebook.cells:
                self.assertFalse(cell.get("outputs") or cell.get("execution_count"), file)


if __name__ == "__main__":
    unittest.main()

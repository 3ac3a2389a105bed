# SPDX-License-Identifier: BSD-3-Clause
"""Runs of cases that a script makes."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from validation.runs import BUILD, DIVERGED, Run, replace, run_file


def written(name: str, case: dict) -> Path:
    """Where the file of this case is."""
    path = BUILD / "validate" / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    replace(path, json.dumps(case, indent=1))  # which is YAML too
    return path


def made(name: str, case: dict) -> Run | None:
    """Of a case that is written here; None if it diverges."""
    try:
        return run_file(written(name, case), name)
    except subprocess.CalledProcessError as error:
        if error.returncode != DIVERGED:
            raise
        return None

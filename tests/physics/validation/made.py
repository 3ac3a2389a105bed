# SPDX-License-Identifier: BSD-3-Clause
"""Runs of cases that a script makes."""

from __future__ import annotations

import json
import subprocess

from validation.runs import BUILD, DIVERGED, Run, replace, run_file


def made(name: str, case: dict) -> Run | None:
    """Of a case that is written here; None if it diverges."""
    path = BUILD / "validate" / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    replace(path, json.dumps(case, indent=1))  # which is YAML too
    try:
        return run_file(path, name)
    except subprocess.CalledProcessError as error:
        if error.returncode != DIVERGED:
            raise
        return None

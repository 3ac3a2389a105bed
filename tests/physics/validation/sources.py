# SPDX-License-Identifier: BSD-3-Clause
"""What of this package, and of the references, decides what a function makes: its own source, and that of all that it names."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path

from validation.series import REFERENCE

PACKAGE = Path(__file__).parent
APART = ("jobs",)  # how many runs go at once, which changes no bit of them
DEFINED = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)

Place = tuple[str, str]  # a module of this package, and a name at its top


def bound(statement: ast.stmt) -> list[str]:
    """The names at the top of a module that a statement gives a meaning to. One that gives none may change any that it mentions."""
    if isinstance(statement, DEFINED):
        return [statement.name]
    if isinstance(statement, (ast.Import, ast.ImportFrom)):
        return [(alias.asname or alias.name).split(".")[0] for alias in statement.names]
    names = [node for node in ast.walk(statement) if isinstance(node, ast.Name)]
    if isinstance(statement, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
        if stored := [name.id for name in names if isinstance(name.ctx, ast.Store)]:
            return stored
    return [name.id for name in names]


@functools.cache
def top(module: str) -> dict[str, list[ast.stmt]]:
    """The statements of a module, by the names that they are about."""
    about: dict[str, list[ast.stmt]] = {}
    for statement in ast.parse((PACKAGE / f"{module}.py").read_text(encoding="utf-8")).body:
        for name in dict.fromkeys(bound(statement)):
            about.setdefault(name, []).append(statement)
    return about


def imported(statement: ast.Import | ast.ImportFrom, name: str) -> tuple[str, set[Place]]:
    """What a name is that a statement imports, in a word; and where it is told, if that is in this package: in all of it, if it is a module."""
    meant = next(alias.name for alias in statement.names if name == (alias.asname or alias.name).split(".")[0])
    module = statement.module or "" if isinstance(statement, ast.ImportFrom) else ""
    if module == "validation":
        return f"{name} is {meant}", set() if meant in APART else {(meant, one) for one in top(meant)}
    if module.startswith("validation."):
        return f"{name} is {module}.{meant}", {(module.removeprefix("validation."), meant)}
    return f"{name} is {module}.{meant}", set()


def told(node: object) -> object:
    """A piece of source without layout, comments and docstrings, the same for all versions of Python that can read it."""
    if isinstance(node, list):
        return [told(one) for one in node]
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = dict(ast.iter_fields(node))
    if isinstance(node, DEFINED) and ast.get_docstring(node, clean=False) is not None:
        fields["body"] = fields["body"][1:]
    return [type(node).__name__, *([name, told(value)] for name, value in fields.items() if value is not None and value != [])]


def files(node: ast.AST) -> Iterator[Path]:
    """References that a string names; one that is put together names all that it could be."""
    parts: list[ast.AST] = [*node.values] if isinstance(node, ast.JoinedStr) else [node]
    pattern = "".join(part.value if isinstance(part, ast.Constant) else "*" for part in parts if isinstance(getattr(part, "value", None), (str, ast.AST)))
    folder, slash, _ = pattern.partition("/")
    if slash and folder.isalnum() and (REFERENCE / folder).is_dir():
        yield from (path for path in REFERENCE.glob(pattern) if path.is_file())


@functools.cache
def piece(statement: ast.stmt) -> tuple[str, frozenset[str], frozenset[Path]]:
    """What a statement says, the names in it, and the references."""
    nodes = list(ast.walk(statement))
    references = (path for node in nodes if isinstance(node, (ast.Constant, ast.JoinedStr)) for path in files(node))
    return repr(told(statement)), frozenset(node.id for node in nodes if isinstance(node, ast.Name)), frozenset(references)


def reached(start: Place) -> tuple[set[str], set[Path]]:
    """What decides a name: what is said of it and of all that it needs, and the references that are named there."""
    said: set[str] = set()
    references: set[Path] = set()
    seen, ahead = {start}, [start]
    while ahead:
        module, name = ahead.pop()
        for statement in top(module).get(name, []):
            if isinstance(statement, (ast.Import, ast.ImportFrom)):
                words, places = imported(statement, name)
            else:
                words, names, paths = piece(statement)
                places = {(module, one) for one in names}
                references |= paths
            said.add(f"{module}: {words}")
            ahead += (fresh := places - seen)
            seen |= fresh
    return said, references


def digest(function: Callable) -> str:
    """Of the source of all that a function of this package needs, and of the references named there."""
    said, references = reached((function.__module__.removeprefix("validation."), function.__name__))
    sha = hashlib.sha256("\n".join(sorted(said)).encode())
    for path in sorted(references):
        sha.update(path.read_bytes())
    return sha.hexdigest()

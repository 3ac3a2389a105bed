# SPDX-License-Identifier: BSD-3-Clause
"""Case files as messages, by walking the protocol's descriptors: no entry is named here.

Each entry's place in the file is kept, so that a complaint of the daemon can name line and column.
"""

from __future__ import annotations

import difflib
import io
import json
import os
import re
from pathlib import Path
from typing import Any, Dict, Iterable, Mapping, Optional, Union

import numpy as np
import yaml
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from . import case_pb2
from .errors import CaseError

OVERRIDE = "override "
CaseSource = Union[str, Path, Mapping[str, Any]]
_INTEGERS = {FieldDescriptor.CPPTYPE_INT32, FieldDescriptor.CPPTYPE_UINT32, FieldDescriptor.CPPTYPE_INT64,
             FieldDescriptor.CPPTYPE_UINT64}


def find(case: Union[str, Path]) -> Path:
    """A case file by path, or by name in $MENISCUS_CASES, beside the build this package is in, or where cases are installed."""
    path = Path(case)
    if path.is_file():
        return path
    here = Path(__file__).resolve().parents  # BUILD/python/meniscus/case.py, with BUILD inside the checkout
    folders = [Path(os.environ.get("MENISCUS_CASES", ".")), here[3] / "server/cases",
               Path("/usr/local/share/meniscus/cases"), Path("/usr/share/meniscus/cases")]
    for folder in folders:
        if (folder / f"{case}.yaml").is_file():
            return folder / f"{case}.yaml"
    looked = ", ".join(str(folder) for folder in folders)
    raise CaseError("NOT_FOUND", f'there is no file "{case}" and no case of that name in {looked}')


def name_of(path: Path) -> str:
    """The name of a case from its path, by the rule of proto/case_name.c: what a name may not have becomes an underscore."""
    name = re.sub(rb"[^A-Za-z0-9._-]", b"_", os.fsencode(path.stem))[:100].decode("ascii")
    return re.sub(r"^[.-]", "_", name)


def as_yaml(value: Any) -> str:
    """A value as after --set on the command line, in one line; numbers and arrays may be numpy's. Text is taken to be that already."""
    return value if isinstance(value, str) else _flow(value)


def _flow(value: Any) -> str:
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_flow(key)}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    if isinstance(value, str):
        return value if re.fullmatch(r"[\w.+-]+", value) else json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value + 0)  # of an enumeration, its number
    raise CaseError("INVALID_ARGUMENT", f"{value!r:.80} is no value of a case: allowed are numbers, text, truth values, lists and mappings of them")


class CaseText:
    """A case as text, with the places of its entries."""

    def __init__(self, case: CaseSource) -> None:
        """case: a path, a name, or a mapping that has the shape of a case file."""
        if isinstance(case, Mapping):
            self.name, self.file = "case", "case"
            text = as_yaml(case)
        else:
            path = find(case)
            self.name, self.file = name_of(path), str(path)
            text = path.read_text(encoding="utf-8")
        self._root = self._compose(text, self.file)
        self._places: Dict[str, str] = {}
        self.settings: Dict[str, str] = {}  # what was overridden, as YAML

    def _compose(self, text: str, name: str) -> yaml.Node:
        """Read YAML; the name goes into the marks of its nodes."""
        stream = io.StringIO(text)
        stream.name = name
        compose: Any = yaml.compose  # which has types on some machines, untyped there, and none on others
        try:
            node: Optional[yaml.Node] = compose(stream, Loader=yaml.BaseLoader)
        except yaml.MarkedYAMLError as error:
            where = _place(error.problem_mark) if error.problem_mark else name
            raise CaseError("INVALID_ARGUMENT", f"{where}: {error.problem}") from None
        if node is None:
            raise CaseError("INVALID_ARGUMENT", f"{name}: there is nothing in it")
        return node

    def set(self, path: str, value: Any) -> None:
        """Override an entry: set("fluids[1].density", 2). Text is read as YAML."""
        text = as_yaml(value)
        new = self._compose(text, OVERRIDE + path)
        node = self._root
        words = re.findall(r"[^.\[\]]+", path)
        for k, word in enumerate(words):
            last = k == len(words) - 1
            node = _descend(node, word, new, last, path)
        self.settings[path] = text

    def message(self) -> case_pb2.Case:
        """The case as a message. CaseError names what does not belong there."""
        message = case_pb2.Case()
        self._places = {}
        self._read_message(self._root, message, "")
        return message

    @staticmethod
    def has(path: str) -> bool:
        """Is it an entry of cases?"""
        return re.split(r"[.\[]", path)[0] in case_pb2.Case.DESCRIPTOR.fields_by_name

    def locate(self, path: str) -> str:
        """FILE:LINE:COLUMN of an entry, or of the nearest entry around it."""
        while path and path not in self._places:
            path = re.sub(r"(^|\.?)[^.\[]+$|\[\d+\]$", "", path)
        return self._places.get(path, self.file)

    def _fail(self, node: yaml.Node, path: str, text: str) -> CaseError:
        place = _place(node.start_mark)
        return CaseError("INVALID_ARGUMENT", f"{place}: {path or 'the case'}: {text}", path)

    def _read_message(self, node: yaml.Node, message: Message, path: str) -> None:
        if not isinstance(node, yaml.MappingNode):
            raise self._fail(node, path, "entries with names are expected here")
        for key, value in node.value:
            field = message.DESCRIPTOR.fields_by_name.get(key.value)
            inner = f"{path}.{key.value}" if path else key.value
            if field is None:
                raise self._fail(key, inner, f'unknown entry "{key.value}", ' + _suggest(key.value, message.DESCRIPTOR.fields_by_name))
            self._places[inner] = _place(value.start_mark)
            self._read_field(value, message, field, inner)

    def _read_field(self, node: yaml.Node, message: Message, field: FieldDescriptor, path: str) -> None:
        if field.label == FieldDescriptor.LABEL_REPEATED:
            if not isinstance(node, yaml.SequenceNode):
                raise self._fail(node, path, "a list is expected here")
            for k, item in enumerate(node.value):
                self._places[f"{path}[{k}]"] = _place(item.start_mark)
                if field.message_type:
                    self._read_message(item, getattr(message, field.name).add(), f"{path}[{k}]")
                else:
                    getattr(message, field.name).append(self._read_scalar(item, field, f"{path}[{k}]"))
        elif field.message_type:
            getattr(message, field.name).SetInParent()
            self._read_message(node, getattr(message, field.name), path)
        else:
            setattr(message, field.name, self._read_scalar(node, field, path))

    def _read_scalar(self, node: yaml.Node, field: FieldDescriptor, path: str) -> Any:
        if not isinstance(node, yaml.ScalarNode):
            raise self._fail(node, path, "a single value is expected here")
        value = _scalar(node.value, field)
        if value is None:
            raise self._fail(node, path, f'"{node.value}" is not {_wanted(field)}')
        return value


def _suggest(wrong: str, names: Iterable[str]) -> str:
    near = difflib.get_close_matches(wrong, names, 1)
    return (f'did you mean "{near[0]}"? Allowed: ' if near else "allowed: ") + ", ".join(names)


def _place(mark: yaml.Mark) -> str:
    """FILE:LINE:COLUMN; an override has no lines worth naming."""
    return str(mark.name) if mark.name.startswith(OVERRIDE) else f"{mark.name}:{mark.line + 1}:{mark.column + 1}"


def _descend(node: yaml.Node, word: str, new: yaml.Node, last: bool, path: str) -> yaml.Node:
    """The entry `word` of a node, replaced by `new` if it is the last word, or made there if it is not."""
    made = new if last else yaml.MappingNode("tag:yaml.org,2002:map", [], new.start_mark, new.end_mark)
    if isinstance(node, yaml.SequenceNode):
        if not word.isdigit() or int(word) > len(node.value):
            raise CaseError("NOT_FOUND", f'"{path}": there is no item [{word}]', path)
        if int(word) == len(node.value):
            node.value.append(made)
        elif last:
            node.value[int(word)] = new
        item: yaml.Node = node.value[int(word)]
        return item
    if not isinstance(node, yaml.MappingNode):
        raise CaseError("NOT_FOUND", f'"{path}": "{word}" is not an entry of a single value', path)
    for k, (key, value) in enumerate(node.value):
        if key.value == word:
            entry: yaml.Node = new if last else value
            node.value[k] = (key, entry)
            return entry
    key = yaml.ScalarNode("tag:yaml.org,2002:str", word, new.start_mark, new.end_mark)
    node.value.append((key, made))
    return made


def _scalar(text: str, field: FieldDescriptor) -> Any:
    """A value of the field's type; None if the text is none."""
    try:
        if field.enum_type:
            return field.enum_type.values_by_name[text.upper().replace("-", "_")].number
        if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
            return {"true": True, "false": False}[text]
        if field.cpp_type == FieldDescriptor.CPPTYPE_STRING:
            return text
        if field.cpp_type in _INTEGERS:
            return int(text)
        return float(text)
    except (KeyError, ValueError):
        return None


def _wanted(field: FieldDescriptor) -> str:
    if field.enum_type:
        return "one of " + ", ".join(name.lower().replace("_", "-") for name in field.enum_type.values_by_name)
    if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
        return "true or false"
    return "a whole number" if field.cpp_type in _INTEGERS else "a number"

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
from typing import Any, Dict, Iterable, List, Mapping, Optional, Union

import numpy as np
import yaml
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from google.protobuf.message import Message

from . import case_pb2
from .errors import CaseError
from .texts import whole_pairs

OVERRIDE = "override "
LIMIT = 16 << 20  # bytes of a case file, as in common/case/reader.h
CaseSource = Union[str, Path, Mapping[str, Any]]
# What common/case/words.c and scalar.c take: Python's own int() and float() read 1_0 and Arabic digits too.
_WHOLE = re.compile(r"0*[0-9]{1,10}")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?\.?inf")
# libyaml, as the command line has it; PyYAML's own reader takes no tabs between words, and is slower.
_LOADER: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
_DEEPEST = 64  # of entries in entries; no case has as many, and readers take long for thousands
_HALF = re.compile("[\ud800-\udfff]")
_PATH = re.compile(r"[^.\[\]]+(?:\.[^.\[\]]+|\[[0-9]{1,9}\])*")


def find(case: Union[str, Path]) -> Path:
    """A case file by path, or by name where common/case/find.c looks: in $MENISCUS_CASES, and in the folders above this package, which
    is in a build inside the checkout, or installed. One that pip has installed elsewhere has cases of its own."""
    path = Path(case)
    if path.is_file():
        return path
    asked, here = os.environ.get("MENISCUS_CASES"), Path(__file__).resolve()
    above = [parent / cases for parent in here.parents for cases in ("server/cases", "share/meniscus/cases")]
    usual = [here.parent / "cases", Path("/usr/local/share/meniscus/cases"), Path("/usr/share/meniscus/cases")]
    folders = ([Path(asked)] if asked else []) + [folder for folder in above + usual if folder.is_dir()]
    for folder in folders:
        if (folder / f"{case}.yaml").is_file():
            return folder / f"{case}.yaml"
    there = sorted({file.stem for folder in folders for file in folder.glob("*.yaml")})
    close = difflib.get_close_matches(str(case), there, 1)
    looked = ", ".join(str(folder) for folder in dict.fromkeys(folders)) or "$MENISCUS_CASES or above the package"
    meant = f'; did you mean "{close[0]}"?' if close else f"; there are {', '.join(there)}" if there else "; set MENISCUS_CASES to their folder"
    raise CaseError("NOT_FOUND", f'there is no file "{case}" and no case of that name in {looked}{meant}')


def name_of(path: Path) -> str:
    """The name of a case from its path, by the rule of common/case/name.c: what a name may not have becomes an underscore."""
    name = re.sub(rb"[^A-Za-z0-9._-]", b"_", os.fsencode(path.stem))[:100].decode("ascii")
    return re.sub(r"^[.-]", "_", name)


def as_yaml(value: Any) -> str:
    """A value as after --set on the command line, in one line; numbers and arrays may be numpy's. Text is taken to be that already."""
    text = value if isinstance(value, str) else _flow(value)
    return whole_pairs(text)


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
        """case: a path, a name, or a mapping that has the shape of a case file. CaseError names what does not belong there."""
        if isinstance(case, Mapping):
            self.name, self.file = "case", "case"
            text = _encode(as_yaml(case), self.file)
        else:
            path = find(case)
            self.name, self.file = name_of(path), str(path)
            with path.open("rb") as file:
                text = file.read(LIMIT + 1)
        if len(text) > LIMIT:
            raise CaseError("INVALID_ARGUMENT", f"{self.file}:1:1: the text is longer than {LIMIT} bytes, which are allowed")
        root = self._compose(text, self.file)
        self._places: Dict[str, str] = {"": _place(root.start_mark)}
        self._message = case_pb2.Case()
        self.settings: Dict[str, str] = {}  # what was overridden, as YAML
        self._read_entries(root, self._message, "")

    def _compose(self, text: bytes, name: str) -> yaml.Node:
        """Read YAML; the name goes into the marks of its nodes."""
        library: Any = yaml  # which has types on some machines, untyped functions there, and none on others
        try:
            depth = 0
            for event in library.parse(_named(text, name), Loader=_LOADER):
                depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
                if depth > _DEEPEST:
                    raise RecursionError
                # The nodes do not tell.
                if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) or getattr(event, "tag", None):
                    raise CaseError("INVALID_ARGUMENT", f"{_place(event.start_mark)}: anchors (&), aliases (*) and tags (!) are not used "
                                    "in case files: write the value itself")
                if isinstance(event, yaml.ScalarEvent) and _HALF.search(event.value):
                    raise CaseError("INVALID_ARGUMENT", f"{_place_of_half(text, event)}: this is not YAML: {_HALVES}")
            node: Optional[yaml.Node] = library.compose(_named(text, name), Loader=_LOADER)
        except yaml.MarkedYAMLError as error:
            where = _place(error.problem_mark) if error.problem_mark else name
            problem = "a second document begins here: a case is one document" if error.context == _SECOND else error.problem
            raise CaseError("INVALID_ARGUMENT", f"{where}: {problem}") from None
        except yaml.reader.ReaderError as error:
            raise CaseError("INVALID_ARGUMENT", f"{_place_in(text, error, name)}: this is not YAML: {error.reason}") from None
        except RecursionError:
            raise CaseError("INVALID_ARGUMENT", f"{name}: entries are nested deeper than those of any case") from None
        if node is None:
            raise CaseError("INVALID_ARGUMENT", f"{_place(event.start_mark)}: there is nothing here")
        return node

    def set(self, path: str, value: Any) -> None:
        """Override an entry: set("fluids[1].density", 2). Text is read as YAML. What is refused changes nothing."""
        text = as_yaml(value)
        if not _PATH.fullmatch(path):
            raise _not_found(path, "this is not a path: write names joined by dots and indices in brackets, as in fluids[1].density")
        changed, places = self.message(), dict(self._places)
        try:
            self._override(changed, path, self._compose(_encode(text, OVERRIDE + path), OVERRIDE + path))
        except CaseError as error:
            self._places = places
            raise CaseError(error.code, error.message, error.path or path) from None
        self._message = changed
        self.settings[path] = text

    def message(self) -> case_pb2.Case:
        """The case as a message, which is yours."""
        message = case_pb2.Case()
        message.CopyFrom(self._message)
        return message

    def _override(self, message: Message, path: str, new: yaml.Node) -> None:
        """Read a node as the entry at a path. What is missing on the way is made, and one item beyond the end of a list."""
        field: Optional[FieldDescriptor] = None
        index: Optional[int] = None
        at = ""
        for word in re.findall(r"[^.\[\]]+|\[[0-9]+", path):
            if word.startswith("["):
                assert field  # a path begins with a name
                index = _item(message, field, index, int(word[1:]), path)
                at += word + "]"
            else:
                if field:
                    message = _entered(message, field, index, path)
                    self._places.setdefault(at, _place(new.start_mark))
                at += "." * bool(at) + word
                field, index = message.DESCRIPTOR.fields_by_name.get(word), None
            if not field:
                raise _not_found(path, f'unknown entry "{word}", ' + _suggest(word, _names(message.DESCRIPTOR)))
        assert field
        self._places = {place: where for place, where in self._places.items() if not _is_within(place, path)}
        self._places[path] = _place(new.start_mark)
        if index is None:
            message.ClearField(field.name)
            self._read_field(new, message, field, path)
        else:
            self._read_item(new, message, field, index, path)

    @staticmethod
    def has(path: str) -> bool:
        """Is it an entry of cases?"""
        return re.split(r"[.\[]", path)[0] in case_pb2.Case.DESCRIPTOR.fields_by_name

    def locate(self, path: str) -> str:
        """FILE:LINE:COLUMN of an entry, or of the nearest entry around it."""
        while path not in self._places:
            path = re.sub(r"[.\[]?[^.\[]*$", "", path)
        return self._places[path]

    def _fail(self, node: yaml.Node, path: str, text: str) -> CaseError:
        return CaseError("INVALID_ARGUMENT", placed(_place(node.start_mark), path, text), path)

    def _unlike(self, node: yaml.Node, path: str, allowed: str) -> CaseError:
        """Another kind of node than belongs there."""
        return self._fail(node, path, f"found {_found(node)}, allowed: {allowed}")

    def _read_message(self, node: yaml.Node, message: Message, path: str) -> None:
        choice = _choice_named(node, message.DESCRIPTOR)
        if not choice:
            self._read_entries(node, message, path)
            return
        getattr(message, choice.name).SetInParent()
        self._places[f"{path}.{choice.name}"] = _place(node.start_mark)

    def _read_entries(self, node: yaml.Node, message: Message, path: str) -> None:
        if not isinstance(node, yaml.MappingNode):
            names = ", ".join(_names(message.DESCRIPTOR))
            raise self._unlike(node, path, f"a mapping ({{}} for an empty one) of entries {names}" if path else 'a mapping, with lines such as "dimensions: 2"')
        given: Dict[str, FieldDescriptor] = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise self._unlike(key, path, "the name of an entry")
            field = message.DESCRIPTOR.fields_by_name.get(key.value)
            inner = f"{path}.{key.value}" if path else key.value
            if field is None:
                raise self._fail(key, path, f'unknown entry "{key.value}", ' + _suggest(key.value, _names(message.DESCRIPTOR)))
            self._check_given(key, field, given, path)
            self._places[inner] = _place(value.start_mark)
            self._read_field(value, message, field, inner)

    def _check_given(self, key: yaml.Node, field: FieldDescriptor, given: Dict[str, FieldDescriptor], path: str) -> None:
        """An entry may be given once, and of a choice only one member; `given` is what was."""
        if field.name in given:
            raise self._fail(key, path, f'the entry "{field.name}" is there twice: remove one')
        for other in given.values():
            if field.containing_oneof and field.containing_oneof == other.containing_oneof:
                raise self._fail(key, path, f'"{other.name}" and "{field.name}" exclude each other: remove one')
        given[field.name] = field

    def _read_field(self, node: yaml.Node, message: Message, field: FieldDescriptor, path: str) -> None:
        if field.label == FieldDescriptor.LABEL_REPEATED:
            if not isinstance(node, yaml.SequenceNode):
                raise self._unlike(node, path, 'a list, as in [a, b] or lines that begin with "- "')
            for k, item in enumerate(node.value):
                self._places[f"{path}[{k}]"] = _place(item.start_mark)
                self._read_item(item, message, field, k, f"{path}[{k}]")
        elif field.message_type:
            getattr(message, field.name).SetInParent()
            self._read_message(node, getattr(message, field.name), path)
        else:
            setattr(message, field.name, self._read_scalar(node, field, path))

    def _read_item(self, node: yaml.Node, message: Message, field: FieldDescriptor, k: int, path: str) -> None:
        """Into an item of a list, or behind its last one."""
        items = getattr(message, field.name)
        if field.message_type:
            item = items.add() if k == len(items) else items[k]
            item.Clear()
            self._read_message(node, item, path)
            return
        value = self._read_scalar(node, field, path)
        items[k : k + 1] = [value]

    def _read_scalar(self, node: yaml.Node, field: FieldDescriptor, path: str) -> Any:
        if not isinstance(node, yaml.ScalarNode):
            raise self._unlike(node, path, _wanted(field))
        is_plain = not node.style
        if is_plain and not node.value:
            raise self._unlike(node, path, _wanted(field))
        if "\0" in node.value:
            raise self._fail(node, path, "the text has a zero byte in it: remove it")
        value = _scalar(node.value, is_plain, field)
        if value is None:
            raise self._fail(node, path, _no_value(node.value, is_plain, field))
        return value


_HALVES = "half of a surrogate pair is no character: write the character itself, or \\U and its eight hexadecimal digits"


def _encode(text: str, name: str) -> bytes:
    try:
        return text.encode()
    except UnicodeEncodeError as error:
        around = ascii(text[max(0, error.start - 20) : error.start + 1])
        raise CaseError("INVALID_ARGUMENT", f"{name}: {_HALVES}; it is at the end of {around}") from None


def _suggest(wrong: str, names: Iterable[str]) -> str:
    near = difflib.get_close_matches(wrong, names, 1)
    return (f'did you mean "{near[0]}"? Allowed: ' if near else "allowed: ") + ", ".join(names)


def _place_of_half(text: bytes, event: yaml.ScalarEvent) -> str:
    """Behind the \\u of the first escape that stands for half of a surrogate pair, where libyaml complains."""
    whole = text.decode("utf-8", "surrogatepass")
    found = re.compile(r"(?<!\\)(?:\\\\)*\\u(?=[dD][89a-fA-F])").search(whole, event.start_mark.index)
    if not found:
        return _place(event.start_mark)
    before = whole[: found.end()].split("\n")
    name = str(event.start_mark.name)
    return name if name.startswith(OVERRIDE) else f"{name}:{len(before)}:{len(before[-1]) + 1}"


_SECOND = "expected a single document in the stream"  # PyYAML's words


def _named(text: bytes, name: str) -> Any:
    stream: Any = io.BytesIO(text)
    stream.name = name  # where the marks look for it
    return stream


def _place(mark: yaml.Mark) -> str:
    """FILE:LINE:COLUMN; an override has no lines worth naming."""
    return str(mark.name) if mark.name.startswith(OVERRIDE) else f"{mark.name}:{mark.line + 1}:{mark.column + 1}"


def _place_in(text: bytes, error: yaml.reader.ReaderError, name: str) -> str:
    """The same of bytes that are no text, or not one of YAML's: then they are counted in characters."""
    before = text[:error.position]
    if error.encoding == "unicode":
        before = text.decode("utf-8", "replace")[:error.position].encode()
    line = before.split(b"\n")
    return name if name.startswith(OVERRIDE) else f"{name}:{len(line)}:{len(line[-1]) + 1}"


def _choice_named(node: yaml.Node, descriptor: Descriptor) -> Optional[FieldDescriptor]:
    """Of several entries that exclude each other, the one that is named where entries were expected: "scheme: riemann" is
    "scheme: {riemann: {}}"."""
    field = descriptor.fields_by_name.get(node.value) if isinstance(node, yaml.ScalarNode) else None
    return field if field and field.containing_oneof and field.message_type else None


def _not_found(path: str, text: str) -> CaseError:
    return CaseError("NOT_FOUND", f"{OVERRIDE}{path}: {text}", path)


def _item(message: Message, field: FieldDescriptor, before: Optional[int], index: int, path: str) -> int:
    """The index of an item of a list, or of the one behind the last, that a path names; before: it has one already."""
    if before is not None or field.label != FieldDescriptor.LABEL_REPEATED:
        raise _not_found(path, f'"{field.name}" is not a list, leave out the index')
    n = len(getattr(message, field.name))
    if index > n:
        raise _not_found(path, f"no such item, allowed: 0 to {n}, where {n} appends one")
    return index


def _entered(message: Message, field: FieldDescriptor, index: Optional[int], path: str) -> Message:
    """The message that an entry, or an item of a list, is: made if it is missing."""
    is_list = field.label == FieldDescriptor.LABEL_REPEATED
    if is_list and index is None:
        raise _not_found(path, f'"{field.name}" is a list, name one of its items: {field.name}[0]')
    if not field.message_type:
        raise _not_found(path, f'"{field.name}" is a single value, there are no entries in it')
    if is_list:
        items = getattr(message, field.name)
        item: Message = items.add() if index == len(items) else items[index]
        return item
    chosen = message.WhichOneof(field.containing_oneof.name) if field.containing_oneof else None
    if chosen and chosen != field.name:
        text = f'the case has "{chosen}", which excludes "{field.name}": set "{field.name}" as a whole to have it instead'
        raise CaseError("INVALID_ARGUMENT", f"{OVERRIDE}{path}: {text}", path)
    entry: Message = getattr(message, field.name)
    entry.SetInParent()
    return entry


def _is_within(path: str, outer: str) -> bool:
    return path == outer or path.startswith((outer + ".", outer + "["))


def _names(descriptor: Descriptor) -> List[str]:
    """Of the entries of a mapping, in the order of the manual."""
    return [field.name for field in sorted(descriptor.fields, key=lambda field: int(field.number))]


def _words(field: FieldDescriptor) -> Dict[str, int]:
    """The values of an enumeration, called as in a file."""
    return {name.lower().replace("_", "-"): value.number for name, value in field.enum_type.values_by_name.items()}


def _scalar(text: str, is_plain: bool, field: FieldDescriptor) -> Any:
    """A value of the field's type; None if the text is none. What is in quotes is a text, and no number."""
    if field.enum_type:
        return _words(field).get(text)
    if field.cpp_type == FieldDescriptor.CPPTYPE_STRING:
        return text
    if not is_plain:
        return None
    if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
        return {"true": True, "false": False}.get(text)
    if field.cpp_type == FieldDescriptor.CPPTYPE_UINT32:
        return int(text[-10:]) if _WHOLE.fullmatch(text) and int(text[-10:]) < 1 << 32 else None
    return float(text.replace(".inf", "inf")) if _NUMBER.fullmatch(text) or _INFINITE.fullmatch(text) else None


def _wanted(field: FieldDescriptor) -> str:
    """What is allowed, but for bounds, which the daemon knows."""
    if field.enum_type:
        return ", ".join(_words(field))
    if field.cpp_type == FieldDescriptor.CPPTYPE_BOOL:
        return "true, false"
    if field.cpp_type == FieldDescriptor.CPPTYPE_STRING:
        return "a text"
    return "a whole number, as 1" if field.cpp_type == FieldDescriptor.CPPTYPE_UINT32 else "a number, as 0.5"


def _no_value(text: str, is_plain: bool, field: FieldDescriptor) -> str:
    if field.enum_type:
        return f'found "{_short(text)}", ' + _suggest(text, _words(field))
    whole, truth = field.cpp_type == FieldDescriptor.CPPTYPE_UINT32, field.cpp_type == FieldDescriptor.CPPTYPE_BOOL
    kind = "a whole number" if whole else "a truth value" if truth else "a number"
    return f'found "{_short(text)}"{"" if is_plain else " in quotes"}, which is not {kind}, allowed: {_wanted(field)}'


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:40] + "..."


def _found(node: yaml.Node) -> str:
    if isinstance(node, yaml.ScalarNode):
        return f'"{_short(node.value)}"' if node.value or node.style else "nothing"
    return "a list" if isinstance(node, yaml.SequenceNode) else "a mapping"


def placed(where: str, path: str, text: str) -> str:
    """A sentence about an entry, with its place in front, and its path where neither of them has that. As case_file_locate() of common/case/file.c."""
    sentence = text[len(path) + 2 :] if path and text.startswith(f"{path}: ") else text
    inner = f"{path}: " if path and where != OVERRIDE + path else ""
    return f"{where}: {inner}{sentence}"

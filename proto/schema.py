#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""schema.py IN.desc OUT.c OUT.h OUT.md: the table of units and bounds that readers apply, the bounds of numbers for the
solver, which knows no messages, and the manual of the case format.

IN.desc is a descriptor set of case.proto with source information. An `@` word that is not known, a malformed argument
or an entry without a meaning ends the build."""
import json
import os
import re
import sys

from google.protobuf import descriptor_pb2

FIELD = descriptor_pb2.FieldDescriptorProto
TYPES = {FIELD.TYPE_DOUBLE: "number", FIELD.TYPE_UINT32: "whole number", FIELD.TYPE_BOOL: "true or false",
         FIELD.TYPE_STRING: "text", FIELD.TYPE_ENUM: "word", FIELD.TYPE_MESSAGE: "mapping"}
WORDS = ("unit", "range", "required", "steerable", "formula", "count", "default", "note")
NUMBER = r"[-+]?(?:inf|[0-9.]+(?:e[-+]?[0-9]+)?)"


def fail(where, text):
    sys.exit(f"case.proto: {where}: {text}")


def split_comment(where, comment):
    """Separate the sentences of a comment from its @ words."""
    words = {}
    for word, argument in re.findall(r"@(\w+)([^@\n]*)", comment):
        if word not in WORDS:
            fail(where, f"unknown word @{word}; there are @" + ", @".join(WORDS))
        if word in words:
            fail(where, f"@{word} is there twice")
        words[word] = argument.strip()
    meaning = " ".join(re.sub(r"@\w+[^@\n]*", "", comment).split())
    return meaning, words


def parse_range(where, text):
    match = re.fullmatch(rf"([(\[])({NUMBER}), ({NUMBER})([)\]])", text)
    if not match:
        fail(where, f"@range {text} is not an interval such as (0, 1]")
    low, high = float(match[2]), float(match[3])
    if not low < high:
        fail(where, f"@range {text} is empty")
    return low, high, match[1] == "(", match[4] == ")"


def parse_count(where, text):
    match = re.fullmatch(r"(\d+)\.\.(\d+)", text)
    if not match or int(match[1]) > int(match[2]):
        fail(where, f"@count {text} is not as in 2..3")
    return int(match[1]), int(match[2])


def enum_word(name):
    return name.lower().replace("_", "-")


class Entry:
    """One field of one message, with what its comment says."""

    def __init__(self, message, field, comment, oneof_words, notes):
        where = f"{message}.{field.name}"
        self.name, self.field = field.name, field
        self.meaning, words = split_comment(where, comment)
        if not self.meaning:
            fail(where, "no meaning: write a sentence above it")
        self.unit = words.get("unit", "")
        self.range = words.get("range", "")
        self.bounds = parse_range(where, self.range) if self.range else (float("-inf"), float("inf"), True, True)
        self.count = parse_count(where, words["count"]) if "count" in words else (0, 0)
        self.formula = words.get("formula")
        self.required, self.steerable = "required" in words, "steerable" in words
        self.repeated = field.label == FIELD.LABEL_REPEATED
        self.in_choice = field.HasField("oneof_index")
        self.of_required_choice = "required" in oneof_words
        self.is_default = self.in_choice and "default" in words
        self.absence = "" if self.in_choice else words.get("default", "")
        self.type_name = field.type_name.rsplit(".", 1)[-1]
        self.note = notes.get(self.type_name, "")
        if "note" in words:
            fail(where, "@note is for enums")
        if field.type not in TYPES:
            fail(where, "a type that case files do not have")
        if self.range and field.type not in (FIELD.TYPE_DOUBLE, FIELD.TYPE_UINT32):
            fail(where, "@range is for numbers")
        if self.formula is not None and field.type != FIELD.TYPE_STRING:
            fail(where, "@formula is for strings")
        if "count" in words and not self.repeated:
            fail(where, "@count is for lists")
        if self.is_default and words["default"]:
            fail(where, "@default of a oneof's member stands alone")
        if not self.default_words():
            fail(where, "no default: write @required, [default = ...], or @default and what its absence means")
        if self.absence and (self.required or field.HasField("default_value")):
            fail(where, "@default is for entries that have neither a default value nor are required")

    def type_words(self, enums, link=True):
        field = self.field
        if field.type == FIELD.TYPE_MESSAGE:
            text = f"[{self.type_name}](#{self.type_name.lower()})" if link else "mapping"
        elif field.type == FIELD.TYPE_ENUM:
            text = ", ".join(enum_word(v.name) for v in enums[self.type_name].value)
        else:
            text = "formula" if self.formula is not None else TYPES[field.type]
        return f"list of {text}" if self.repeated else text

    def default_words(self):
        if self.field.HasField("default_value"):
            value = self.field.default_value
            return enum_word(value) if self.field.type == FIELD.TYPE_ENUM else value
        if self.in_choice:
            return "*the choice*" if self.is_default else "*a choice*"
        return "*required*" if self.required else self.absence


class Schema:
    def __init__(self, file):
        self.comments = {tuple(l.path): l.leading_comments for l in file.source_code_info.location}
        self.enums = {e.name: e for e in [*file.enum_type, *(e for m in file.message_type for e in m.enum_type)]}
        self.package = file.package
        notes = {e.name: split_comment(e.name, self.comments.get((5, k), ""))[1].get("note", "") for k, e in enumerate(file.enum_type)}
        self.messages = []
        for m, message in enumerate(file.message_type):
            choices = [split_comment(f"{message.name}.{c.name}", self.comments.get((4, m, 8, k), ""))[1]
                       for k, c in enumerate(message.oneof_decl)]
            entries = [Entry(message.name, f, self.comments.get((4, m, 2, k), ""),
                             choices[f.oneof_index] if f.HasField("oneof_index") else {}, notes)
                       for k, f in enumerate(message.field)]
            meaning = split_comment(message.name, self.comments.get((4, m), ""))[0]
            if not meaning:
                fail(message.name, "no meaning: write a sentence above it")
            if len(entries) > 64:
                fail(message.name, "more than 64 entries: the reader remembers them in 64 bits")
            self.messages.append((message.name, meaning, entries))
        self.by_name = {name: entries for name, _, entries in self.messages}

    def steerables(self, message="Case", prefix=""):
        """Paths of what may be changed in a run; what lies inside a list has none."""
        for entry in self.by_name[message]:
            if entry.steerable:
                yield prefix + entry.name, entry
            if entry.field.type == FIELD.TYPE_MESSAGE and not entry.repeated:
                yield from self.steerables(entry.type_name, prefix + entry.name + ".")


def c_text(text):
    return "NULL" if text is None else json.dumps(text, ensure_ascii=False)


def c_number(value):
    return {float("inf"): "INFINITY", float("-inf"): "-INFINITY"}.get(value, repr(value))


def c_entry(entry):
    low, high, low_open, high_open = entry.bounds
    flag = ("false", "true")
    return (f"    {{.name = {c_text(entry.name)}, .unit = {c_text(entry.unit)}, .range = {c_text(entry.range)},\n"
            f"     .min = {c_number(low)}, .max = {c_number(high)}, .min_open = {flag[low_open]}, "
            f".max_open = {flag[high_open]},\n"
            f"     .count_min = {entry.count[0]}, .count_max = {entry.count[1]}, .formula = {c_text(entry.formula)},\n"
            f"     .required = {flag[entry.required]}, .steerable = {flag[entry.steerable]}, "
            f".of_required_choice = {flag[entry.of_required_choice]}, .is_default = {flag[entry.is_default]},\n"
            f"     .note = {c_text(entry.note)}, .meaning = {c_text(entry.meaning)}}},\n")


def write_table(schema, out):
    out.write("/* SPDX-License-Identifier: BSD-3-Clause */\n/* Made by proto/schema.py from case.proto. */\n"
              '#include "common/case/schema.h"\n#include <math.h>\n\n')
    for name, _, entries in schema.messages:
        ordered = sorted(entries, key=lambda e: e.field.number)
        out.write(f"static const CaseEntry entries_{name}[] = {{\n{''.join(map(c_entry, ordered))}}};\n\n")
    out.write("const CaseSchema case_schemas[] = {\n")
    for name, _, entries in schema.messages:
        out.write(f'    {{"{schema.package}.{name}", {len(entries)}, entries_{name}}},\n')
    out.write("};\nconst size_t case_schemas_n = sizeof case_schemas / sizeof *case_schemas;\n\n"
              "const CaseParameter case_steerables[] = {\n")
    for path, entry in schema.steerables():
        row = (path, entry.type_words(schema.enums, link=False), entry.unit, entry.range, entry.meaning)
        out.write(f"    {{{', '.join(map(c_text, row))}}},\n")
    out.write("};\nconst size_t case_steerables_n = sizeof case_steerables / sizeof *case_steerables;\n")


def write_bounds(schema, out):
    out.write("/* SPDX-License-Identifier: BSD-3-Clause */\n/* Made by proto/schema.py from case.proto. */\n"
              "#ifndef SIM_CASE_BOUNDS_H\n#define SIM_CASE_BOUNDS_H\n\n"
              '#include "sim/bounds.h"\n#include <math.h>\n\n')
    for name, _, entries in schema.messages:
        for entry in (e for e in entries if e.range):
            low, high, low_open, high_open = entry.bounds
            words = " ".join(filter(None, (entry.range, entry.unit)))
            out.write(f"#define BOUNDS_{name}_{entry.name} ((Bounds){{{c_number(low)}, {c_number(high)}, "
                      f"{int(low_open)}, {int(high_open)}, {c_text(words)}}})\n")
    out.write("\n#endif\n")


def bounds_words(entry):
    words = [f"`{entry.range}`"] if entry.range else []
    if entry.count != (0, 0):
        low, high = entry.count
        words.append(f"{low} items" if low == high else f"{low} to {high} items")
    if entry.formula:
        words.append("of " + ", ".join(entry.formula.split()))
    return "; ".join(words)


def table_rows(schema, entries):
    for entry in entries:
        cells = (f"`{entry.name}`", entry.type_words(schema.enums), entry.unit, bounds_words(entry),
                 entry.default_words(), "yes" if entry.steerable else "", entry.meaning)
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def write_message(schema, name, meaning, entries, out):
    out.write(f"\n## {name}\n\n{meaning}\n\n")
    if not entries:
        return
    out.write("| entry | type | unit | bounds | default | steerable | meaning |\n|---|---|---|---|---|---|---|\n")
    out.writelines(table_rows(schema, entries))
    choice = [e for e in entries if e.in_choice]
    if choice:
        names = ", ".join(f"`{e.name}`" for e in choice)
        usual = [e.name for e in choice if e.is_default]
        amount = "Exactly" if choice[0].of_required_choice else "At most"
        out.write(f"\n{amount} one of {names}" + (f"; none means `{usual[0]}`" if usual else "") + ".\n")


def write_manual(schema, introduction, out):
    out.write(introduction)
    for name, meaning, entries in schema.messages:
        write_message(schema, name, meaning, entries, out)
    out.write("\n## Steerable entries\n\n"
              "These may be changed while a simulation runs, with `meniscus set PATH=VALUE`.\n\n"
              "| path | unit | bounds |\n|---|---|---|\n")
    for path, entry in schema.steerables():
        out.write(f"| `{path}` | {entry.unit} | {bounds_words(entry)} |\n")


def main():
    if len(sys.argv) != 5:
        sys.exit("usage: schema.py IN.desc OUT.c OUT.h OUT.md")
    with open(sys.argv[1], "rb") as file:
        schema = Schema(descriptor_pb2.FileDescriptorSet.FromString(file.read()).file[0])
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "manual.md"), encoding="utf-8") as file:
        introduction = file.read()
    with open(sys.argv[2], "w", encoding="utf-8") as out:
        write_table(schema, out)
    with open(sys.argv[3], "w", encoding="utf-8") as out:
        write_bounds(schema, out)
    with open(sys.argv[4], "w", encoding="utf-8") as out:
        write_manual(schema, introduction, out)


if __name__ == "__main__":
    main()

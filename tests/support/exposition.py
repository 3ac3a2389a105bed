# SPDX-License-Identifier: BSD-3-Clause
"""Metrics as text, read as strictly as their specifications say: Prometheus 0.0.4 and OpenMetrics 1.0.0."""

import math
import re
from dataclasses import dataclass, field

NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"
VALUE = re.compile(r"NaN|[+-]Inf|[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?")
LABEL = re.compile(r'([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\\n]|\\[\\n"])*)"(,|$)')
SUFFIXES = {"counter": "_total", "info": "_info", "gauge": ""}


@dataclass
class Family:
    name: str
    type: str
    help: str
    unit: str = ""
    samples: "dict[tuple[tuple[str, str], ...], float]" = field(default_factory=dict)

    def value(self, **labels: str) -> float:
        """Of the one sample that has these labels among its own."""
        found = [value for own, value in self.samples.items() if set(labels.items()) <= set(own)]
        if len(found) != 1:
            raise AssertionError(f"{self.name} has {len(found)} samples with {labels}")
        return found[0]


def read_labels(text: str) -> "tuple[tuple[str, str], ...]":
    labels, at = [], 0
    while at < len(text):
        match = LABEL.match(text, at)
        if not match:
            raise AssertionError(f"not labels: {text[at:]}")
        plain = re.sub(r'\\([\\n"])', lambda m: "\n" if m[1] == "n" else m[1], match[2])
        labels.append((match[1], plain))
        at = match.end()
    if len({name for name, _ in labels}) != len(labels):
        raise AssertionError(f"a label twice: {text}")
    return tuple(labels)


def read_number(text: str) -> float:
    if not VALUE.fullmatch(text):
        raise AssertionError(f"not a number: {text}")
    return float(text.replace("Inf", "inf"))


def parse(text: str, open_metrics: bool = False) -> "dict[str, Family]":
    """The families by name, as it is in TYPE. Raises AssertionError at the first fault."""
    families: "dict[str, Family]" = {}
    now: "Family | None" = None
    lines = text.split("\n")
    if lines.pop():
        raise AssertionError("the last line has no end")
    if open_metrics and (not lines or lines.pop() != "# EOF"):
        raise AssertionError("no # EOF at the end")
    for line in lines:
        comment = re.fullmatch(rf"# (HELP|TYPE|UNIT) ({NAME}) (.*)", line)
        if comment and comment[1] == "HELP":
            if comment[2] in families:
                raise AssertionError(f"{comment[2]} is there twice, or not in one place")
            now = families[comment[2]] = Family(comment[2], "", comment[3])
        elif comment:
            if not now or now.name != comment[2] or now.samples or getattr(now, comment[1].lower()):
                raise AssertionError(f"out of place: {line}")
            setattr(now, comment[1].lower(), comment[3])
        else:
            read_sample(line, now, open_metrics)
    for family in families.values():
        check(family, open_metrics)
    return families


def read_sample(line: str, family: "Family | None", open_metrics: bool) -> None:
    match = re.fullmatch(rf"({NAME})(?:\{{(.*)\}})? (\S+)", line)
    if not match or not family or not family.type:
        raise AssertionError(f"out of place, or no sample: {line}")
    if match[1] != family.name + (SUFFIXES[family.type] if open_metrics else ""):
        raise AssertionError(f"{match[1]} among those of {family.name}")
    labels = read_labels(match[2] or "")
    if labels in family.samples:
        raise AssertionError(f"twice: {line}")
    family.samples[labels] = read_number(match[3])


def check(family: Family, open_metrics: bool) -> None:
    """What the conventions ask for of a whole family."""
    name = family.name
    if not family.samples or not family.help or family.type not in (SUFFIXES if open_metrics else ("gauge", "counter")):
        raise AssertionError(f"{name}: type {family.type!r}, {len(family.samples)} samples, help {family.help!r}")
    if family.unit and not name.endswith("_" + family.unit):
        raise AssertionError(f"{name} does not end with its unit, {family.unit}")
    if not open_metrics and name.endswith("_total") != (family.type == "counter"):
        raise AssertionError(f"{name} is a {family.type}")
    if re.search(r"_(ms|us|ns|millis\w*|micros\w*|nanos\w*|minutes|hours|kb|mb|kilobytes|megabytes|bits|percent)(_|$)", name):
        raise AssertionError(f"{name} is not in a base unit")
    if len({tuple(label for label, _ in labels) for labels in family.samples}) != 1:
        raise AssertionError(f"samples of {name} have different labels")
    if family.type == "counter" and not all(value >= 0 and math.isfinite(value) for value in family.samples.values()):
        raise AssertionError(f"{name} is no count: {family.samples}")

# SPDX-License-Identifier: BSD-3-Clause
"""Metrics as text, Prometheus 0.0.4 or OpenMetrics 1.0.0, read by Prometheus' own parsers and held to its conventions."""

import math
import re
from dataclasses import dataclass, field

from prometheus_client import Metric
from prometheus_client.openmetrics.parser import text_string_to_metric_families as read_open
from prometheus_client.parser import text_string_to_metric_families as read_plain

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


def family_of(metric: Metric, open_metrics: bool) -> Family:
    """Raises AssertionError for samples of other names, or that are there twice."""
    plain = metric.type == "counter" and not open_metrics  # whose name its parser cuts
    family = Family(metric.name + ("_total" if plain else ""), metric.type, metric.documentation, metric.unit)
    for sample in metric.samples:
        labels = tuple(sample.labels.items())
        if sample.name != family.name + (SUFFIXES.get(family.type, "") if open_metrics else "") or labels in family.samples:
            raise AssertionError(f"{sample.name} {labels} among the samples of {family.name}, or twice")
        family.samples[labels] = sample.value
    return family


def parse(text: str, open_metrics: bool = False) -> "dict[str, Family]":
    """The families by name, as it is in TYPE. Raises AssertionError or ValueError at the first fault."""
    if not text.endswith("\n"):
        raise AssertionError("the last line has no end")
    families: "dict[str, Family]" = {}
    for metric in (read_open if open_metrics else read_plain)(text):
        family = family_of(metric, open_metrics)
        if family.name in families:
            raise AssertionError(f"{family.name} is there twice, or not in one place")
        families[family.name] = family
        check(family, open_metrics)
    return families


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

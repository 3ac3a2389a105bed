#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""What is shipped for Prometheus and Grafana: alerts that say what they should of made-up series, and no name of a metric that there is not."""

import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import ROOT  # noqa: E402

SHIPPED = ROOT / "server" / "monitoring"
ALERTS = SHIPPED / "meniscus-alerts.yaml"
PROMTOOL = shutil.which("promtool")


def metrics() -> "set[str]":
    """Those that the manual lists: test_http.py sees that these are what a daemon has."""
    return set(re.findall(r"^\| `((?:meniscus|process)_\w+)", (ROOT / "server" / "http" / "README.md").read_text(), re.MULTILINE))


def named(text: str) -> "set[str]":
    return set(re.findall(r"\b(?:meniscus|process)_[a-z_]+", text))


def rules() -> "list[dict[str, Any]]":
    return [rule for group in yaml.safe_load(ALERTS.read_text())["groups"] for rule in group["rules"]]


class Alerts(unittest.TestCase):
    def promtool(self, *words: str, where: Path = SHIPPED) -> None:
        if not PROMTOOL:
            self.skipTest("promtool is missing: it is in the package prometheus")
        done = subprocess.run([PROMTOOL, *words], cwd=where, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_promtool_accepts_rules_and_the_example(self) -> None:
        self.promtool("check", "rules", ALERTS.name)
        self.promtool("check", "config", "prometheus.yaml")

    def test_they_come_when_they_should_and_only_then(self) -> None:
        # Without what they say, which every expectation would have to repeat.
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            bare = yaml.safe_load(ALERTS.read_text())
            for group in bare["groups"]:
                for rule in group["rules"]:
                    del rule["annotations"]
            (Path(scratch) / ALERTS.name).write_text(yaml.safe_dump(bare))
            shutil.copy(Path(__file__).with_name("alerts_test.yaml"), scratch)
            self.promtool("test", "rules", "alerts_test.yaml", where=Path(scratch))

    def test_each_is_expected_to_come_and_to_stay_away_somewhere(self) -> None:
        cases = [case for test in yaml.safe_load(Path(__file__).with_name("alerts_test.yaml").read_text())["tests"]
                 for case in test["alert_rule_test"]]
        for comes in (True, False):
            self.assertEqual({case["alertname"] for case in cases if bool(case.get("exp_alerts")) == comes},
                             {rule["alert"] for rule in rules()})

    def test_each_says_what_is_wrong_and_what_to_do(self) -> None:
        for rule in rules():
            self.assertEqual(set(rule["annotations"]), {"summary", "description"}, rule["alert"])
            self.assertIn(rule["labels"]["severity"], ("critical", "warning"))
            self.assertIn("$labels.instance", rule["annotations"]["summary"])

    def test_they_name_metrics_that_there_are(self) -> None:
        self.assertGreater(len(metrics()), 40)
        self.assertEqual(named(ALERTS.read_text()) - metrics(), set())


class Dashboard(unittest.TestCase):
    dashboard = json.loads((SHIPPED / "meniscus-dashboard.json").read_text())

    def expressions(self) -> "list[str]":
        return [target["expr"] for panel in self.dashboard["panels"] for target in panel["targets"]]

    def test_it_names_metrics_that_there_are(self) -> None:
        self.assertGreater(len(self.expressions()), 20)
        text = json.dumps(self.dashboard)
        self.assertEqual(named(text) - metrics(), set())

    def test_each_panel_asks_for_the_daemon_that_was_chosen(self) -> None:
        for expression in self.expressions():
            self.assertEqual(len(named(expression)), expression.count('{job="$job", instance="$instance"}'), expression)

    def test_its_expressions_are_such_as_prometheus_takes(self) -> None:
        if not PROMTOOL:
            self.skipTest("promtool is missing: it is in the package prometheus")
        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            file = Path(scratch) / "rules.yaml"
            rules = [{"record": f"x:{k}", "expr": expression} for k, expression in enumerate(self.expressions())]
            file.write_text(yaml.safe_dump({"groups": [{"name": "x", "rules": rules}]}))
            done = subprocess.run([PROMTOOL, "check", "rules", file], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_panels_have_titles_say_what_they_show_and_do_not_overlap(self) -> None:
        cells: "set[tuple[int, int]]" = set()
        for panel in self.dashboard["panels"]:
            self.assertTrue(panel["title"] and panel["description"])
            at = panel["gridPos"]
            own = {(at["x"] + x, at["y"] + y) for x in range(at["w"]) for y in range(at["h"])}
            self.assertLessEqual(max(x for x, _ in own), 23)
            self.assertFalse(own & cells, panel["title"])
            cells |= own
        self.assertEqual(len({panel["id"] for panel in self.dashboard["panels"]}), len(self.dashboard["panels"]))


if __name__ == "__main__":
    unittest.main()

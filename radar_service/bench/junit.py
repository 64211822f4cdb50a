"""The report of a test bench as JUnit XML, which servers of continuous integration show: a test is a limit of a scenario."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from radar_service.bench.report import bound_of, event_line, failure_lines, number_of, unit_of
from radar_service.terminal import write_file


def write_junit(report: Mapping[str, Any], path: Path, strict: bool = False) -> None:
    """Writes a report as JUnit XML. strict: whether an undecided limit is a failure; it is skipped otherwise. Raises OSError."""
    root = ElementTree.Element("testsuites", name=f"bench-tracker {report['tracker']}")
    for scenario in report["scenarios"]:
        _suite(root, scenario, strict)
    ElementTree.indent(root)
    write_file(path, ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def reason_of(verdict: Mapping[str, Any], scenario: Mapping[str, Any]) -> str:
    """Returns why a limit is missed or undecided: its value, the limit, the worst seed with its value and first event."""
    metric, unit = verdict["metric"], unit_of(verdict["metric"])
    text = f"{verdict['word']}: {verdict['failures']} of {verdict['runs']} runs miss it"
    text += f"; 95 % value {number_of(verdict['value_95'])}, limit {bound_of(verdict)} {unit}".rstrip()
    missing = [run for run in scenario["failed_runs"] if metric in run["missed"]]
    if not missing:
        return text
    sign = 1.0 if verdict["maximum"] is not None else -1.0
    worst = max(missing, key=lambda run: math.inf if (value := run["missed"][metric]) is None else sign * value)
    first = min(worst["events"], key=lambda event: event["scan"], default=None)
    text += f"; worst seed {worst['seed']}: {number_of(worst['missed'][metric])} {unit}".rstrip()
    return text + (f"; first event: {event_line(first)}" if first else "")


def _suite(root: ElementTree.Element, scenario: Mapping[str, Any], strict: bool) -> None:
    """A scenario: a test for each limit that decides, and one for the runs that failed. What is only shown is no test."""
    suite = ElementTree.SubElement(root, "testsuite", name=scenario["name"])
    failed, decided = failure_lines({"scenarios": [scenario]}), [each for each in scenario["verdicts"] if each["decides"]]
    if failed or decided:
        runs = ElementTree.SubElement(suite, "testcase", classname=scenario["name"], name="runs")
    if failed:
        ElementTree.SubElement(runs, "failure", message=failed[0]).text = "\n".join(failed)
    for verdict in decided:
        name = f"{verdict['metric']} {bound_of(verdict)} {unit_of(verdict['metric'])}".rstrip()
        case = ElementTree.SubElement(suite, "testcase", classname=scenario["name"], name=name)
        kind = "failure" if verdict["word"] == "fail" or (strict and verdict["word"] == "undecided") else "skipped"
        if verdict["word"] in ("fail", "undecided"):
            ElementTree.SubElement(case, kind, message=reason_of(verdict, scenario)).text = verdict["source"]
    cases = list(suite)
    suite.set("tests", str(len(cases)))
    for kind, name in (("failure", "failures"), ("skipped", "skipped")):
        suite.set(name, str(sum(case.find(kind) is not None for case in cases)))

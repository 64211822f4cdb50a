"""The report of a test bench as JUnit XML, which servers of continuous integration show: a test is a limit of a scenario."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from radar_service.bench.report import bound_of, failure_lines, unit_of
from radar_service.terminal.output_files import write_file


def write_junit(report: Mapping[str, Any], path: Path, strict: bool = False) -> None:
    """Writes a report as JUnit XML. strict: whether an undecided limit is a failure; it is skipped otherwise. Raises OSError."""
    root = ElementTree.Element("testsuites", name=f"bench-tracker {report['tracker']}")
    for scenario in report["scenarios"]:
        _suite(root, scenario, strict)
    ElementTree.indent(root)
    write_file(path, ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _suite(root: ElementTree.Element, scenario: Mapping[str, Any], strict: bool) -> None:
    """A scenario: a test for each limit, and one for the runs that failed."""
    suite = ElementTree.SubElement(root, "testsuite", name=scenario["name"])
    failed = failure_lines({"scenarios": [scenario]})
    runs = ElementTree.SubElement(suite, "testcase", classname=scenario["name"], name="runs")
    if failed:
        ElementTree.SubElement(runs, "failure", message=failed[0]).text = "\n".join(failed)
    for verdict in scenario["verdicts"]:
        name = f"{verdict['metric']} {bound_of(verdict)} {unit_of(verdict['metric'])}".rstrip()
        case = ElementTree.SubElement(suite, "testcase", classname=scenario["name"], name=name)
        kind = "failure" if verdict["word"] == "fail" or (strict and verdict["word"] == "undecided") else "skipped"
        if verdict["word"] in ("fail", "undecided", "shown"):
            message = f"{verdict['word']}: {verdict['failures']} of {verdict['runs']} runs miss it ({verdict['source']})"
            ElementTree.SubElement(case, kind, message=message)
    cases = list(suite)
    suite.set("tests", str(len(cases)))
    for kind, name in (("failure", "failures"), ("skipped", "skipped")):
        suite.set(name, str(sum(case.find(kind) is not None for case in cases)))

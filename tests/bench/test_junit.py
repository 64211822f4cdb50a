"""The report as JUnit XML."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from radar_service.bench.bench import report
from radar_service.bench.junit import write_junit
from radar_service.bench.scenario import Limit, Scenario
from tests.bench.test_report import EVENT, RUN
from tests.bench.test_scenario import SMALL

LIMITS = (
    Limit(metric="ospa_m", maximum=10, source="a & <b>"),
    Limit(metric="held", minimum=1, source="c"),
    Limit(metric="spurious", maximum=0, source="d", decides=False),
)


def cases(tmp_path: Path, strict: bool, failure: dict | None = None) -> tuple[ElementTree.Element, dict[str | None, str]]:
    """A suite of three runs that all miss one limit, and what became of each test."""
    run = {**RUN, "metrics": {} if failure else {"ospa_m": 3.0, "held": 0.0, "spurious": 1.0}, "failure": failure}
    scenario = Scenario(**{**SMALL, "limit": LIMITS, "judges": "plots"})
    write_junit(report({"small": scenario}, {"small": [run] * 3}, "a <tracker>"), tmp_path / "bench.xml", strict)
    (suite,) = ElementTree.parse(tmp_path / "bench.xml").getroot()
    return suite, {case.get("name"): case[0].tag if len(case) else "passed" for case in suite}


@pytest.mark.parametrize(("strict", "undecided"), [(False, "skipped"), (True, "failure")])
def test_a_test_is_a_limit_that_decides(strict: bool, undecided: str, tmp_path: Path) -> None:
    suite, results = cases(tmp_path, strict)
    assert results == {"runs": "passed", "ospa_m at most 10 m": undecided, "held at least 1": "failure"}
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("3", str(1 + strict), str(1 - strict))


def test_a_scenario_that_is_shown_alone_has_no_test(tmp_path: Path) -> None:
    scenario = Scenario(**{**SMALL, "limit": LIMITS[2:], "judges": "plots"})
    write_junit(report({"small": scenario}, {"small": [RUN]}, "gnn"), tmp_path / "bench.xml")
    (suite,) = ElementTree.parse(tmp_path / "bench.xml").getroot()
    assert len(suite) == 0 and suite.get("tests") == "0"


def test_a_failure_has_value_limit_worst_seed_and_first_event(tmp_path: Path) -> None:
    late = {"kind": "late", "scan": 9, "last": 12, "body": "t", "other": "", "what": "t has no first state"}
    runs = [
        {**RUN, "seed": seed, "metrics": {"ospa_m": ospa, "held": held}, "events": events}
        for seed, ospa, held, events in ((0, 11.0, 0.5, []), (1, 31.0, None, [late, EVENT]), (2, 12.0, 0.9, []))
    ]
    scenario = Scenario(**{**SMALL, "limit": LIMITS[:2], "judges": "plots"})
    write_junit(report({"small": scenario}, {"small": runs}, "gnn", smoke=True), tmp_path / "bench.xml")
    reasons = {
        case.get("name"): case[0].get("message")
        for case in ElementTree.parse(tmp_path / "bench.xml").iter("testcase")
        if len(case)
    }
    event = "first event: scan 1: break: t <1> has no track"
    assert reasons == {
        "ospa_m at most 10 m": "fail: 3 of 3 runs miss it; 95 % value 29.1, limit at most 10 m; worst seed 1: 31 m; "
        + event,
        "held at least 1": "fail: 3 of 3 runs miss it; 95 % value none, limit at least 1; worst seed 1: none; " + event,
    }


def test_failed_runs_are_a_failure_with_their_text(tmp_path: Path) -> None:
    failure = {"scan": 7, "message": "it has ended", "status": 1, "stderr": "KeyError", "hangs": False}
    suite, results = cases(tmp_path, False, failure)
    assert results["runs"] == "failure" and "failed at scan 7" in (suite[0][0].text or "")

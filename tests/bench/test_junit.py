"""The report as JUnit XML."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from radar_service.bench.bench import report
from radar_service.bench.junit import write_junit
from radar_service.bench.scenario import Limit, Scenario
from tests.bench.test_report import RUN
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
def test_a_test_is_a_limit(strict: bool, undecided: str, tmp_path: Path) -> None:
    suite, results = cases(tmp_path, strict)
    assert results == {
        "runs": "passed", "ospa_m at most 10 m": undecided, "held at least 1": "failure", "spurious at most 0": "skipped"
    }  # fmt: skip
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("4", str(1 + strict), str(2 - strict))


def test_failed_runs_are_a_failure_with_their_text(tmp_path: Path) -> None:
    failure = {"scan": 7, "message": "it has ended", "status": 1, "stderr": "KeyError", "hangs": False}
    suite, results = cases(tmp_path, False, failure)
    assert results["runs"] == "failure" and "failed at scan 7" in (suite[0][0].text or "")

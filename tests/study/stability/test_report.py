"""The report: HTML and JSON of all findings."""

import json
import re
from pathlib import Path

import pytest

from radar_service.study import stability
from radar_service.study.stability.report import page, write_report
from tests.study.stability.run import finding_of


@pytest.mark.parametrize("step", [6, pytest.param(1, marks=pytest.mark.study)])
def test_the_report_has_every_region(step: int, tmp_path: Path) -> None:
    """Each finding has a figure; the suite takes every sixth."""
    findings = [finding_of(study.__name__) for study in stability.STUDIES[::step]]
    write_report(tmp_path / "new", findings)
    stored = json.loads((tmp_path / "new" / "stability.json").read_text())
    assert [one["name"] for one in stored] == [finding.name for finding in findings]
    text = re.sub("base64,[^']*", "", (tmp_path / "new" / "stability.html").read_text())
    assert text.count("<section") == text.count("<img alt=") == len(findings)
    assert "nan" not in text.lower() and "None" not in text


def test_a_row_names_method_boundary_and_replacement() -> None:
    """The table says which method fails where, and what the service uses instead."""
    row = "<td>range in float32, the precision of Embree</td><td>range [m] = 1,020</td><td>range and phase in float64</td>"
    text = page([finding_of("float32_range"), finding_of("headings")])
    assert row in text and "<li>1: the service uses another method</li>" in text
    assert "<td>angle [degrees]: nowhere from -1,080 to 1,080</td>" in text

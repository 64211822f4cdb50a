"""The report: HTML and JSON of all findings."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from radar_service.study import stability
from radar_service.study.stability.report import finding_figure, page, write_report
from tests.study.stability.run import finding_of


@pytest.mark.parametrize("step", [4, pytest.param(1, marks=pytest.mark.study)])
def test_the_report_has_every_region(step: int, tmp_path: Path) -> None:
    """Each finding has a figure; the suite takes every fourth."""
    findings = [finding_of(study.__name__) for study in stability.STUDIES[::step]]
    write_report(tmp_path / "new", findings)
    stored = json.loads((tmp_path / "new" / "stability.json").read_text())
    assert [one["name"] for one in stored] == [finding.name for finding in findings]
    text = re.sub('base64,[^"]*', "", (tmp_path / "new" / "stability.html").read_text())
    assert text.count("<section") == text.count("<img alt=") == len(findings)
    assert "nan" not in text.lower() and "None" not in text


def test_a_row_names_method_boundary_and_replacement() -> None:
    """The table says which method fails where, and what the service uses instead."""
    row = "<td>range in float32, the precision of Embree</td><td>range [m] = 1,020</td><td>range and phase in float64</td>"
    text = page([finding_of("float32_range"), finding_of("months")])
    assert row in text and "<li>1: the service uses another method</li>" in text
    assert "<td>days: nowhere from 0 to 365,000</td>" in text


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", [study.__name__ for study in stability.STUDIES])
def test_a_figure_shows_its_finding(name: str) -> None:
    """Axis titles fit the figure, and the legend names every curve, the limit and the boundary."""
    finding = finding_of(name)
    figure = finding_figure(finding)
    (axes,) = figure.axes
    assert axes.get_xlabel() == finding.parameter.label and axes.get_ylabel() == finding.measured.label
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    boundary = [] if finding.boundary is None else [legend[-1]]
    assert legend == [*(curve.name for curve in finding.curves), "limit", *boundary]
    assert all(text.startswith("boundary, ") for text in boundary)
    assert_fits(figure)


def assert_fits(figure: Figure) -> None:
    """Axis titles and the legend lie within the figure, the legend below the title of its axis."""
    (axes,), (legend,) = figure.axes, figure.legends
    figure.draw_without_rendering()
    title, below = axes.xaxis.label.get_window_extent(), legend.get_window_extent()
    for box in (axes.yaxis.label.get_window_extent(), title, below):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= figure.bbox.x1 and box.y1 <= figure.bbox.y1
    assert below.y1 <= title.y0


def test_a_legend_of_three_rows_fits() -> None:
    finding = finding_of("missed_sizes")
    curves = [replace(finding.curves[0], name=f"method {k}") for k in range(6)]
    figure = finding_figure(replace(finding, curves=tuple(curves)))
    assert len(figure.legends[0].get_texts()) > 6
    assert_fits(figure)

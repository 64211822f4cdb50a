"""Figures of findings: titles, curves, limit, boundary, and bytes that repeat."""

from dataclasses import replace

import pytest
from matplotlib.figure import Figure

from radar_service.study import stability
from radar_service.study.plotting import png_bytes, svg_text
from radar_service.study.stability.figure import finding_figure
from tests.study.stability.run import finding_of


@pytest.mark.sample(6)
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


def test_the_same_finding_gives_the_same_bytes() -> None:
    first, second = (finding_figure(finding_of("missed_sizes")) for _ in range(2))
    assert png_bytes(first) == png_bytes(second) and svg_text(first) == svg_text(second)

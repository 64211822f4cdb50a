"""The report of all findings: one page of HTML without other files, and JSON."""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from radar_service.study.plotting import COLOURS, LIMIT, new_figure, number, style, svg_text
from radar_service.study.stability.finding import RESPONSES, Axis, Finding
from radar_service.terminal import html_page, make_folder, write_file

HEIGHT, LEGEND_ROW = 3.0, 0.2  # inches
COLUMNS = 3  # of the legend
DASHES = ("-", "--", ":", "-.", (0, (1, 3)), (0, (8, 3)))
MAX_TICKS = 9


def write_report(folder: Path, findings: Sequence[Finding]) -> None:
    """Writes stability.html and stability.json to `folder`, which it creates if necessary. Raises OSError."""
    make_folder(folder)
    write_file(folder / "stability.json", json.dumps([*map(asdict, findings)], indent=1) + "\n")
    write_file(folder / "stability.html", page(findings))


def page(findings: Sequence[Finding]) -> str:
    """Returns the report as HTML."""
    return html_page(
        "study/stability/report.html", findings=findings, responses=RESPONSES, svg=_svg, boundary_text=boundary_text,
        number=number, count=Counter(finding.response for finding in findings),
    )  # fmt: skip


def boundary_text(finding: Finding) -> str:
    """Returns where the method fails, in words."""
    if finding.boundary is None:
        return f"{finding.parameter.label}: nowhere from {number(finding.values[0])} to {number(finding.values[-1])}"
    return f"{finding.parameter.label} = {number(finding.boundary)}"


def _svg(finding: Finding) -> str:
    """The figure of a finding, an SVG in base 64."""
    return b64encode(svg_text(finding_figure(finding)).encode()).decode()


def finding_figure(finding: Finding) -> Figure:
    """Returns the figure of a finding; its legend lies below the axes."""
    rows = -(-(len(finding.curves) + 1 + (finding.boundary is not None)) // COLUMNS)
    with style():
        figure = new_figure(HEIGHT + LEGEND_ROW * rows)
        axes = figure.add_subplot()
        for k, curve in enumerate(finding.curves):
            axes.plot(finding.values, curve.values, linestyle=DASHES[k], color=COLOURS[k], label=curve.name)
        _set_axes(axes, finding)
        axes.axhline(finding.limit, color=LIMIT, linewidth=1.0, linestyle=(0, (2, 2)), label="limit")
        if finding.boundary is not None:
            axes.axvline(finding.boundary, color="black", linewidth=1.0, label=f"boundary, {number(finding.boundary)}")
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.06, 0.0), ncols=COLUMNS, handlelength=3.0)
        bottom = (0.62 + LEGEND_ROW * rows) / (HEIGHT + LEGEND_ROW * rows)
        figure.subplots_adjust(left=0.1, right=0.98, top=0.96, bottom=bottom)
    return figure


def _set_axes(axes: Axes, finding: Finding) -> None:
    """Sets scales, limits, ticks and titles."""
    values = np.array([curve.values for curve in finding.curves])
    shown = values[values > 0] if finding.measured.log else values
    limit = [finding.limit] if finding.limit > 0 or not finding.measured.log else []
    for axis, set_scale, set_limits, quantity, ends in (
        (axes.xaxis, axes.set_xscale, axes.set_xlim, finding.parameter, _ends(finding.parameter, np.array(finding.values))),
        (axes.yaxis, axes.set_yscale, axes.set_ylim, finding.measured, _ends(finding.measured, np.append(shown, limit))),
    ):
        if quantity.log:
            set_scale("log")
            axis.set_major_locator(LogLocator(numticks=MAX_TICKS))
            axis.set_minor_formatter(NullFormatter())
        else:
            axis.set_major_locator(MaxNLocator(MAX_TICKS, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
        set_limits(*ends)
        axis.set_label_text(quantity.label)


def _ends(axis: Axis, values: np.ndarray) -> tuple[float, float]:
    """Returns the ends of an axis, beyond the values by 4 %."""
    low, high = float(values.min()), float(values.max())
    if axis.log:
        margin = max((high / low) ** 0.04, 1.2)
        return low / margin, high * margin
    margin = 0.04 * (high - low) or 1.0
    return low - margin, high + margin

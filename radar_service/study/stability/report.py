"""The report of all findings: one page of HTML without other files, and JSON."""

import json
from base64 import b64encode
from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from radar_service.study.plotting import COLOURS, LIMIT, new_figure, number, style, svg_text
from radar_service.study.stability.finding import RESPONSES, Axis, Finding
from radar_service.terminal.output_files import make_folder, write_file

STYLE = """
body{font:16px/1.45 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#1b1b1b;background:#fff}
table{border-collapse:collapse;width:100%;font-size:14px}
a{color:#0b57b0}td,th{text-align:left;padding:.3em .6em;border-bottom:1px solid #ddd;vertical-align:top}
section{margin-top:2.6em}img{width:100%;max-width:830px;height:auto}h2{margin-bottom:.1em}p{margin:.4em 0}
@media(prefers-color-scheme:dark){a{color:#8ab8ff}body{color:#ddd;background:#161616}td,th{border-color:#333}}
"""
INTRODUCTION = (
    "Each study drives one parameter until a method fails. The table names the method, where it fails, and what the service "
    "uses or does instead. In a figure the dotted line is the limit of the error. The upright line is the boundary, where the "
    "method passes the limit."
)

HEIGHT, LEGEND_ROW = 3.0, 0.2  # inches
COLUMNS = 3  # of the legend
DASHES = ("-", "--", ":", "-.", (0, (1, 3)), (0, (8, 3)))
MAX_TICKS = 9


def write_report(folder: Path, findings: Sequence[Finding]) -> None:
    """Writes stability.html and stability.json to `folder`, which it creates if necessary. Raises OSError."""
    make_folder(folder)
    write_file(folder / "stability.json", json.dumps([finding.as_dict() for finding in findings], indent=1) + "\n")
    write_file(folder / "stability.html", page(findings))


def page(findings: Sequence[Finding]) -> str:
    """Returns the report as HTML."""
    count = Counter(finding.response for finding in findings)
    overview = "".join(f"<li>{count[key]}: {meaning}</li>" for key, meaning in RESPONSES.items() if count[key])
    rows = "".join(_row(k, finding) for k, finding in enumerate(findings))
    head = "<tr><th>region</th><th>method</th><th>where it fails</th><th>in the service</th></tr>"
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Where methods fail</title>"
        f"<meta name='viewport' content='width=device-width'><style>{STYLE}</style></head><body><h1>Where methods fail</h1>"
        f"<p>{INTRODUCTION}</p><p>{len(findings)} regions:</p><ul>{overview}</ul><table>{head}{rows}</table>"
        f"{''.join(_sections(findings))}</body></html>"
    )


def boundary_text(finding: Finding) -> str:
    """Returns where the method fails, in words."""
    if finding.boundary is None:
        return f"{finding.parameter.label}: nowhere from {number(finding.values[0])} to {number(finding.values[-1])}"
    return f"{finding.parameter.label} = {number(finding.boundary)}"


def _row(k: int, finding: Finding) -> str:
    region = f"<a href='#r{k}'>{escape(finding.name)}</a>"
    cells = (region, escape(finding.method), escape(boundary_text(finding)), escape(finding.instead))
    return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _sections(findings: Sequence[Finding]) -> Iterator[str]:
    for k, finding in enumerate(findings):
        yield (
            f"<section id='r{k}'><h2>{escape(finding.name)}</h2><p>Setup: {escape(finding.setup)}.</p>{_image(finding)}"
            f"<p>Method: {escape(finding.method)}. Limit: {escape(finding.limit_reason)}. "
            f"Where it fails: {escape(boundary_text(finding))}. {escape(_expected_text(finding))}</p>"
            f"<p><b>In the service: {escape(finding.instead)}.</b> {escape(finding.details)}</p></section>"
        )


def _expected_text(finding: Finding) -> str:
    expected = finding.expected
    return "" if expected.boundary is None else f"Expected: {number(expected.boundary)}; {expected.origin}."


def _image(finding: Finding) -> str:
    data = b64encode(svg_text(finding_figure(finding)).encode()).decode()
    return f"<img alt='{escape(f'{finding.name}: {finding.setup}', quote=True)}' src='data:image/svg+xml;base64,{data}'>"


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

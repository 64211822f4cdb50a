"""The report of a test bench as one HTML page: verdicts with their sources, tracks over the map, error over time."""

import base64
import html
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from radar_service.bench.ppi_picture import image_of
from radar_service.bench.trackers.tracker import distance_at
from radar_service.numerics.types import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MIN_HALF_WIDTH = 100.0  # m, of the map
UNITS = {"_m_s": "m/s", "_m": "m", "_deg": "degrees", "_kn": "kn", "_nm": "NM", "_min": "min", "_s": "s"}  # by endings
MINUTES = ("_1min", "_3min")  # after which a metric of motion is judged
MAX_FAILURES = 5  # of a scenario that are listed
MAX_NAMES = 8  # of targets in a legend: more leave no room for the map

STYLE = (
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;margin:.6rem 0}td,th{border:1px solid #999;padding:.25rem .6rem;text-align:left}"
    ".pass{background:#d8f0d8}.fail{background:#f6d0d0}.undecided{background:#f7ecc4}.no{background:#d8f0d8}img{max-width:100%}"
)


def write_report(report: Mapping[str, Any], runs: Mapping[str, Sequence[Mapping[str, Any]]], folder: Path) -> None:
    """Writes report.json and report.html. runs: by scenario, of which the first is drawn. Raises OSError."""
    (folder / "report.json").write_text(json.dumps(report, indent=1, allow_nan=False), encoding="utf-8")
    (folder / "report.html").write_text(page(report, runs), encoding="utf-8")


def page(report: Mapping[str, Any], runs: Mapping[str, Sequence[Mapping[str, Any]]]) -> str:
    """Returns the page."""
    sections = "".join(_section(scenario, runs[scenario["name"]][0]) for scenario in report["scenarios"])
    return page_of(f"Test bench: {html.escape(report['tracker'])}", sections)


def page_of(title: str, content: str) -> str:
    """Returns a page; title and content are HTML."""
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
        f"<h1>{title}</h1>{content}</html>\n"
    )


def comparison(report: Mapping[str, Any], compared: Mapping[str, Any]) -> str:
    """Returns a table of the metrics of two reports, scenario by scenario, as text."""
    others = {scenario["name"]: scenario for scenario in compared["scenarios"]}
    lines = [f"{'scenario':32} {'metric':26} {report['tracker'][-14:]:>14} {compared['tracker'][-14:]:>14}"]
    for scenario in report["scenarios"]:
        second = others.get(scenario["name"], {"metrics": {}})
        for metric, value in scenario["metrics"].items():
            lines.append(
                f"{scenario['name'][:32]:32} {metric[:26]:26} {_number(value):>14} {_number(second['metrics'].get(metric)):>14}"
            )
    return "\n".join(lines) + "\n"


def verdict_table(report: Mapping[str, Any]) -> str:
    """Returns a table of the verdicts as text: a limit's metric, its value that 95 % of runs keep, bound, unit; then remarks."""
    lines = [f"{'scenario':26} {'metric':28} {'95 % value':>10} {'limit':>16} {'unit':8} {'missed':>9}  verdict"]
    for scenario in report["scenarios"]:
        for verdict in scenario["verdicts"]:
            missed = f"{verdict['failures']} of {verdict['runs']}"
            lines.append(
                f"{scenario['name'][:26]:26} {verdict['metric'][:28]:28} {_number(verdict['value_95']):>10} "
                f"{bound_of(verdict):>16} {unit_of(verdict['metric']):8} {missed:>9}  {verdict['word']}"
            )
    lines += [f"{scenario['name']}: remark: {scenario['remark']}" for scenario in report["scenarios"] if scenario["remark"]]
    lines += failure_lines(report)
    return "\n".join(lines) + "\n"


def failure_lines(report: Mapping[str, Any]) -> list[str]:
    """Returns a line for each failed run, of the first MAX_FAILURES of a scenario, and how many more there are."""
    lines = []
    for scenario in report["scenarios"]:
        failures = scenario["failures"]
        lines += [f"{scenario['name']}, seed {failure['seed']}: {_failure(failure)}" for failure in failures[:MAX_FAILURES]]
        lines += (
            [f"{scenario['name']}: {len(failures) - MAX_FAILURES} more failed runs"] if len(failures) > MAX_FAILURES else []
        )
    return lines


def _failure(failure: Mapping[str, Any]) -> str:
    """How a run failed: where, what is wrong, the exit status and the last line of the standard error."""
    at = "not started" if failure["scan"] is None else f"failed at scan {failure['scan']}"
    status = "" if failure["status"] is None else f"; exit status {failure['status']}"
    return f"{at}: {failure['message']}{status}" + (f"; it said: {failure['stderr']}" if failure["stderr"] else "")


def unit_of(metric: str) -> str:
    """Returns the unit of a metric, which its name ends with or has before a time as in `_1min`; empty for a number."""
    name = metric.rsplit("_", 1)[0] if metric.endswith(MINUTES) else metric
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")


def bound_of(verdict: Mapping[str, Any]) -> str:
    """Returns the bound of a limit in words."""
    return f"at most {verdict['maximum']:g}" if verdict["maximum"] is not None else f"at least {verdict['minimum']:g}"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g}"


def _section(scenario: Mapping[str, Any], run: Mapping[str, Any]) -> str:
    text = {key: html.escape(str(scenario[key])) for key in ("name", "question", "expected", "source")}
    remark = f"<p>Remark: {html.escape(scenario['remark'])}</p>" if scenario["remark"] else ""
    failed = "".join(f"<li>{html.escape(line)}</li>" for line in failure_lines({"scenarios": [scenario]}))
    metrics = "".join(
        f"<tr><td>{name}</td><td>{_number(scenario['metrics'][name])}</td>"
        f"<td>{_number(scenario['percentile_95'][name])}</td></tr>"
        for name in scenario["metrics"]
    )
    return (
        f"<h2>{text['name']}</h2><p>{text['question']} Expected: {text['expected']} ({text['source']})</p>{remark}"
        f"<ul>{failed}</ul>"
        f"<table><tr><th>limit</th><th>95 % value</th><th>runs that miss it</th><th>verdict</th><th>source</th></tr>"
        f"{''.join(map(_verdict_row, scenario['verdicts']))}</table>"
        f"{_picture(run)}"
        f"<details><summary>all metrics</summary><table><tr><th>metric</th><th>mean</th><th>95th percentile</th></tr>{metrics}"
        f"</table></details>"
    )


def _picture(run: Mapping[str, Any]) -> str:
    """The picture of a run; nothing of one that gave no scan."""
    if not run["scans"]:
        return ""
    return f'<img alt="plots, tracks and truth over the PPI of the last scan" src="data:image/png;base64,{_figure(run)}">'


def _verdict_row(verdict: Mapping[str, Any]) -> str:
    limit = f"{html.escape(verdict['metric'])} {bound_of(verdict)} {unit_of(verdict['metric'])}"
    return (
        f"<tr><td>{limit}</td><td>{_number(verdict['value_95'])}</td>"
        f'<td>{verdict["failures"]} of {verdict["runs"]}</td><td class="{verdict["word"].split()[0]}">{verdict["word"]}</td>'
        f"<td>{html.escape(verdict['source'])}</td></tr>"
    )


def _figure(run: Mapping[str, Any]) -> str:
    """Plots, tracks and truth over the PPI of the last scan, and how far the nearest track is over time; a PNG in base 64."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    chart, errors = figure.subplots(1, 2)
    scans = run["scans"]
    plots = _points(scan["plots"] for scan in scans)
    chart.plot(*plots.T, ".", color="0.6", markersize=2, label="plots")
    names = sorted({truth["body"] for scan in scans for truth in scan["truths"]})
    for k, name in enumerate(names):
        truths = [(scan, truth) for scan in scans for truth in scan["truths"] if truth["body"] == name]
        path = np.array([truth["position"] for _, truth in truths])
        label = name if len(names) <= MAX_NAMES else "_" if k else f"{len(names)} targets"  # "_": not in the legend
        (line,) = chart.plot(*path.T, linewidth=3.0, alpha=0.5, label=label)
        nearest = [(truth["time"], _nearest(truth, scan["tracks"])) for scan, truth in truths]
        errors.plot(*np.array(nearest, dtype=float).T, color=line.get_color())
    tracks = _points([[track["east"], track["north"]] for track in scan["tracks"]] for scan in scans)
    chart.plot(*tracks.T, ".", color="black", markersize=3, label="tracks")
    own = _points([scan["own"]] for scan in scans)
    chart.plot(*own.T, color="red", linewidth=1.0)
    chart.plot(*own[-1:].T, "^", color="red", markersize=6, label="own ship")
    if run.get("ppi"):
        _draw_ppi(chart, run["ppi"], own[-1])
    of_interest = np.concatenate([own, tracks, _points([truth["position"] for truth in scan["truths"]] for scan in scans)])
    _zoom(chart, of_interest, own[-1])
    chart.legend(fontsize="small")
    errors.set(xlabel="time [s]", ylabel="distance of the nearest track [m]", yscale="log")
    return png_text(figure)


def png_text(figure: "Figure") -> str:
    """Returns a figure as a PNG in base 64."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    return base64.b64encode(buffer.getvalue()).decode()


def _draw_ppi(chart: "Axes", ppi: dict[str, Any], centre: Floats) -> None:
    """Draws the PPI of the last scan about own ship (2,) behind all else; echoes are dark."""
    (east, north), reach = centre, ppi["range"]
    extent = (east - reach, east + reach, north - reach, north + reach)
    chart.imshow(image_of(ppi), cmap="Greys", vmin=0.0, vmax=1.5, extent=extent, interpolation="nearest", zorder=0)


def _points(scans: Iterable[Sequence[Sequence[float]]]) -> Floats:
    """All points (K, 2) of scans."""
    return np.array([point for points in scans for point in points], dtype=np.float64).reshape(-1, 2)


def _zoom(chart: "Axes", points: Floats, centre: Floats) -> None:
    """Shows points (K, 2), whatever false plots lie elsewhere, with range rings about a centre (2,)."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    half = max(0.55 * float(np.ptp(points, axis=0).max()), MIN_HALF_WIDTH)
    chart.set(
        xlabel="east [m]", ylabel="north [m]", aspect="equal", xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
    )  # fmt: skip
    step = 10.0 ** math.floor(math.log10(half))
    bearing = np.linspace(0.0, 2.0 * np.pi, 181)
    for ring in step * np.arange(1, math.ceil(4.0 * half / step)):
        chart.plot(
            *(centre[:, None] + ring * np.stack([np.sin(bearing), np.cos(bearing)])), color="0.85", linewidth=0.6, zorder=0
        )


def _nearest(truth: Mapping[str, Any], tracks: Sequence[Mapping[str, Any]]) -> float:
    """Distance [m] of the nearest track at its own time; nan without tracks."""
    distances = [
        distance_at(
            (track["east"], track["north"]), track["time"], truth["position"], truth["velocity"], truth["time"]
        )
        for track in tracks
    ]  # fmt: skip
    return min(distances, default=math.nan)

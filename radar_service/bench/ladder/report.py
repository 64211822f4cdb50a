"""The report of ladders: the leaderboard, and for each ladder a picture of its curves and a table, as a page and as text."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from radar_service.bench.report import table, unit_of
from radar_service.bench.run_picture import png_text
from radar_service.terminal import html_page, write_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Data = Mapping[str, Any]  # plain data


def write_ladders(report: Data, folder: Path) -> None:
    """Writes report.json and report.html. Raises OSError."""
    write_file(folder / "report.json", json.dumps(report, indent=1, allow_nan=False))
    write_file(folder / "report.html", page(report))


def page(report: Data) -> str:
    """Returns the page."""
    return html_page(
        "bench/ladder/report.html", report=report, method=method(report), curves=curves, sentence=_sentence, title=_title,
        cell=_cell, value_text=_value,
    )  # fmt: skip


def method(report: Data) -> str:
    """Returns what places and intervals mean, as sentences."""
    return (
        f"{report['seeds']} seeds of each rung give the same plots to all trackers. A place is 1 and the number of trackers that "
        f"are known to be better; equal ones are told apart with a chance of {100.0 * report['level']:g} % at most. Intervals "
        f"have 95 %."
    )


def text_of(report: Data) -> str:
    """Returns the leaderboard and the ladders as text."""
    ladders = "".join(_ladder_text(ladder) for ladder in report["ladders"])
    return f"{method(report)}\n\n{_board_text(report, 'all ladders, share of the worst')}{ladders}"


def _board_text(board: Data, title: str) -> str:
    heads = {"place": "place", "tracker": "tracker", "mean": "mean", "low": "from", "high": "to"}
    rows = [
        (row["place"], row["tracker"][-32:], *(f"{row[key]:.4g}" for key in [*heads][2:])) for row in board["leaderboard"]
    ]
    lines = [title, *table("{:>5}  {:32} {:>9} {:>9} {:>9}", [[*heads.values()], *rows])]
    return "\n".join([*lines, *(f"    {_sentence(pair)}" for pair in board["pairs"])]) + "\n"


def _ladder_text(ladder: Data) -> str:
    heads = "".join(f"{_value(value):>12}" for value in ladder["values"])
    lines = [f"\n{_board_text(ladder, _title(ladder))}  {ladder['difficulty'][:36]:36}{heads}"]
    for row in ladder["trackers"]:
        cells = "".join(f"{_cell(rung):>12}" for rung in row["rungs"])
        failed = f"  {row['failed_runs']} failed runs" if row["failed_runs"] else ""
        lines.append(f"  {row['tracker'][-36:]:36}{cells}{failed}")
    return "\n".join(lines) + "\n"


def _title(ladder: Data) -> str:
    return f"{ladder['name']}: {_metric(ladder)}, mean of all rungs"


def _metric(ladder: Data) -> str:
    return f"{ladder['metric']} [{unit_of(ladder['metric']) or '1'}]"


def _cell(rung: Data) -> str:
    """The figure of a rung, with + where it is better and - where it is worse than that of the reference."""
    return f"{rung['mean']:.4g}{ {'better': ' +', 'worse': ' -', None: '  '}[rung['word']] }"


def _sentence(pair: Data) -> str:
    return f"{pair['sentence']} (p = {pair['p']:.2g})"


def _value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def curves(ladder: Data) -> str:
    """Returns the picture of a ladder, as `png_text`: the figure of each tracker by rung, with its interval."""

    def draw(figure: "Figure") -> None:
        chart = figure.subplots()
        for number, row in enumerate(ladder["trackers"]):
            _draw(chart, row["tracker"], row["rungs"], number, len(ladder["trackers"]))
        chart.axhline(ladder["worst"], color="0.6", linestyle=":", label="worst")
        chart.set_xticks(range(len(ladder["values"])), [_value(value) for value in ladder["values"]])
        chart.set(xlabel=f"{ladder['difficulty']}, harder to the right", ylabel=_metric(ladder), yscale=scale_of(ladder))
        chart.legend(fontsize="small")

    return png_text((9.0, 4.5), draw)


def scale_of(ladder: Data) -> str:
    """Returns the scale of the axis of figures: logarithmic where none is 0."""
    return "log" if all(rung["mean"] > 0.0 for row in ladder["trackers"] for rung in row["rungs"]) else "linear"


def _draw(chart: "Axes", tracker: str, rungs: Sequence[Data], number: int, count: int) -> None:
    """The curve of a tracker, a little beside those of others so that intervals do not cover each other."""
    at = [k + 0.05 * (number - (count - 1) / 2.0) for k in range(len(rungs))]
    means = [rung["mean"] for rung in rungs]
    reach = [
        [max(rung["mean"] - rung["low"], 0.0) for rung in rungs], [max(rung["high"] - rung["mean"], 0.0) for rung in rungs]
    ]  # fmt: skip
    chart.errorbar(at, means, yerr=reach, fmt="o-", markersize=4, linewidth=1.2, capsize=3, label=tracker[-40:])

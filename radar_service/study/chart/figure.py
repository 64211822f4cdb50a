"""The chart as a figure, for each panel error against CPU time per azimuth, and in words: a short list of results for each."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from radar_service.study.chart.point import Point, pareto
from radar_service.study.plotting import COLOURS, LIMIT, SMALL, TEXT, WIDTH, duration, new_figure, percent, style

MARKERS = ("o", "s", "^", "D", "v", "h", "p", "X")
FRONT = "#c4c4c4"
HEAD, ABOVE, BELOW = 0.5, 0.36, 0.5  # inches: title of the figure; above and below the axes of each panel
LEFT, RIGHT, NOTES = 0.68, 5.7, 5.85  # inches: the axes, and the column of legend and summary
TALL, SHORT = 3.0, 2.2  # inches: height of axes with many points, and with few
MAX_SHORT = 8  # points on short axes
LETTERS = 39  # of a line of the summary
MARK = 7.0  # points: size of a mark
BAND = 3.0  # factor between the ends of the band of points without error, on a logarithmic axis
BUDGET_DB = -40.0  # default error budget of the field
UNDER_WAY = " under way"
TITLES = {"field": "Signal chain", "power": "Samplers", "scattering": "Scattering models"}


@dataclass(frozen=True)
class Panel:
    """One set of axes. ylabel: the error, with its unit; lowest: smaller errors are drawn here [dB]; notes: lines of the summary;
    log: whether the error has a logarithmic axis."""

    title: str
    ylabel: str
    points: Sequence[Point]
    lowest: float
    notes: Sequence[str]
    log: bool = False

    @property
    def height(self) -> float:
        """Height of the axes [inches]."""
        return TALL if len(self.points) > MAX_SHORT else SHORT

    @property
    def families(self) -> list[str]:
        """Names of the methods, in order."""
        return list(dict.fromkeys(point.family for point in self.points))

    @property
    def all_met(self) -> bool:
        """Whether every point has an error."""
        return all(point.total_error_db is not None for point in self.points)

    def error(self, point: Point) -> float | None:
        """The error of a point on the chart [dB], or None."""
        return None if point.total_error_db is None else max(point.total_error_db, self.lowest)


def chart_figure(scene: str, machine: str, panels: Sequence[Panel], real_time: float) -> Figure:
    """Returns the figure of the panels, one below the other; real_time: time of one azimuth at the scene's rpm [s]."""
    height = HEAD + sum(ABOVE + panel.height + BELOW for panel in panels)
    with style():
        figure = new_figure(height)
        figure.text(0.1 / WIDTH, 1 - 0.22 / height, f'Speed against accuracy on "{scene}"', fontsize=12, weight="bold")
        figure.text(0.1 / WIDTH, 1 - 0.42 / height, f"Lower left is better. {machine}", fontsize=SMALL, color=TEXT)
        top = height - HEAD
        for panel in panels:
            bottom = top - ABOVE - panel.height
            axes = figure.add_axes((LEFT / WIDTH, bottom / height, (RIGHT - LEFT) / WIDTH, panel.height / height))
            _draw_panel(axes, panel, real_time)
            _draw_notes(axes, panel)
            top = bottom - BELOW
    return figure


def _draw_panel(axes: Axes, panel: Panel, real_time: float) -> None:
    _set_scales(axes, panel, real_time)
    front = [(p.seconds, panel.error(p)) for p in pareto(panel.points)]
    axes.plot(*zip(*front, strict=True), color=FRONT, linewidth=4.5, zorder=1, solid_capstyle="round")
    axes.axvline(real_time, color=LIMIT, linewidth=1.2, linestyle="--", zorder=1)
    _write(axes, "slower than real time", (real_time, axes.get_ylim()[0]), LIMIT, 5)
    for point in panel.points:
        _draw_point(axes, panel, point)


def _set_scales(axes: Axes, panel: Panel, real_time: float) -> None:
    times = [t for p in panel.points for t in p.times] + [real_time]
    axes.set_xscale("log")
    axes.set_xlim(min(times) / 2.5, max(times) * 2.5)
    errors = [error for p in panel.points if (error := panel.error(p)) is not None] or [panel.lowest]
    if panel.log:
        axes.set_yscale("log")
        axes.set_ylim(min(errors) / 2.0, max(errors) * (3.0 if panel.all_met else 3.0 * BAND))
        numbers = axes.get_ylim()[1] / (1.0 if panel.all_met else BAND)
        axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}" if y <= numbers else ""))
        axes.yaxis.set_minor_formatter(NullFormatter())
        if not panel.all_met:
            _draw_band(axes)
    else:
        margin = 0.08 * (max(errors) - min(errors)) + 5.0
        axes.set_ylim(min(errors) - margin, max(errors) + margin)
    axes.set_title(panel.title)
    axes.set_xlabel("CPU time per azimuth")
    axes.set_ylabel(panel.ylabel)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: duration(x)))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _draw_band(axes: Axes) -> None:
    """Draws the band at the top, in which points without error lie."""
    high = axes.get_ylim()[1]
    axes.axhspan(high / BAND, high, facecolor="#f0f0f0", zorder=0)
    axes.annotate("no target\nmet", (0.0, high / BAND**0.5), (-6, 0), ("axes fraction", "data"), "offset points",
                  fontsize=SMALL, ha="right", va="center")  # fmt: skip


def _draw_point(axes: Axes, panel: Panel, point: Point) -> None:
    """Draws a point, one without error in the band at the top; presets have their setting beside."""
    family, error = panel.families.index(point.family), panel.error(point)
    colour, y = COLOURS[family % len(COLOURS)], axes.get_ylim()[1] / BAND**0.5 if error is None else error
    axes.plot([min(point.times), max(point.times)], [y, y], color=colour, linewidth=1.4, zorder=2)
    axes.plot([point.seconds], [y], zorder=3, **_mark(family, _hollow(point)))
    if point.preset:
        below = point.preset.endswith(UNDER_WAY)  # so that it lies apart from that of the preset at rest
        _write(axes, f"{point.setting} = {point.preset}", (point.seconds, y), "black", -14 if below else 5)


def _write(axes: Axes, text: str, place: tuple[float, float], colour: str, up: float) -> None:
    """Writes a text beside a place, on the side that has more room. up: how far above it [points]."""
    is_left = axes.transAxes.inverted().transform(axes.transData.transform(place))[0] < 0.5
    axes.annotate(text, place, (8 if is_left else -8, up), textcoords="offset points", fontsize=SMALL, color=colour,
                  ha="left" if is_left else "right", zorder=5)  # fmt: skip


def _hollow(point: Point) -> bool:
    return point.extrapolated or not point.reliable


def _mark(family: int, may_rebounce: bool) -> dict[str, Any]:
    colour = COLOURS[family % len(COLOURS)]
    return {"marker": MARKERS[family % len(MARKERS)], "color": colour, "markerfacecolor": "white" if may_rebounce else colour,
            "markersize": MARK, "linestyle": "none"}  # fmt: skip


def _draw_notes(axes: Axes, panel: Panel) -> None:
    """Draws legend and summary in the column right of the axes."""
    handles = [Line2D([], [], label=family, **_mark(k, False)) for k, family in enumerate(panel.families)]
    handles.append(Line2D([], [], color=FRONT, linewidth=4.5, label="Pareto front"))
    if any(_hollow(point) for point in panel.points):
        words = "time scaled from fewer echoes" if panel.points[0].panel == "field" else "misses over 5 % of its targets"
        handles.append(Line2D([], [], label=f"hollow: {words}", marker="o", color=TEXT, markerfacecolor="white",
                              linestyle="none"))  # fmt: skip
    column = (NOTES - LEFT) / (RIGHT - LEFT)
    legend = axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(column, 1.0), borderaxespad=0.0, borderpad=0.0)
    below = axes.transAxes.inverted().transform(legend.get_window_extent().p0)[1] - 0.12 / panel.height
    lines = "\n".join(fill(note, LETTERS, initial_indent="• ", subsequent_indent="   ") for note in panel.notes)
    axes.text(column, below, lines, transform=axes.transAxes, fontsize=SMALL, va="top", linespacing=1.35)


def summary(points: Sequence[Point], real_time: float) -> dict[str, list[str]]:
    """Returns the lines of each panel that has points; real_time: time of one azimuth at the scene's rpm [s]."""
    field, power, models = ([p for p in points if p.panel == panel] for panel in TITLES)
    lines = {"field": _field(field, real_time), "power": _samplers(power), "scattering": [_model(p) for p in models]}
    return {panel: panel_lines for panel, panel_lines in lines.items() if panel_lines}


def summary_text(lines: dict[str, list[str]]) -> str:
    """Returns the summary as text: a title for each panel and one line for each result."""
    return "".join(f"{TITLES[panel]}\n" + "".join(f"- {line}\n" for line in lines[panel]) for panel in lines)


def _field(points: Sequence[Point], real_time: float) -> list[str]:
    moving = {p.preset.removesuffix(UNDER_WAY): p for p in points if p.preset and p.preset.endswith(UNDER_WAY)}
    lines = []
    for point in points:
        if point.preset and not point.preset.endswith(UNDER_WAY):
            other = moving.get(point.preset)
            lines.append(f"{point.preset}: {_error(point)}" + (f"; under way {_error(other)}" if other else ""))
    corrected = next((p for p in points if p.family == "integer-delay chirps" and not p.preset), None)
    if corrected is not None:
        lines.append(f"documented chain with corrected beam: {corrected.error_db or 0.0:.0f} dB")
    accurate = [p for p in pareto(points) if (p.error_db or 0.0) <= BUDGET_DB]
    if accurate:
        lines.append(f"fastest within {BUDGET_DB:g} dB: {_name(accurate[0])}, {_error(accurate[0])}")
    late = [p for p in points if p.seconds > real_time]
    if points:
        lines.append(f"slower than real time ({duration(real_time)}): {len(late)} of {len(points)} settings")
    return lines


def _samplers(points: Sequence[Point]) -> list[str]:
    lines = [f"{p.preset}: {_mean_and_spread(p)}, {duration(p.seconds)}" for p in points if p.preset]
    rays = [p for p in points if p.family.endswith("rays") and not p.preset and p.error_db is not None]
    if rays:
        best = min(rays, key=lambda p: (p.missed or 0.0, p.total_error_db or 0.0))
        lines.append(f"best rays, {_name(best)}: {_mean_and_spread(best)}, {duration(best.seconds)}")
    starved = [p for p in points if (p.missed or 0.0) > 0.5]
    if starved:
        lines.append(f"miss more than half of their targets: {len(starved)} of {len(points)} settings")
    return lines


def _model(point: Point) -> str:
    preset = f" = {point.preset}" if point.preset else ""
    return f"{point.family}, {point.setting}{preset}: {_mean_and_spread(point)}"


def _mean_and_spread(point: Point) -> str:
    missed = f", {percent(point.missed)} missed" if point.missed else ""
    if point.error_db is None or point.spread_db is None:
        return f"no target met{missed}"
    return f"mean {point.error_db:.2g} dB, spread {point.spread_db:.2g} dB{missed}"


def _name(point: Point) -> str:
    return f"{point.family} ({point.setting})"


def _error(point: Point) -> str:
    return f"{point.error_db or 0.0:.0f} dB in {duration(point.seconds)}"

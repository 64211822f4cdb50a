"""The chart as a figure: for each panel error against CPU time per azimuth, a legend and the summary."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import BboxBase

from radar_service.study.chart.point import Point, pareto
from radar_service.study.plotting import COLOURS, LIMIT, SMALL, TEXT, WIDTH, duration, new_figure, style

Position = tuple[float, float]
Box = tuple[float, float, float, float]  # left, bottom, right, top
MERGE = 0.9  # points closer than this many text heights in both directions share a label
RINGS = (0.9, 1.5, 2.4, 3.6, 5.0, 7.0, 9.0, 12.0)  # distances of a label from its point [text heights]
DIRECTIONS = 16
LEADER = 2.0  # a label farther than this [text heights] has a leader line
MARKERS = ("o", "s", "^", "D", "v", "h", "p", "X")
FRONT = "#c4c4c4"
HEAD, ABOVE, BELOW = 0.5, 0.36, 0.5  # inches: title of the figure; above and below the axes of each panel
LEFT, RIGHT, NOTES = 0.68, 5.7, 5.85  # inches: the axes, and the column of legend and summary
TALL, SHORT = 3.0, 2.2  # inches: height of axes with many points, and with few
MAX_SHORT = 8  # points on short axes
LETTERS = 39  # of a line of the summary
MARK = 7.0  # points: size of a mark
BAND = 3.0  # factor between the ends of the band of points without error, on a logarithmic axis


@dataclass(frozen=True)
class PlacedLabel:
    """A label: its middle, and the end of its leader line at the label, or None without a line."""

    position: Position
    box: Box
    leader: Position | None


def merge(points: Sequence[Point], positions: Sequence[Position], height: float) -> list[list[int]]:
    """Returns groups of indices of points that share a label: those of one family, or without error, at one position."""
    groups: list[list[int]] = []
    for k, point in enumerate(points):
        for group in groups:
            last = group[-1]
            distance = max(abs(positions[k][0] - positions[last][0]), abs(positions[k][1] - positions[last][1]))
            alike = points[last].family == point.family or points[last].error_db is point.error_db is None
            if alike and distance < MERGE * height:
                group.append(k)
                break
        else:
            groups.append([k])
    return sorted(groups, key=lambda group: all(points[k].preset is None for k in group))


def label_text(points: Sequence[Point]) -> str:
    """Returns the settings of points, a common unit once: "1.5, 6 beamwidths", and the presets with these settings."""
    units = {point.setting.rpartition(" ")[2] for point in points}
    common = len(units) == 1 and all(" " in point.setting for point in points)
    last = len(points) - 1
    texts = [_text(p, p.setting.rpartition(" ")[0] if common and k < last else p.setting) for k, p in enumerate(points)]
    return ", ".join(dict.fromkeys(texts))


def _text(point: Point, setting: str) -> str:
    return f"{point.setting} = {point.preset}" if point.preset else setting


def place_label(mark: Position, size: Position, height: float, frame: Box, taken: Sequence[Box]) -> PlacedLabel:
    """Returns the first position around a mark where a label of `size` lies in the frame and overlaps nothing.

    If there is none, it returns the position with the smallest overlap. All lengths are in pixels; height: of a line.
    """
    best: tuple[float, PlacedLabel] | None = None
    for x, y in _candidates(mark, size, height):
        box = (x - size[0] / 2, y - size[1] / 2, x + size[0] / 2, y + size[1] / 2)
        end = (min(max(mark[0], box[0]), box[2]), min(max(mark[1], box[1]), box[3]))
        label = PlacedLabel((x, y), box, end if hypot(end[0] - mark[0], end[1] - mark[1]) > LEADER * height else None)
        cost = _outside(box, frame) * height + sum(overlap(box, other) for other in taken)
        if cost == 0.0:
            return label
        if best is None or cost < best[0]:
            best = cost, label
    assert best is not None
    return best[1]


def _candidates(mark: Position, size: Position, height: float) -> Iterator[Position]:
    for ring in RINGS:
        for k in range(DIRECTIONS):
            across, up = cos(2 * pi * k / DIRECTIONS), sin(2 * pi * k / DIRECTIONS)
            distance = ring * height
            shift = (size[0] / 2 * max(-1.0, min(1.0, 1.5 * across)), size[1] / 2 * max(-1.0, min(1.0, 1.5 * up)))
            yield mark[0] + distance * across + shift[0], mark[1] + distance * up + shift[1]


def _outside(box: Box, frame: Box) -> float:
    beyond = (frame[0] - box[0], frame[1] - box[1], box[2] - frame[2], box[3] - frame[3])
    return sum(max(0.0, length) for length in beyond)


def overlap(box: Box, other: Box) -> float:
    """Returns the common area of two boxes."""
    width, height = min(box[2], other[2]) - max(box[0], other[0]), min(box[3], other[3]) - max(box[1], other[1])
    return max(0.0, width) * max(0.0, height)


@dataclass(frozen=True)
class Panel:
    """One set of axes.

    title: of the panel;
    ylabel: name of the error, with its unit;
    points: the points;
    lowest: smaller errors are drawn here [dB];
    notes: lines of the summary;
    log: whether the error has a logarithmic axis.
    """

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
    for point in panel.points:
        _draw_point(axes, panel, point)
    _draw_labels(axes, panel, real_time)


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


def _position(axes: Axes, panel: Panel, point: Point) -> Position:
    """Returns the data coordinates of a point; a point without error lies in the band at the top."""
    error = panel.error(point)
    return point.seconds, axes.get_ylim()[1] / BAND**0.5 if error is None else error


def _draw_point(axes: Axes, panel: Panel, point: Point) -> None:
    family = panel.families.index(point.family)
    colour, (_, y) = COLOURS[family % len(COLOURS)], _position(axes, panel, point)
    axes.plot([min(point.times), max(point.times)], [y, y], color=colour, linewidth=1.4, zorder=2)
    axes.plot([point.seconds], [y], zorder=3, **_mark(family, _hollow(point)))


def _hollow(point: Point) -> bool:
    return point.extrapolated or not point.reliable


def _mark(family: int, may_rebounce: bool) -> dict[str, Any]:
    colour = COLOURS[family % len(COLOURS)]
    return {"marker": MARKERS[family % len(MARKERS)], "color": colour, "markerfacecolor": "white" if may_rebounce else colour,
            "markersize": MARK, "linestyle": "none"}  # fmt: skip


def _draw_labels(axes: Axes, panel: Panel, real_time: float) -> None:
    """Writes the settings beside the points, where they overlap neither points nor lines nor other labels."""
    frame = _box(axes.get_window_extent())
    pixel = axes.get_figure().dpi / 72.0  # type: ignore[union-attr]
    limit = axes.transData.transform((real_time, axes.get_ylim()[0]))[0]
    marks = [tuple(axes.transData.transform(_position(axes, panel, p))) for p in panel.points]
    taken = _obstacles(axes, panel, marks, 0.5 * (MARK + 2.0) * pixel)
    taken.append((limit - pixel, frame[1], limit + pixel, frame[3]))
    taken.append(_write(axes, "slower than real time", (limit, frame[1] + 8 * pixel), LIMIT, frame, taken, pixel))
    for group in merge(panel.points, marks, SMALL * pixel):
        points = [panel.points[k] for k in group]
        bold = any(point.preset for point in points)
        taken.append(_write(axes, label_text(points), marks[group[0]], "black", frame, taken, pixel, bold))


def _obstacles(axes: Axes, panel: Panel, marks: Sequence[Position], half: float) -> list[Box]:
    """Returns boxes [pixels] around the marks, the ranges of times and the front; half: of the size of a mark."""
    boxes = [(x - half, y - half, x + half, y + half) for x, y in marks]
    for point, (_, y) in zip(panel.points, marks, strict=True):
        first, last = (axes.transData.transform((t, 1.0))[0] for t in (min(point.times), max(point.times)))
        boxes.append((first, y - half / 3, last, y + half / 3))
    front = axes.transData.transform([_position(axes, panel, point) for point in pareto(panel.points)])
    along = np.concatenate([np.linspace(a, b, 40) for a, b in zip(front, front[1:], strict=False)] or [front])
    return boxes + [(x - half / 3, y - half / 3, x + half / 3, y + half / 3) for x, y in along]


def _write(axes: Axes, text: str, mark: Position, colour: str, frame: Box, taken: Sequence[Box], pixel: float,
           bold: bool = False) -> Box:  # fmt: skip
    """Writes one label near a mark [pixels] and returns its box."""
    words = axes.text(0, 0, text, fontsize=SMALL, color=colour, weight="bold" if bold else "normal", ha="center", va="center",
                      zorder=5, transform=None)  # fmt: skip
    extent = words.get_window_extent()
    label = place_label(mark, (extent.width + 4 * pixel, extent.height), SMALL * pixel, frame, taken)
    to_axes = axes.transAxes.inverted()
    words.set_transform(axes.transAxes)
    words.set_position(tuple(to_axes.transform(label.position)))
    if label.leader is not None:
        ends = to_axes.transform([mark, label.leader])
        axes.plot(ends[:, 0], ends[:, 1], color="#8a8a8a", linewidth=0.6, zorder=2, transform=axes.transAxes)
    return label.box


def _box(extent: BboxBase) -> Box:
    x0, y0, x1, y1 = extent.extents
    return float(x0), float(y0), float(x1), float(y1)


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

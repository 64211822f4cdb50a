"""The chart: panels of points, error against time per azimuth, and what they say, as a sheet."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, floor, log10, pi, sin
from textwrap import wrap

from radar_service.study.chart.labels import Box, Marked, labels
from radar_service.study.chart.point import Point, pareto
from radar_service.study.chart.sheet import Line, Mark, Place, Sheet, Words

# Okabe and Ito (2008), told apart by the common colour blindnesses, without their yellow; every family has its own shape too
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#000000", "#56B4E9", "#777777")
SIDES = (
    (24, 0.0),
    (4, pi / 4),
    (3, 0.0),
    (4, 0.0),
    (3, pi),
    (6, 0.0),
    (5, 0.0),
    (5, pi),
)  # of each family's mark, and its turn
GRID, AXIS, FRONT, LIMIT = "#e2e2e2", "#444444", "#9a9a9a", "#b00020"
WIDTH, HEAD = 1240.0, 62.0
COLUMNS = 2
ROW, ABOVE, BELOW = 600.0, 44.0, 440.0  # height of a row of panels; where in it the axes begin and end
LETTERS, LINE = 88, 17.0  # of the reading: a line of it across a column, and how far it is to the next
SMALL, PLAIN, LARGE = 11.5, 13.0, 16.0


@dataclass(frozen=True)
class Panel:
    """One set of axes. lowest: of the errors [dB], drawn at the foot; logarithmic: decibels by decades."""

    title: str
    ordinate: str
    points: Sequence[Point]
    logarithmic: bool
    lowest: float


class Axes:
    """Where times [s] and errors [dB] lie on the sheet; top: of the row of panels."""

    def __init__(self, panel: Panel, left: float, right: float, top: float, real_time: float) -> None:
        times = [t for p in panel.points for t in p.times] + [real_time]
        self.low, self.high = floor(log10(min(times)) - 0.15), ceil(log10(max(times)) + 0.15)
        self.left, self.right, self.panel = left, right, panel
        self.top, self.bottom = top + ABOVE, top + BELOW
        found = [max(p.height, panel.lowest) for p in panel.points if p.height is not None] or [panel.lowest]
        self.bottom_error, self.top_error = _error_ends(found, panel.logarithmic)

    def across(self, seconds: float) -> float:
        """Page coordinate of a time per azimuth [s]."""
        return self.left + (log10(seconds) - self.low) / (self.high - self.low) * (self.right - self.left)

    def up(self, error_db: float | None) -> float:
        """Page coordinate of an error [dB]; one that has none stands at the top."""
        if error_db is None:
            return self.top + 8.0
        value = max(error_db, self.panel.lowest)
        if self.panel.logarithmic:
            share = log10(value / self.bottom_error) / log10(self.top_error / self.bottom_error)
        else:
            share = (value - self.bottom_error) / (self.top_error - self.bottom_error)
        return self.bottom - share * (self.bottom - self.top)

    def ticks(self) -> list[float]:
        """Errors that the scale names."""
        if not self.panel.logarithmic:
            return [float(db) for db in range(int(self.bottom_error), int(self.top_error) + 1, 10)]
        decades = range(round(log10(self.bottom_error)), round(log10(self.top_error)) + 1)
        return [10.0**k for k in decades]

    def place(self, point: Point) -> Place:
        """Where a point's mark stands."""
        return self.across(point.seconds), self.up(point.height)


def _error_ends(errors: Sequence[float], logarithmic: bool) -> tuple[float, float]:
    if logarithmic:
        return 10.0 ** floor(log10(min(errors)) - 0.05), 10.0 ** ceil(log10(max(errors)) + 0.15)
    return 10.0 * floor(min(errors) / 10.0 - 0.3), 10.0 * ceil(max(errors) / 10.0 + 0.3)


def chart_sheet(title: str, subtitle: str, panels: Sequence[Panel], real_time: float, reading: str) -> Sheet:
    """The sheet; real_time: seconds that one azimuth may take at the scene's rpm."""
    rows, free = divmod(len(panels), COLUMNS)
    breadth = WIDTH / COLUMNS
    beside = wrap(reading, LETTERS if free else LETTERS * COLUMNS)
    height = HEAD + ROW * (rows + (free > 0)) + (0.0 if free else LINE * (len(beside) + 2))
    sheet = Sheet(WIDTH, height)
    sheet.items += [Words((24.0, 26.0), title, LARGE, bold=True), Words((24.0, 46.0), subtitle, SMALL, colour=AXIS)]
    for k, panel in enumerate(panels):
        left, top = (k % COLUMNS) * breadth, HEAD + ROW * (k // COLUMNS)
        axes = Axes(panel, left + 74.0, left + breadth - 22.0, top, real_time)
        _scales(sheet, axes, real_time)
        _points(sheet, axes, real_time)
        _legend(sheet, axes)
    left, top = (breadth + 24.0 if free else 24.0), HEAD + ROW * rows
    sheet.items += [Words((left, top + ABOVE + LINE * k), line, PLAIN - 0.5) for k, line in enumerate(beside)]
    return sheet


def _scales(sheet: Sheet, axes: Axes, real_time: float) -> None:
    draw, left, right, top, bottom = sheet.items.append, axes.left, axes.right, axes.top, axes.bottom
    for error in axes.ticks():
        y = axes.up(error)
        draw(Line(((left, y), (right, y)), GRID))
        draw(Words((left - 8.0, y), f"{error:g}", SMALL, "end"))
    for decade in range(axes.low, axes.high + 1):
        x = axes.across(10.0**decade)
        draw(Line(((x, top), (x, bottom)), GRID))
        draw(Words((x, bottom + 14.0), duration(10.0**decade), SMALL, "middle"))
        draw(Words((x, top - 12.0), rate(10.0**-decade), SMALL, "middle", AXIS))
    draw(Line(((left, top), (left, bottom), (right, bottom)), AXIS))
    middle = (left + right) / 2.0
    draw(Words((middle, bottom + 34.0), "CPU time per azimuth", PLAIN, "middle"))
    draw(Words((right, top - 28.0), "azimuths per second", SMALL, "end", AXIS))
    draw(Words((left, top - 30.0), axes.panel.title, PLAIN, bold=True))
    draw(Words((left - 56.0, (top + bottom) / 2.0), axes.panel.ordinate, PLAIN, "middle", turned=True))
    x = axes.across(real_time)
    draw(Line(((x, top), (x, bottom)), LIMIT, 1.6, 6.0))
    draw(_too_slow(axes, x))
    if any(p.height is None for p in axes.panel.points):
        draw(Words((right, axes.up(None)), "never met a target", SMALL, "end", AXIS))


def _too_slow(axes: Axes, x: float) -> Words:
    """Words at the foot of the line of real time: right of it, or left where there is no room."""
    right, left = (
        Words((x + aside, axes.bottom - 10.0), "slower than real time", SMALL, anchor, LIMIT)
        for aside, anchor in ((5.0, "start"), (-5.0, "end"))
    )
    return right if right.box[2] < axes.right else left


def _points(sheet: Sheet, axes: Axes, real_time: float) -> None:
    points, draw = axes.panel.points, sheet.items.append
    front = [axes.place(p) for p in pareto(points)]
    if len(front) > 1:
        draw(Line(tuple(front), FRONT, 5.0))
    families = _families(points)
    limit = axes.across(real_time)
    taken: list[Box] = [(limit - 1.0, axes.top, limit + 1.0, axes.bottom), _too_slow(axes, limit).box]
    for point in points:
        _, y = axes.place(point)
        ends = axes.across(min(point.times)), axes.across(max(point.times))
        colour = COLOURS[families.index(point.family) % len(COLOURS)]
        draw(Line(((ends[0], y), (ends[1], y)), colour, 2.2))
        taken.append((ends[0], y - 4.0, ends[1], y + 4.0))
    for point in points:
        draw(_mark(axes.place(point), families.index(point.family), not point.scaled))
    marked = [Marked(point, axes.place(point)) for point in points]
    sheet.items += labels(marked, (axes.left, axes.top, axes.right, axes.bottom), taken)


def _legend(sheet: Sheet, axes: Axes) -> None:
    for k, family in enumerate(_families(axes.panel.points)):
        x, y = axes.left + (k % 2) * (axes.right - axes.left) / 2.0, axes.bottom + 64.0 + 21.0 * (k // 2)
        sheet.items += [_mark((x, y), k, True), Words((x + 14.0, y), family, PLAIN)]


def _families(points: Sequence[Point]) -> list[str]:
    return list(dict.fromkeys(p.family for p in points))


def _mark(place: Place, family: int, filled: bool) -> Mark:
    sides, turn = SIDES[family % len(SIDES)]
    radius = 5.2 if sides > 4 else 6.4
    corners = [2.0 * pi * k / sides + turn for k in range(sides)]
    outline = tuple((place[0] + radius * sin(a), place[1] - radius * cos(a)) for a in corners)
    return Mark(outline, COLOURS[family % len(COLOURS)], filled)


def duration(seconds: float) -> str:
    """A time for a person: 20 us, 3 ms, 1 s."""
    steps: Sequence[tuple[float, str]] = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"))
    size, unit = next((step for step in steps if seconds >= step[0] * 0.999), (1e-9, "ns"))
    return f"{seconds / size:.3g} {unit}"


def rate(per_second: float) -> str:
    """A rate for a person: 0.1, 50, 3,000."""
    return f"{per_second:.3g}" if per_second < 1.0 else f"{per_second:,.0f}"

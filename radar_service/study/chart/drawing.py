"""The chart: two panels of points, error against time per azimuth, as a sheet."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, floor, log10, pi, sin

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
WIDTH, HEIGHT = 1240.0, 700.0
TOP, BOTTOM = 104.0, 520.0
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
    """Where times [s] and errors [dB] lie on the sheet."""

    def __init__(self, panel: Panel, left: float, right: float, real_time: float) -> None:
        times = [t for p in panel.points for t in p.times] + [real_time]
        self.low, self.high = floor(log10(min(times)) - 0.15), ceil(log10(max(times)) + 0.15)
        self.left, self.right, self.panel = left, right, panel
        found = [max(p.height, panel.lowest) for p in panel.points if p.height is not None] or [panel.lowest]
        self.bottom_error, self.top_error = _error_ends(found, panel.logarithmic)

    def across(self, seconds: float) -> float:
        """Page coordinate of a time per azimuth [s]."""
        return self.left + (log10(seconds) - self.low) / (self.high - self.low) * (self.right - self.left)

    def up(self, error_db: float | None) -> float:
        """Page coordinate of an error [dB]; one that has none stands at the top."""
        if error_db is None:
            return TOP + 8.0
        value = max(error_db, self.panel.lowest)
        if self.panel.logarithmic:
            share = log10(value / self.bottom_error) / log10(self.top_error / self.bottom_error)
        else:
            share = (value - self.bottom_error) / (self.top_error - self.bottom_error)
        return BOTTOM - share * (BOTTOM - TOP)

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


def chart_sheet(title: str, subtitle: str, panels: Sequence[Panel], real_time: float) -> Sheet:
    """The sheet; real_time: seconds that one azimuth may take at the scene's rpm."""
    sheet = Sheet(WIDTH, HEIGHT)
    sheet.items += [Words((24.0, 26.0), title, LARGE, bold=True), Words((24.0, 48.0), subtitle, SMALL, colour=AXIS)]
    breadth = WIDTH / len(panels)
    for k, panel in enumerate(panels):
        axes = Axes(panel, k * breadth + 74.0, (k + 1) * breadth - 22.0, real_time)
        _scales(sheet, axes, real_time)
        _points(sheet, axes)
        _legend(sheet, axes)
    return sheet


def _scales(sheet: Sheet, axes: Axes, real_time: float) -> None:
    draw, left, right = sheet.items.append, axes.left, axes.right
    for error in axes.ticks():
        y = axes.up(error)
        draw(Line(((left, y), (right, y)), GRID))
        draw(Words((left - 8.0, y), f"{error:g}", SMALL, "end"))
    for decade in range(axes.low, axes.high + 1):
        x = axes.across(10.0**decade)
        draw(Line(((x, TOP), (x, BOTTOM)), GRID))
        draw(Words((x, BOTTOM + 14.0), duration(10.0**decade), SMALL, "middle"))
        draw(Words((x, TOP - 12.0), rate(10.0**-decade), SMALL, "middle", AXIS))
    draw(Line(((left, TOP), (left, BOTTOM), (right, BOTTOM)), AXIS))
    middle = (left + right) / 2.0
    draw(Words((middle, BOTTOM + 34.0), "CPU time per azimuth", PLAIN, "middle"))
    draw(Words((right, TOP - 28.0), "azimuths per second", SMALL, "end", AXIS))
    draw(Words((left, TOP - 30.0), axes.panel.title, PLAIN, bold=True))
    draw(Words((left - 56.0, (TOP + BOTTOM) / 2.0), axes.panel.ordinate, PLAIN, "middle", turned=True))
    x = axes.across(real_time)
    draw(Line(((x, TOP), (x, BOTTOM)), LIMIT, 1.6, 6.0))
    draw(Words((x + 5.0, BOTTOM - 10.0), "slower than real time", SMALL, "start", LIMIT))


def _points(sheet: Sheet, axes: Axes) -> None:
    points, draw = axes.panel.points, sheet.items.append
    front = [axes.place(p) for p in pareto(points)]
    if len(front) > 1:
        draw(Line(tuple(front), FRONT, 5.0))
    families = _families(points)
    taken: list[tuple[float, float, float, float]] = []
    for point in points:
        x, y = axes.place(point)
        colour = COLOURS[families.index(point.family) % len(COLOURS)]
        draw(Line(((axes.across(min(point.times)), y), (axes.across(max(point.times)), y)), colour, 2.2))
        taken.append((x - 7.0, y - 7.0, x + 7.0, y + 7.0))
        taken.append((axes.across(min(point.times)), y - 4.0, axes.across(max(point.times)), y + 4.0))
    for point in points:
        draw(_mark(axes.place(point), families.index(point.family), not point.scaled))
    for point in sorted(points, key=lambda p: p.preset is None):
        words = _label(axes, point, taken)
        taken.append(words.box)
        draw(words)


def _label(axes: Axes, point: Point, taken: Sequence[tuple[float, float, float, float]]) -> Words:
    """The setting, where it meets the fewest other things."""
    text = point.setting + (f" = {point.preset}" if point.preset else "")
    if point.missed:
        text += f", {percent(point.missed)} missed"
    x, y = axes.place(point)
    steps = [(11.0, 0.0, "start"), (0.0, -14.0, "middle"), (0.0, 14.0, "middle"), (-11.0, 0.0, "end"), (9.0, -12.0, "start"),
             (9.0, 12.0, "start"), (-9.0, -12.0, "end"), (-9.0, 12.0, "end"), (0.0, -26.0, "middle"), (0.0, 26.0, "middle"),
             (14.0, 24.0, "start"), (14.0, -24.0, "start")]  # fmt: skip
    choices = [Words((x + dx, y + dy), text, SMALL, anchor, bold=point.preset is not None) for dx, dy, anchor in steps]

    def cost(words: Words) -> float:
        left, top, right, bottom = words.box
        out = max(0.0, axes.left - left) + max(0.0, right - axes.right) + max(0.0, bottom - BOTTOM) + max(0.0, TOP - top)
        return out * 20.0 + sum(
            max(0.0, min(right, box[2]) - max(left, box[0])) * max(0.0, min(bottom, box[3]) - max(top, box[1]))
            for box in taken
        )

    return min(choices, key=cost)


def _legend(sheet: Sheet, axes: Axes) -> None:
    for k, family in enumerate(_families(axes.panel.points)):
        x, y = axes.left + (k % 2) * (axes.right - axes.left) / 2.0, BOTTOM + 64.0 + 21.0 * (k // 2)
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


def percent(share: float) -> str:
    """A share for a person."""
    return f"{100.0 * share:.3g} %"

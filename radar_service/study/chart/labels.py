"""Labels of the chart's points: their texts, and positions where they overlap nothing."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin

from radar_service.study.chart.point import Point

Position = tuple[float, float]
Box = tuple[float, float, float, float]  # left, bottom, right, top
MERGE = 0.9  # points closer than this many text heights in both directions share a label
RINGS = (0.9, 1.5, 2.4, 3.6, 5.0, 7.0, 9.0, 12.0)  # distances of a label from its point [text heights]
DIRECTIONS = 16
LEADER = 2.0  # a label farther than this [text heights] has a leader line


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

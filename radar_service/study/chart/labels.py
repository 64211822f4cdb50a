"""What stands beside the marks of a chart: settings, put where they hide the least."""

from collections.abc import Sequence
from dataclasses import dataclass

from radar_service.study.chart.point import Point
from radar_service.study.chart.sheet import Line, Place, Words

Box = tuple[float, float, float, float]  # left, top, right, bottom
SIZE, COLOUR, LEADER = 11.5, "#222222", "#8a8a8a"
SAME = 9.0  # marks nearer than this both ways share a label
FAR = 22.0  # a label farther from its mark has a line to it
HALF = 7.0  # of a mark
RINGS = (11.0, 20.0, 32.0, 46.0, 62.0)  # distances that labels try
WAYS: tuple[tuple[float, float, str], ...] = (
    (1.0, 0.0, "start"), (-1.0, 0.0, "end"), (0.0, -1.2, "middle"), (0.0, 1.2, "middle"), (0.8, -0.9, "start"),
    (0.8, 0.9, "start"), (-0.8, -0.9, "end"), (-0.8, 0.9, "end"),
)  # fmt: skip


@dataclass(frozen=True)
class Marked:
    """A point and where its mark stands."""

    point: Point
    place: Place


def labels(marked: Sequence[Marked], within: Box, taken: Sequence[Box]) -> list[Words | Line]:
    """Labels of all marks, those of presets first, with lines to those that had to go far. taken: boxes to keep clear of."""
    found: list[Words | Line] = []
    full = [*taken, *((m.place[0] - HALF, m.place[1] - HALF, m.place[0] + HALF, m.place[1] + HALF) for m in marked)]
    for group in sorted(_groups(marked), key=lambda g: all(m.point.preset is None for m in g)):
        words, near = _best(group, within, full)
        full.append(words.box)
        if not near:
            found.append(Line((group[0].place, _edge(words, group[0].place)), LEADER, 0.8))
        found.append(words)
    return found


def _groups(marked: Sequence[Marked]) -> list[list[Marked]]:
    """Marks that lie on each other, of one family, or of any where no target was met."""
    groups: list[list[Marked]] = []
    for one in marked:
        for group in groups:
            last = group[-1]
            close = max(abs(one.place[0] - last.place[0]), abs(one.place[1] - last.place[1])) < SAME
            alike = one.point.family == last.point.family or one.point.height is last.point.height is None
            if close and alike:
                group.append(one)
                break
        else:
            groups.append([one])
    return groups


def _best(group: Sequence[Marked], within: Box, full: Sequence[Box]) -> tuple[Words, bool]:
    """The label where it meets the fewest other things, and whether that is beside its mark."""
    text, (x, y) = label_text([m.point for m in group]), group[0].place
    bold = any(m.point.preset is not None for m in group)
    choices = [
        (ring, Words((x + ring * across, y + ring * down), text, SIZE, anchor, COLOUR, bold=bold))
        for ring in RINGS
        for across, down, anchor in WAYS
    ]

    def cost(choice: tuple[float, Words]) -> float:
        left, top, right, bottom = choice[1].box
        out = max(0.0, within[0] - left, within[1] - top) + max(0.0, right - within[2], bottom - within[3])
        met = sum(
            max(0.0, min(right, box[2]) - max(left, box[0])) * max(0.0, min(bottom, box[3]) - max(top, box[1]))
            for box in full
        )
        return 1e3 * out + met + choice[0]

    ring, words = min(choices, key=cost)
    return words, ring < FAR


def label_text(points: Sequence[Point]) -> str:
    """Settings in a row, a common last word said once: 1.5, 6 beamwidths; what each misses, and the preset it is."""
    last = {point.setting.rpartition(" ")[2] for point in points}
    shared = len(last) == 1 and len(points) > 1 and all(" " in point.setting for point in points)
    return ", ".join(dict.fromkeys(_one(p, shared and k < len(points) - 1) for k, p in enumerate(points)))


def _one(point: Point, short: bool) -> str:
    text = point.setting.rpartition(" ")[0] if short and not point.preset else point.setting
    if point.missed and point.height is not None:
        text += f" ({percent(point.missed)} missed)"
    return text + (f" = {point.preset}" if point.preset else "")


def _edge(words: Words, place: Place) -> Place:
    """The place on a label's outline that is nearest to a mark."""
    left, top, right, bottom = words.box
    return min(max(place[0], left), right), min(max(place[1], top), bottom)


def percent(share: float) -> str:
    """A share for a person."""
    return f"{100.0 * share:.3g} %"

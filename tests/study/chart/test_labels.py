"""Labels of the chart: their texts, and positions without overlap."""

import numpy as np

from radar_service.study.chart.labels import Box, label_text, merge, overlap, place_label
from radar_service.study.chart.point import Point


def at(setting: str, preset: str | None = None, family: str = "f") -> Point:
    return Point("power", family, setting, (1.0,), False, 1.0, preset=preset)


def test_a_common_unit_appears_once_and_presets_are_named() -> None:
    assert label_text([at("1.5 beamwidths"), at("6 beamwidths")]) == "1.5, 6 beamwidths"
    assert label_text([at("2000", "documented")]) == "2000 = documented"
    assert label_text([at("4 bins", "fast"), at("6 bins")]) == "4 bins = fast, 6 bins"
    assert label_text([at("500"), at("500"), at("2000")]) == "500, 2000"


def test_close_points_of_one_family_share_a_label() -> None:
    """Text of 10 pixels: points 8 pixels apart share a label, 12 pixels apart do not; labels of presets come first."""
    points = [at("1"), at("2"), at("3"), at("4", "fast", family="g")]
    positions = [(0.0, 0.0), (8.0, 0.0), (20.0, 0.0), (0.0, 0.0)]
    assert merge(points, positions, 10.0) == [[3], [0, 1], [2]]


def test_labels_stay_in_the_frame_and_apart() -> None:
    """Forty random marks: no label leaves the frame, covers a mark or covers another label."""
    rng, frame = np.random.default_rng(5), (0.0, 0.0, 1000.0, 600.0)
    marks = [(float(x), float(y)) for x, y in rng.uniform((20.0, 20.0), (980.0, 580.0), (40, 2))]
    taken: list[Box] = [(x - 8, y - 8, x + 8, y + 8) for x, y in marks]
    for mark in marks:
        label = place_label(mark, (80.0, 18.0), 15.0, frame, taken)
        left, bottom, right, top = label.box
        assert left >= 0 and bottom >= 0 and right <= 1000 and top <= 600
        assert sum(overlap(label.box, other) for other in taken) == 0.0
        taken.append(label.box)


def test_a_far_label_has_a_leader_line() -> None:
    """A free neighbourhood needs no line. With all of it taken the label goes farther, and its line ends at its box."""
    frame, mark = (0.0, 0.0, 1000.0, 600.0), (500.0, 300.0)
    assert place_label(mark, (80.0, 18.0), 15.0, frame, []).leader is None
    far = place_label(mark, (80.0, 18.0), 15.0, frame, [(440.0, 240.0, 560.0, 360.0)])
    assert far.leader is not None and far.box[0] <= far.leader[0] <= far.box[2] and far.box[1] <= far.leader[1] <= far.box[3]

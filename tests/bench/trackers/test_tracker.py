"""What a tracker gets is plain data."""

import json

from radar_service.bench.trackers.tracker import distance_at, moved_on
from tests.bench.trackers.test_stone_soup import given, plot


def test_a_scan_is_plain_data() -> None:
    data = json.loads(json.dumps(given(3, (plot(8.0, 10.0, 20.0),)).as_dict()))
    assert data["type"] == "scan" and data["scan"] == 3 and data["time"] == 10.0
    assert data["plots"][0]["east"] == 10.0 and {"heading", "course", "speed", "east", "north"} <= set(data)


def test_a_position_moves_along_its_velocity() -> None:
    assert moved_on((100.0, -50.0), (2.0, 3.0), 10.0).tolist() == [120.0, -20.0]
    assert moved_on((100.0, -50.0), (2.0, 3.0), -10.0).tolist() == [80.0, -80.0]


def test_the_truth_is_moved_to_the_time_of_the_track() -> None:
    """At 12 s a truth of 10 s at (0, 0) and 1.5, -2 m/s stands at (3, -4): 5 m from (0, 0)."""
    assert distance_at((0.0, 0.0), 12.0, (0.0, 0.0), (1.5, -2.0), 10.0) == 5.0
    assert distance_at((3.0, -4.0), 12.0, (0.0, 0.0), (1.5, -2.0), 10.0) == 0.0

"""What a tracker gets is plain data."""

import json

from radar_service.bench.trackers.tracker import moved_on
from tests.bench.trackers.test_stone_soup import given, plot


def test_a_scan_is_plain_data() -> None:
    data = json.loads(json.dumps(given(3, (plot(8.0, 10.0, 20.0),)).as_dict()))
    assert data["type"] == "scan" and data["scan"] == 3 and data["time"] == 10.0
    assert data["plots"][0]["east"] == 10.0 and {"heading", "course", "speed", "east", "north"} <= set(data)


def test_a_position_moves_along_its_velocity() -> None:
    assert moved_on((100.0, -50.0), (2.0, 3.0), 10.0).tolist() == [120.0, -20.0]
    assert moved_on((100.0, -50.0), (2.0, 3.0), -10.0).tolist() == [80.0, -80.0]

"""What a tracker gets is plain data."""

import json

from tests.bench.trackers.test_stone_soup import given, plot


def test_a_scan_is_plain_data() -> None:
    data = json.loads(json.dumps(given(3, (plot(8.0, 10.0, 20.0),)).as_dict()))
    assert data["type"] == "scan" and data["scan"] == 3 and data["time"] == 10.0
    assert data["plots"][0]["east"] == 10.0 and {"heading", "course", "speed", "east", "north"} <= set(data)

"""Keys of motion that exclude each other, on own ship as on bodies."""

from typing import Any

import pytest

from tests.scene_file.scene_sources import point, problems

LEG = {"position_m": [1, 1], "speed_kn": 1}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"waypoints": [LEG], "track": "t.csv"}, "speed_kn: only one of speed_kn (with course_deg), waypoints"),
        ({"track": "t.csv", "course_deg": 3}, "course_deg: the track already define the course; remove course_deg"),
        ({"turn_radius_m": 3}, "turn_radius_m: only corners at waypoints are rounded"),
        ({"loop": True}, "loop: only a route of waypoints can repeat"),
    ],
)  # fmt: skip
def test_a_route_is_told_once(keys: dict[str, Any], message: str) -> None:
    (own_ship,) = problems({"own_ship": keys})
    (body,) = problems({"body": [point(**keys)]})
    assert own_ship.startswith(f"own_ship.{message}") and body == own_ship.replace("own_ship", "body[0]", 1)

"""Keys of motion that exclude each other, on own ship as on bodies."""

from typing import Any

import pytest
from pydantic import ValidationError

from radar_service.scene_file.model.moving import ManoeuvreModel
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


def test_a_manoeuvre_may_change_any_of_course_speed_and_rate() -> None:
    for change in ({"course_deg": 10.0}, {"speed_kn": 0.0}, {"turn_rate_deg_s": -3.0}, {"turn_rate_deg_s": 0.0}):
        assert ManoeuvreModel.model_validate({"time_s": 3.0, **change}).time_s == 3.0


@pytest.mark.parametrize("time", [-1.0, float("nan"), "3"])
def test_times_are_finite_and_not_before_the_start(time: object) -> None:
    with pytest.raises(ValidationError, match="time_s"):
        ManoeuvreModel.model_validate({"time_s": time, "speed_kn": 3.0})

"""Tests of radar_service.scene_file.model.manoeuvre: what one manoeuvre may be."""

import pytest
from pydantic import ValidationError

from radar_service.scene_file.model.manoeuvre import ManoeuvreModel


def test_a_manoeuvre_may_change_any_of_course_speed_and_rate() -> None:
    for change in ({"course_deg": 10.0}, {"speed_kn": 0.0}, {"turn_rate_deg_s": -3.0}, {"turn_rate_deg_s": 0.0}):
        assert ManoeuvreModel.model_validate({"time_s": 3.0, **change}).time_s == 3.0


@pytest.mark.parametrize("time", [-1.0, float("nan"), "3"])
def test_times_are_finite_and_not_before_the_start(time: object) -> None:
    with pytest.raises(ValidationError, match="time_s"):
        ManoeuvreModel.model_validate({"time_s": time, "speed_kn": 3.0})

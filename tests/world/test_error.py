"""The error of a scene."""

from radar_service.world.error import SceneError


def test_the_text_has_a_line_for_each_problem() -> None:
    error = SceneError("radar.rpm: too low", "body[0]: no name")
    assert error.problems == ("radar.rpm: too low", "body[0]: no name")
    assert str(error) == "radar.rpm: too low\nbody[0]: no name"
    assert isinstance(error, ValueError)

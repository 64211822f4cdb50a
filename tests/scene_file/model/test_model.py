"""The short modules of scene_file/model, each under its name."""

from typing import Any

import pytest
from pydantic import ValidationError

import radar_service as rs
from radar_service.scene_file.model.moving import ManoeuvreModel
from tests.scene_file.scene_sources import point, problems
from tests.scenes import scene


# ais: keys of AIS that contradict each other are refused.
@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"body": [point("p", ais={})]}, "body[0].ais: a transponder has a number"),
        ({"own_ship": {"ais": {}}}, "own_ship.ais: a transponder has a number"),
        ({"body": [point("p", mmsi=5), point("q", mmsi=5)]}, "body[1].mmsi: 5 is taken"),
        ({"own_ship": {"mmsi": 5}, "body": [point("p", mmsi=5)]}, "body[0].mmsi: 5 is taken"),
        ({"body": [point("p", mmsi=5, ais={"off_s": [[3, 3]]})]}, "body[0].ais.off_s[0]: 3 is not after 3"),
        ({"body": [point("p", mmsi=5, ais={"name": "é"})]}, "body[0].ais.name"),
        ({"body": [point("p", mmsi=5, ais={"call_sign": "12345678"})]}, "body[0].ais.call_sign"),
        ({"body": [point("p", mmsi=5, ais={"destination": "x" * 21})]}, "body[0].ais.destination"),
        ({"ais": {"loss_percent": 101}}, "ais.loss_percent"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(scene: dict[str, Any], message: str) -> None:
    (problem,) = problems(scene)
    assert problem.startswith(message), problem


# errors: the tables of errors in a scene file: what they allow, and what they say about the rest.
@pytest.mark.parametrize(
    ("errors", "message"),
    [
        ({"gyro": {"bias_deg": float("nan")}}, "errors.gyro.bias_deg: nan is not allowed; a finite number from -180 to 180"),
        ({"gyro": {"bais_deg": 1}}, 'errors.gyro.bais_deg: this is not a known key; did you mean "bias_deg"?'),
        ({"gyro": {"noise_deg": -1}}, "errors.gyro.noise_deg: -1 is not allowed; a finite number from 0 to 45; raise it"),
        ({"log": {"bias_kn": "1"}}, 'errors.log.bias_kn: "1" is not allowed'),
        ({"log": {"latency_s": 11}}, "errors.log.latency_s: 11 is not allowed; a finite number from 0 to 10; lower it"),
        ({"position": {"bias_m": [1]}}, "errors.position.bias_m"),
        ({"antenna": {"encoder_step_deg": 46}}, "errors.antenna.encoder_step_deg: 46 is not allowed"),
        ({"feed": {"drop_rate": 1.1}}, "errors.feed.drop_rate: 1.1 is not allowed; a finite number from 0 to 1; lower it"),
        ({"feed": {"burst_spokes": 2.5}}, "errors.feed.burst_spokes: 2.5 is not allowed"),
        ({"feed": {"heading_lost_s": [[5, 5]]}}, "heading_lost_s[0]: 5 s is not after 5 s; give from and to in this order"),
        ({"feed": {"bytes_per_s": 0}}, "errors.feed.bytes_per_s: 0 is not allowed"),
        (
            {"profile": "imo"},
            'errors.profile: "imo" is not allowed; one of "imo-a823", "imo-2004", "msc116-thd"; choose one of these',
        ),
        ({"compass": {}}, "errors.compass: this is not a known key; remove it ("),
        (3, "errors: 3 is not allowed"),
    ],
)
def test_what_is_not_allowed_is_refused_with_a_sentence(errors: Any, message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene({"errors": errors})
    assert message in str(refused.value)


# moving: keys of motion that exclude each other, on own ship as on bodies.
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


# scene: rules of a scene file that involve several keys.
def test_a_period_without_amplitude_is_refused() -> None:
    with pytest.raises(rs.SceneError, match="roll_period_s: it needs an amplitude; add roll_deg"):
        scene([], own_ship={"roll_period_s": 8})

"""The short modules of scene_file/model, each under its name."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

import radar_service as rs
from radar_service.scene_file.model.moving import ManoeuvreModel
from tests.scene_file.scene_sources import point, problems
from tests.scenes import point as placed_point
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


# sway: keys of sway in scene files, for own ship and bodies.
KEYS = {"roll_deg": 5, "roll_period_s": 8, "roll_phase_deg": 90, "heave_m": 0.5, "heave_period_s": 6, "heave_phase_deg": -90}


def test_keys_become_si_for_own_ship_and_bodies() -> None:
    made = scene([placed_point("p", 0, 300, **KEYS)], own_ship=KEYS)
    for sway in (made.own_ship.sway, made.bodies[0].motion.sway):
        assert sway is not None
        np.testing.assert_allclose(sway.amplitude, [np.deg2rad(5), 0, 0, 0.5])
        np.testing.assert_allclose(sway.period, [8, 7, 20, 6])
        np.testing.assert_allclose(sway.phase, [np.pi / 2, 0, 0, -np.pi / 2])
    assert scene([placed_point("p", 0, 300)]).bodies[0].motion.sway is None


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"heave_period_s": 5}, "heave_period_s: it needs an amplitude; add heave_m"),
        ({"pitch_phase_deg": 5}, "pitch_phase_deg: it needs an amplitude; add pitch_deg"),
        ({"heave_m": 21}, "heave_m"),
        ({"roll_deg": -1}, "roll_deg"),
    ],
)
def test_keys_without_an_amplitude_and_values_out_of_range_are_refused(keys: dict[str, Any], message: str) -> None:
    for sections in ({"bodies": [placed_point("p", 0, 300, **keys)]}, {"own_ship": keys}):
        with pytest.raises(rs.SceneError, match=message):
            scene(**sections)


# environment: the environment of a scene file: effects that need each other.
@pytest.mark.parametrize(
    ("environment", "message"),
    [
        ({"diffraction": True}, "environment.diffraction: true needs the sea's reflection; give multipath = true"),
        ({"diffraction": True, "multipath": True, "earth": "flat"}, "environment.diffraction: true needs a round earth"),
        ({"diffraction": True, "multipath": True, "earth": 1000.0}, "needs a round earth, not earth = 1000.0; give 4/3"),
        ({"earth": "round"}, 'environment.earth: "round" is not allowed'),
        ({"sea_state": 10}, "environment.sea_state: 10 is not allowed; a finite number from 0 to 9; lower it"),
        ({"sea_state": -0.5}, "environment.sea_state: -0.5 is not allowed; a finite number from 0 to 9; raise it"),
        (
            {"sea_state": 0, "wave_height_m": 1.04},
            "environment.wave_height_m: sea_state is given too; give one, as sea_state = 2.99",
        ),
        ({"wave_height_m": 11.0}, "environment.wave_height_m: 11 is not allowed; a finite number from 0.05 to 10; lower it"),
        (
            {"sea_texture_shape": 0.01},
            "environment.sea_texture_shape: 0.01 is not allowed; a finite number from 0.05 to 1000; raise it",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene({"environment": environment})
    assert message in str(refused.value)


def test_a_sea_is_given_by_state_or_by_wave_height() -> None:
    assert rs.load_scene({"environment": {"sea_state": 2.5}}).environment.sea_state == 2.5
    environment = rs.load_scene({"environment": {"wave_height_m": 2.977, "seaway": True}}).environment
    assert environment.sea_state == pytest.approx(5.0, abs=1e-3)
    assert environment.seaway is not None and environment.seaway.height == pytest.approx(2.977, rel=1e-9)


# seaway: keys of a seaway and of hulls: ranges, and where they are refused.
HULL = {"name": "h", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "position_m": [0, 500, 0]}


@pytest.mark.parametrize(
    ("environment", "message"),
    [
        ({"seaway": True}, "environment.seaway: sea_state 0 has no waves; give sea_state up to 9"),
        ({"seaway": {"from_deg": 20}}, "environment.seaway: sea_state 0 has no waves"),
        ({"seaway": {"height_m": 0}}, "environment.seaway.height_m"),
        ({"seaway": {"height_m": 1, "period_s": 1}}, "environment.seaway.period_s"),
        ({"seaway": {"height_m": 1, "spread": 0.1}}, "environment.seaway.spread"),
        ({"seaway": {"height_m": 1, "seed": -1}}, "environment.seaway.seed"),
        ({"seaway": {"hight_m": 1}}, 'hight_m: this is not a known key; did you mean "height_m"'),
        ({"seaway": 3}, "environment.seaway"),
    ],
)
def test_seaways_without_waves_or_out_of_range_are_refused(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message.replace("[", r"\[")):
        scene([HULL], environment=environment)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"hull": {"block": 0.1}}, r"body\[0\].hull.block"),
        ({"hull": {"roll_damping": 0.01}}, r"body\[0\].hull.roll_damping"),
        ({"hull": {"draught_m": 0}}, r"body\[0\].hull.draught_m"),
        ({"list_deg": 50}, r"body\[0\].list_deg"),
    ],
)
def test_hulls_out_of_range_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        scene([HULL | keys])


@pytest.mark.parametrize("key", ["list_deg", "trim_deg", "hull"])
def test_land_neither_lists_nor_floats(key: str) -> None:
    land = {"name": "land", "heightmap": "map.png", key: {} if key == "hull" else 1.0}
    with pytest.raises(rs.SceneError, match=rf"body\[0\].{key}: a height map is land, .* at rest, .*; remove {key}"):
        scene([land])

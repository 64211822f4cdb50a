"""The short modules of scene_file/model, each under its name."""

import math
from typing import Any

import numpy as np
import pytest

from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.moving import ManoeuvreModel
from tests.scene_file.scene_sources import point, problems
from tests.scenes import point as placed_point
from tests.scenes import scene

LEG = {"position_m": [1, 1], "speed_kn": 1}
HULL = {"name": "h", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "position_m": [0, 500, 0]}
LAND = {"name": "land", "heightmap": "map.png"}


def transponder(**ais: Any) -> list[dict[str, Any]]:
    return [point("p", mmsi=5, ais=ais)]


# What a table of a scene may not be, with a part of the only line that tells it.
REFUSED: dict[str, list[tuple[Any, str]]] = {
    # ais: transponders, and bodies with them.
    "ais": [({"loss_percent": 101}, "ais.loss_percent")],
    "body": [
        ([point("p", ais={})], "body[0].ais: a transponder has a number"),
        ([point("p", mmsi=5), point("q", mmsi=5)], "body[1].mmsi: 5 is taken"),
        (transponder(off_s=[[3, 3]]), "body[0].ais.off_s[0]: 3 is not after 3"),
        (transponder(name="é"), "body[0].ais.name"),
        (transponder(call_sign="12345678"), "body[0].ais.call_sign"),
        (transponder(destination="x" * 21), "body[0].ais.destination"),
        ([HULL | {"hull": {"block": 0.1}}], "body[0].hull.block"),
        ([HULL | {"hull": {"roll_damping": 0.01}}], "body[0].hull.roll_damping"),
        ([HULL | {"hull": {"draught_m": 0}}], "body[0].hull.draught_m"),
        ([HULL | {"list_deg": 50}], "body[0].list_deg"),
        ([LAND | {"list_deg": 1.0}], "body[0].list_deg: a height map is land, always there, at rest, north up,"),
        ([LAND | {"trim_deg": 1.0}], "body[0].trim_deg: a height map is land, always there, at rest, north up,"),
        ([LAND | {"hull": {}}], "body[0].hull: a height map is land, always there, at rest, north up, without plates; remove"),
        ([point(manoeuvre=[{"time_s": -1, "speed_kn": 3}])], "body[0].manoeuvre[0].time_s: -1 is not allowed"),
        ([point(manoeuvre=[{"time_s": "3", "speed_kn": 3}])], "body[0].manoeuvre[0].time_s"),
    ],
    # errors: what sensors, antenna and feed may report wrongly.
    "errors": [
        ({"gyro": {"bias_deg": math.nan}}, "errors.gyro.bias_deg: nan is not allowed; a finite number from -180 to 180"),
        ({"gyro": {"bais_deg": 1}}, 'errors.gyro.bais_deg: this is not a known key; did you mean "bias_deg"?'),
        ({"gyro": {"noise_deg": -1}}, "errors.gyro.noise_deg: -1 is not allowed; a finite number from 0 to 45; raise it"),
        ({"log": {"latency_s": 11}}, "errors.log.latency_s: 11 is not allowed; a finite number from 0 to 10; lower it"),
        ({"position": {"bias_m": [1]}}, "errors.position.bias_m"),
        ({"antenna": {"encoder_step_deg": 46}}, "errors.antenna.encoder_step_deg: 46 is not allowed"),
        ({"feed": {"drop_rate": 1.1}}, "errors.feed.drop_rate: 1.1 is not allowed; a finite number from 0 to 1; lower it"),
        ({"feed": {"burst_spokes": 2.5}}, "errors.feed.burst_spokes: 2.5 is not allowed"),
        ({"feed": {"heading_lost_s": [[5, 5]]}}, "heading_lost_s[0]: 5 s is not after 5 s; give from and to in this order"),
        ({"feed": {"bytes_per_s": 0}}, "errors.feed.bytes_per_s: 0 is not allowed"),
        ({"profile": "imo"}, 'errors.profile: "imo" is not allowed; one of "imo-a823", "imo-2004", "msc116-thd"; choose one'),
        ({"compass": {}}, "errors.compass: this is not a known key; remove it ("),
        (3, "errors: 3 is not allowed"),
    ],
    # environment: ranges, and keys that need or exclude each other.
    "environment": [
        ({"diffraction": True}, "environment.diffraction: true needs the sea's reflection; give multipath = true"),
        ({"diffraction": True, "multipath": True, "earth": "flat"}, "environment.diffraction: true needs a round earth"),
        ({"diffraction": True, "multipath": True, "earth": 1000.0}, "needs a round earth, not earth = 1000.0; give 4/3"),
        ({"sea_state": -0.5}, "environment.sea_state: -0.5 is not allowed; a finite number from 0 to 9; raise it"),
        ({"sea_state": 0, "wave_height_m": 1.04}, "wave_height_m: sea_state is given too; give one, as sea_state = 2.99"),
        ({"wave_height_m": 11.0}, "environment.wave_height_m: 11 is not allowed; a finite number from 0.05 to 10; lower it"),
        ({"sea_texture_shape": 0.01}, "sea_texture_shape: 0.01 is not allowed; a finite number from 0.05 to 1000; raise it"),
        ({"current_kn": 2.0}, "environment.current_to_deg: a stream has current_kn above 0 and current_to_deg; give both"),
        ({"current_to_deg": 90.0}, "environment.current_to_deg: a stream has current_kn above 0 and current_to_deg"),
        ({"current_kn": 21.0, "current_to_deg": 0.0}, "environment.current_kn: 21 is not allowed"),
        ({"seaway": True}, "environment.seaway: sea_state 0 has no waves; give sea_state up to 9"),
        ({"seaway": {"from_deg": 20}}, "environment.seaway: sea_state 0 has no waves"),
        ({"seaway": {"height_m": 0}}, "environment.seaway.height_m"),
        ({"seaway": {"height_m": 1, "period_s": 1}}, "environment.seaway.period_s"),
        ({"seaway": {"height_m": 1, "spread": 0.1}}, "environment.seaway.spread"),
        ({"seaway": {"height_m": 1, "seed": -1}}, "environment.seaway.seed"),
        ({"seaway": {"height_m": 1, "seed": 2**32}}, "environment.seaway.seed"),
        ({"seaway": {"hight_m": 1}}, 'hight_m: this is not a known key; did you mean "height_m"'),
        ({"seaway": 3}, "environment.seaway"),
    ],
    # scene: rules that involve several tables.
    "own_ship": [
        ({"ais": {}}, "own_ship.ais: a transponder has a number"),
        ({"roll_period_s": 8}, "roll_period_s: it needs an amplitude; add roll_deg"),
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("section", "content", "message"), [(name, content, text) for name, rows in REFUSED.items() for content, text in rows]
)
def test_what_a_table_may_not_be_is_refused_in_one_line(section: str, content: Any, message: str) -> None:
    (problem,) = problems({section: content})
    assert message in problem


# moving: keys of motion and of sway.
@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"waypoints": [LEG], "track": "t.csv"}, "speed_kn: only one of speed_kn (with course_deg), waypoints"),
        ({"track": "t.csv", "course_deg": 3}, "course_deg: the track already define the course; remove course_deg"),
        ({"turn_radius_m": 3}, "turn_radius_m: only corners at waypoints are rounded"),
        ({"loop": True}, "loop: only a route of waypoints can repeat"),
        ({"heave_period_s": 5}, "heave_period_s: it needs an amplitude; add heave_m"),
        ({"pitch_phase_deg": 5}, "pitch_phase_deg: it needs an amplitude; add pitch_deg"),
        ({"heave_m": 21}, "heave_m"), ({"roll_deg": -1}, "roll_deg"), ({"steerable": True}, "steerable"),
        ({"steerable": {"max_speed_kn": -1}}, "steerable.max_speed_kn"),
        ({"steerable": {"max_turn_rate_deg_s": 0}}, "steerable.max_turn_rate_deg_s"),
        ({"steerable": {"max_speed": 1}}, "steerable.max_speed"),
    ],
)  # fmt: skip
def test_keys_of_motion_are_refused_on_own_ship_as_on_bodies(keys: dict[str, Any], message: str) -> None:
    (own_ship,) = problems({"own_ship": keys})
    (body,) = problems({"body": [point(**keys)]})
    assert own_ship.startswith(f"own_ship.{message}") and body == own_ship.replace("own_ship", "body[0]", 1)


def test_a_number_is_that_of_one_ship() -> None:
    assert problems({"own_ship": {"mmsi": 5}, "body": [point("p", mmsi=5)]})[0].startswith("body[0].mmsi: 5 is taken")


def test_a_manoeuvre_may_change_any_of_course_speed_and_rate() -> None:
    for change in ({"course_deg": 10.0}, {"speed_kn": 0.0}, {"turn_rate_deg_s": -3.0}, {"turn_rate_deg_s": 0.0}):
        assert ManoeuvreModel.model_validate({"time_s": 3.0, **change}).time_s == 3.0


def test_keys_of_sway_become_si_for_own_ship_and_bodies() -> None:
    keys = {
        "roll_deg": 5,
        "roll_period_s": 8,
        "roll_phase_deg": 90,
        "heave_m": 0.5,
        "heave_period_s": 6,
        "heave_phase_deg": -90,
    }
    made = scene([placed_point("p", 0, 300, **keys)], own_ship=keys)
    for sway in (made.own_ship.sway, made.bodies[0].motion.sway):
        assert sway is not None
        np.testing.assert_allclose(sway.amplitude, [np.deg2rad(5), 0, 0, 0.5])
        np.testing.assert_allclose(sway.period, [8, 7, 20, 6])
        np.testing.assert_allclose(sway.phase, [np.pi / 2, 0, 0, -np.pi / 2])
    assert scene([placed_point("p", 0, 300)]).bodies[0].motion.sway is None


def test_a_sea_is_given_by_state_or_by_wave_height() -> None:
    assert load_scene({"environment": {"sea_state": 2.5}}).environment.sea_state == 2.5
    environment = load_scene({"environment": {"wave_height_m": 2.977, "seaway": True}}).environment
    assert environment.sea_state == pytest.approx(5.0, abs=1e-3)
    assert environment.seaway is not None and environment.seaway.height == pytest.approx(2.977, rel=1e-9)

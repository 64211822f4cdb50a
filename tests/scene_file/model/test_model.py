"""The short modules of scene_file/model, each under its name."""

import itertools
import math
from typing import Any

import jsonschema
import numpy as np
import pytest
from pydantic import ValidationError

from radar_service.radar.patterns import PATTERNS
from radar_service.scene_file.describe import json_schema
from radar_service.scene_file.document import validated
from radar_service.scene_file.load import load_scene, model_from
from radar_service.scene_file.model.body import (
    KINDS,
    OWN_KEYS,
    BodyModel,
    FadingModel,
    HeightMapBodyModel,
    MeshBodyModel,
    ShapeBodyModel,
)
from radar_service.scene_file.model.moving import ManoeuvreModel
from radar_service.scene_file.model.platform import MAX_RADARS, radar_entries
from radar_service.scene_file.model.radar import WAVEFORM_KEYS, PulseModel
from radar_service.world.error import SceneError
from tests.scene_file.scene_sources import point, problems
from tests.scenes import point as placed_point
from tests.scenes import radar, scene

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
    keys = {"roll_deg": 5, "roll_period_s": 8, "roll_phase_deg": 90, "heave_m": 0.5, "heave_period_s": 6,
            "heave_phase_deg": -90}  # fmt: skip
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


# body: which model a table becomes, keys of other kinds, and their order.
SCHEMA = jsonschema.Draft202012Validator(json_schema())
MESH, MAP = {"name": "m", "mesh": "m.obj"}, {"name": "h", "heightmap": "h.png"}
BALL = {"name": "s", "shape": "sphere", "radius_m": 1}


@pytest.mark.parametrize(
    ("table", "kind"), [(BALL, ShapeBodyModel), (MESH, MeshBodyModel), (MAP, HeightMapBodyModel)]
)  # fmt: skip
def test_the_key_tells_the_kind(table: dict[str, Any], kind: type[BodyModel]) -> None:
    (body,) = validated({"body": [table]}).body
    assert isinstance(body, kind) and body.model_dump(exclude_unset=True) == table
    assert body.can_carry is (kind is not HeightMapBodyModel)
    (same,) = validated({"body": [body]}).body
    assert same == body


def test_null_is_as_good_as_absent_for_keys_that_tell_the_kind_and_for_sizes() -> None:
    table = MESH | {"shape": None, "heightmap": None, "radius_m": None}
    (body,) = validated({"body": [table]}).body
    assert body.model_dump(exclude_unset=True) == MESH and SCHEMA.is_valid({"body": [table]})


def is_accepted(scene: dict[str, Any]) -> bool:
    try:
        validated(scene)
    except SceneError:
        return False
    return True


@pytest.mark.parametrize("table", [BALL, MESH, MAP], ids=KINDS)
def test_the_schema_takes_a_key_of_another_kind_where_the_loader_does(table: dict[str, Any]) -> None:
    """Which is null alone, and not for all; for keys of its own kind the schema takes at least what the loader takes."""
    for (kind, keys), value in itertools.product(OWN_KEYS.items(), (None, 1, "y", [1, 2])):
        for key in keys:
            scene = {"body": [table | {key: value}]}
            taken = is_accepted(scene)
            assert SCHEMA.is_valid(scene) is taken or (kind in table and not taken), (key, value)


@pytest.mark.parametrize(
    ("table", "given"),
    [
        ({"name": "a"}, "none of them"), (BALL | MESH, "shape and mesh"), (MESH | MAP, "mesh and heightmap"),
        (BALL | MESH | MAP, "shape and mesh and heightmap"), ({"name": "a", "mesh": None}, "none of them"),
    ],
)  # fmt: skip
def test_a_body_has_one_kind(table: dict[str, Any], given: str) -> None:
    expected = f"body[0].shape: a body has exactly one of shape, mesh, heightmap; this one has {given}: add or remove"
    assert problems({"body": [table]}) == (expected,)


@pytest.mark.parametrize("table", [BALL, MESH, MAP], ids=KINDS)
@pytest.mark.parametrize("key", [key for kind in KINDS for key in OWN_KEYS[kind] if key not in KINDS])
def test_keys_of_another_kind_are_refused(table: dict[str, Any], key: str) -> None:
    """Whatever their value is; those of the same kind are not."""
    (owner,) = (kind for kind in KINDS if key in OWN_KEYS[kind])
    if owner in table:
        return
    assert problems({"body": [table | {key: 1}]}) == (f"body[0].{key}: this key needs a body with {owner}; remove it",)


def test_other_faults_are_told_too() -> None:
    foreign, unknown = problems({"body": [MESH | {"low_m": 1, "positon_m": 3}]})
    assert foreign == "body[0].low_m: this key needs a body with heightmap; remove it"
    assert unknown.startswith("body[0].positon_m: this is not a known key")
    assert problems({"body": [{"name": "a", "meshh": "m.obj"}]}) == (
        'body[0].meshh: this is not a known key; did you mean "mesh"? (nearest of 67 keys: mesh, mesh_heading_deg, name)',
    )


def test_the_order_of_keys_is_that_of_recordings() -> None:
    keys = list(MeshBodyModel.model_fields)
    assert [keys.index(key) for key in ("speed_kn", "name", "mesh", "up", "position_m", "fading")] == sorted(
        keys.index(key) for key in ("speed_kn", "name", "mesh", "up", "position_m", "fading")
    )


def test_sizes_are_those_of_the_shape() -> None:
    (ball, mark) = validated({"body": [BALL, point()]}).body
    assert isinstance(ball, ShapeBodyModel) and ball.sizes() == {"radius_m": 1}
    assert isinstance(mark, ShapeBodyModel) and mark.sizes() == {}


@pytest.mark.parametrize("key", ["roll_deg", "drift_deg", "start_s", "steerable", "waypoints"])
def test_land_neither_moves_nor_goes(key: str) -> None:
    values = {"steerable": {}, "waypoints": [{"position_m": [1, 1], "speed_kn": 1}]}
    (problem,) = problems({"body": [MAP | {key: values.get(key, 1)}]})
    assert problem.startswith(f"body[0].{key}: a height map is land, always there, at rest") and problem.endswith(
        f"remove {key}"
    )


@pytest.mark.parametrize(("present", "of"), [(5, 10), (1, 7), (3, 4), (4, 4), (6, 9)])
def test_a_schedule_has_as_many_units_with_the_body_as_it_says_and_begins_with_one(present: int, of: int) -> None:
    for spread in (False, True):
        pattern = FadingModel(present=present, of=of, spread=spread).pattern()
        assert len(pattern) == of and sum(pattern) == present and pattern[0]


def test_spread_units_are_as_far_apart_as_they_can_be() -> None:
    pattern = FadingModel(present=3, of=10, spread=True).pattern()
    gaps = [unit for unit, there in enumerate(pattern + pattern) if there]
    assert {b - a for a, b in zip(gaps, gaps[1:], strict=False)} == {3, 4}
    assert FadingModel(present=3, of=10).pattern() == [True] * 3 + [False] * 7


def test_more_units_than_there_are_is_refused() -> None:
    with pytest.raises(ValidationError, match="present: 11 units are more than of = 10"):
        FadingModel(present=11, of=10)


# platform: ids and platforms of radars, and what is refused.
SITE = {"id": "shore", "platform": {"position_m": [500, -20], "heading_deg": 90}}
ISLAND = {"name": "island", "heightmap": "h.npy", "low_m": 0, "high_m": 9, "extent_m": [100, 100]}


def test_a_single_radar_has_the_id_0_and_stands_on_own_ship() -> None:
    (entry,) = radar_entries(model_from({"radar": {"rpm": 30}}).radar)
    assert (entry.id, entry.location, entry.model.rpm, entry.platform) == ("0", "radar", 30, None)


def test_radars_keep_the_order_of_the_file() -> None:
    first, second = radar_entries(model_from({"radar": [{"id": "bow-1", "rpm": 30}, SITE]}).radar)
    assert (first.id, first.location, first.model.rpm, first.platform) == ("bow-1", "radar[0]", 30, None)
    assert (second.id, second.location, second.model.rpm) == ("shore", "radar[1]", 24)
    assert second.platform is not None and second.platform.position_m == (500, -20)


# What the list of radars, own ship and the bodies are, and how the only problem begins.
BAD_RADARS: list[tuple[dict[str, Any], str]] = [
    ({"radar": []}, f"radar: [] is not allowed; a list of 1 to {MAX_RADARS} radars: add one, or remove the list"),
    ({"radar": [{"id": str(i)} for i in range(MAX_RADARS + 1)]}, f"radar: a list of {MAX_RADARS + 1} values is not allowed"),
    ({"radar": "bow"}, 'radar: "bow" is not allowed; a table with the keys modulation'),
    ({"radar": [5]}, "radar[0]: 5 is not allowed; a table with the keys modulation"),
    ({"radar": [{"rpm": 24}]}, "radar[0].id: missing; text of 1 to 32 characters: letters, digits, - and _"),
    ({"radar": [{"id": "a/b"}]}, 'radar[0].id: "a/b" is not allowed; text of 1 to 32 characters: letters, digits, - and _'),
    ({"radar": [{"id": "bow\n"}]}, r'radar[0].id: "bow\n" is not allowed'),
    ({"radar": [{"id": ".."}]}, 'radar[0].id: ".." is not allowed'),
    ({"radar": [{"id": ""}]}, 'radar[0].id: "" is not allowed; text of 1 to 32 characters'),
    ({"radar": [{"id": "a" * 33}]}, f'radar[0].id: "{"a" * 33}" is not allowed'),
    ({"radar": [{"id": 7}]}, "radar[0].id: 7 is not allowed; text of 1 to 32 characters"),
    ({"radar": [{"id": "a"}, {"id": "b"}, {"id": "a"}]}, 'radar[2].id: "a" is taken by an earlier radar; ids are unique'),
    ({"radar": [{"id": "a"}, {"id": "b", "rpm": -1}]}, "radar[1].rpm: -1 is not allowed; a finite number from 0.01 to 600"),
    ({"radar": [{"id": "a", "rmp": 1}]}, 'radar[0].rmp: this is not a known key; did you mean "rpm"?'),
    ({"radar": [{"id": "a", "plattform": {}}]}, 'radar[0].plattform: this is not a known key; did you mean "platform"?'),
    ({"radar": {"rmp": 1}}, 'radar.rmp: this is not a known key; did you mean "rpm"?'),
    ({"radar": {"id": "a"}}, "radar.id: this is not a known key; remove it"),
    ({"radar": [{"id": "a", "platform": {}}]}, "radar[0].platform.body: a platform has exactly one of body, position_m"),
    ({"radar": [{"id": "a", "platform": "p"}]}, 'radar[0].platform: "p" is not allowed; a table with the keys body'),
    (
        {"radar": [{"id": "a", "platform": {"body": "p", "position_m": [1, 2]}}], "body": [point("p")]},
        "radar[0].platform.body: a platform has exactly one of body, position_m, and latitude_deg with longitude_deg; this "
        "one has body and position_m",
    ),
    ({"radar": [{"id": "a", "platform": {"body": "p", "heading_deg": 3}}], "body": [point("p")]},
     "radar[0].platform.heading_deg: the body already defines the heading; remove heading_deg"),
    ({"radar": [{"id": "a", "platform": {"body": "q"}}], "body": [point("p"), ISLAND]},
     'radar[0].platform.body: "q" is not a body of this scene; it has p: correct the name or add the body'),
    ({"own_ship": {"body": "q"}}, 'own_ship.body: "q" is not a body of this scene; it has no body that could carry'),
    ({"own_ship": {"body": "island"}, "body": [ISLAND]},
     'own_ship.body: "island" is a height map, which carries no antenna; give a site by position_m'),
    ({"own_ship": {"body": "p", "speed_kn": 3, "roll_deg": 2}, "body": [point("p")]},
     "own_ship.roll_deg: the body already defines how own ship moves; remove roll_deg, speed_kn"),
    ({"radar": [{"id": "a", "platform": {"latitude_deg": 3}}]},
     "radar[0].platform.latitude_deg: this key needs latitude_deg and longitude_deg together"),
    ({"radar": [{"id": "a", "platform": {"latitude_deg": 3, "longitude_deg": 4}}]},
     "radar[0].platform.latitude_deg: latitude and longitude need an [origin] in the scene; add one"),
]  # fmt: skip


@pytest.mark.parametrize(("data", "message"), BAD_RADARS)
def test_bad_radars_are_refused_with_one_line(data: dict[str, Any], message: str) -> None:
    (line,) = problems(data)
    assert line.startswith(message)


def test_every_problem_of_a_list_is_named() -> None:
    lines = problems({"radar": [{"id": "a", "rpm": -1}, {"id": "b", "azimuths": 1}]})
    assert [line.split(":")[0] for line in lines] == ["radar[0].rpm", "radar[1].azimuths"]


def test_a_message_names_few_of_many_bodies() -> None:
    (line,) = problems({"own_ship": {"body": "x"}, "body": [point(f"b{i}") for i in range(9)]})
    assert "it has b0, b1, b2, b3, b4, b5 and 3 more" in line


def test_a_site_in_degrees() -> None:
    """A tenth of a degree north of the origin is 11.06 km on the ellipsoid at the equator (6335.4 km of radius)."""
    made = load_scene(
        {
            "origin": {"latitude_deg": 0, "longitude_deg": 0},
            "radar": [{"id": "light", "height_m": 40, "platform": {"latitude_deg": 0.1, "longitude_deg": 0}}],
        }
    )
    (antenna,) = made.antenna(7.0).tolist()
    assert antenna == pytest.approx([0, 11_057.4, 40], abs=0.1)  # the last printed digit
    assert made.own_ship.at_rest


# radar: settings that the physics cannot compute together are refused with the reason.
LIGHT = 299_792_458.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sample_rate_hz": 40e6}, "radar.sample_rate_hz: 4e+07 is below the bandwidth; complex sampling needs at least"),
        ({"beamwidth_deg": 0.4}, "radar.beamwidth_deg: 0.4 degrees are narrower than the 0.5 degrees from spoke to spoke"),
        ({"beamwidth_deg": 0.4}, "raise azimuths to 900 or set coarse_azimuths = true"),
        ({"pulse_s": 0.05e-6}, 'radar.pulse_s: bandwidth x pulse is 2.5; a chirp needs at least 4: lengthen the pulse'),
        ({"pulse_s": 1e-3, "prf_hz": 1000, "bandwidth_hz": 1e6}, "radar.pulse_s: 0.001 s is not below the 0.001 s"),
        ({"prf_hz": 250}, "radar.prf_hz: 250 is less than a pulse for each of the 288 spokes a second"),
        ({"prf_hz": 40_000}, "radar.range_max_m: 5000 m is beyond the 3747 m from which echoes of 40000 pulses a second"),
        ({"second_time_around": True}, "radar.second_time_around: it needs a pulse repetition frequency; add prf_hz"),
        ({"modulation": "none"}, None),
        ({"modulation": "none", "bandwidth_hz": 50e6}, "radar.bandwidth_hz: 5e+07 Hz x 1e-05 s is 500; the receiver"),
        ({"modulation": "none", "window": "hamming"}, 'radar.window: "hamming" needs a chirp, and modulation = "none"'),
        ({"modulation": "none", "compression": "inverse"}, 'radar.compression: "inverse" needs a chirp, and modulation = "none"'),
        ({"modulation": "nlfm", "window": "hamming"}, None),
        ({"compression": "inverse", "window": "nuttall"}, None),
        ({"compression": "inverse"}, 'radar.compression: "inverse" with window "hamming" leaves sidelobes along the'),
        ({"modulation": "nlfm", "pulse_s": 0.05e-6}, "radar.pulse_s: bandwidth x pulse is 2.5; a chirp needs at least 4"),
        ({"modulation": "nlfm", "pulse_s": 5e-4}, "radar.pulse_s: bandwidth x pulse is 2.5e+04; a nonlinear chirp has at most"),
        ({"pattern_el": [[0, 0], [0, -3]]}, "radar.pattern_el: the offsets start at 0 and rise strictly"),
        ({"beamwidth_deg": 0.1, "coarse_azimuths": True, "range_max_m": 20_000},
         "radar.beamwidth_deg: 0.1 degrees need a grid of 18720 rows x 10007 range bins; at most 134217728 cells"),
        ({"pattern": [[0, 0], [0.1, -3.0103], [1, -40]]}, "radar.pattern: 0.2016 degrees are narrower than the 0.5 degrees"),
        ({"pattern": [[0, 0], [1e-3, -40]], "coarse_azimuths": True}, "radar.pattern: 0.0036"),
        ({"taylor_nbar": 1}, "radar.taylor_nbar: 1 is not allowed; a whole number from 2 to 20; raise it"),
    ],
)  # fmt: skip
def test_impossible_settings_are_refused_with_the_remedy(settings: dict[str, Any], message: str | None) -> None:
    if message is None:
        load_scene({"radar": settings})
        return
    with pytest.raises(SceneError) as fault:
        load_scene({"radar": settings})
    assert message in str(fault.value)


@pytest.mark.parametrize(
    "settings",
    [
        {"beamwidth_deg": 0.4, "coarse_azimuths": True},
        {"beamwidth_deg": 0.5},  # exactly a step
        {"prf_hz": 288},  # exactly a pulse to a spoke
        {"prf_hz": 40_000, "second_time_around": True},
        {"prf_hz": LIGHT / 10_000},  # exactly to range_max_m
        {"sample_rate_hz": 50e6},
    ],
)
def test_settings_at_the_limit_are_accepted(settings: dict[str, Any]) -> None:
    load_scene({"radar": settings})


@pytest.mark.parametrize("name", PATTERNS)
def test_the_bound_on_the_grid_is_that_of_the_engine(name: str) -> None:
    """The grid has 2.9 x 2 rows for each wavelength over the aperture, whose half-power width is 0.8859 `aperture_width`
    lambda / a (tests/radar/test_patterns.py). The margin of 1 % covers four digits and whole multiples of 16 azimuths."""
    settings = {"pattern": name, "azimuths": 16, "coarse_azimuths": True, "range_max_m": 20_000}
    finest_deg = 2.9 * 2.0 * 0.8859 * PATTERNS[name].aperture_width * 360.0 * 10_007 / 2**27
    assert load_scene({"radar": settings | {"beamwidth_deg": finest_deg * 1.01}}).radar.bins == 10_007
    with pytest.raises(SceneError, match="at most 134217728 cells"):
        load_scene({"radar": settings | {"beamwidth_deg": finest_deg * 0.99}})


SHORT = {"modulation": "none", "pulse_s": 8e-8, "range_max_m": 1500}


def test_defaults_are_those_of_a_radar_with_one_pulse() -> None:
    assert WAVEFORM_KEYS == ("modulation", "bandwidth_hz", "pulse_s", "window", "compression")
    assert PulseModel().band_hz == 50e6
    assert PulseModel(modulation="none", pulse_s=0.3e-6).band_hz == pytest.approx(4e6)  # 1.2 / T
    assert PulseModel(bandwidth_hz=20e6).band_hz == 20e6


def test_each_pulse_becomes_a_radar_and_all_have_the_sampling_of_the_widest_band() -> None:
    made = radar(pulses=[SHORT, {"pulse_s": 4e-6, "bandwidth_hz": 20e6}])
    short, long = made.of_each_pulse
    assert (short.modulation, short.pulse, short.bandwidth, short.range_max) == ("none", 8e-8, pytest.approx(15e6), 1500.0)
    assert (long.modulation, long.pulse, long.bandwidth, long.range_max) == ("lfm", 4e-6, 20e6, 5000.0)
    assert short.window == "none" and long.window == "hamming"
    assert short.sample_rate == long.sample_rate == made.sample_rate == 30e6
    assert (short.bins, long.bins) == (301, 1001)  # cells of 4.997 m
    assert short == radar(**SHORT, sample_rate_hz=30e6)
    assert long == radar(pulse_s=4e-6, bandwidth_hz=20e6)
    assert radar(pulses=[{"pulse_s": 4e-6}]) == radar(pulse_s=4e-6)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"pulses": [SHORT, {}], "pulse_s": 1e-6}, "radar.pulse_s: with pulses, each pulse has its own: move it into pulses"),
        ({"pulses": [SHORT, {"range_max_m": 5000}]}, "radar.pulses[1].range_max_m: the last pulse serves all farther ranges"),
        ({"pulses": [{"pulse_s": 1e-7, "modulation": "none"}, {}]}, "radar.pulses[0].range_max_m: it is missing"),
        ({"pulses": [SHORT, SHORT, {}]}, "radar.pulses[1].range_max_m: 1500 m; the ends rise strictly, from above 1500 m"),
        ({"pulses": [SHORT, {}], "range_max_m": 1200}, "to below range_max_m, 1200 m: correct it"),
        ({"pulses": [SHORT, {"pulse_s": 1e-8}]},
         "radar.pulses[1].pulse_s: bandwidth x pulse is 0.5; a chirp needs at least 4"),
        ({"pulses": [{**SHORT, "window": "hann"}, {}]}, 'radar.pulses[0].window: "hann" needs a chirp'),
        ({"pulses": [SHORT, {"compression": "inverse"}]}, 'radar.pulses[1].compression: "inverse" with window "hamming"'),
        ({"pulses": [SHORT, {}], "sample_rate_hz": 20e6}, "radar.sample_rate_hz: 2e+07 is below the bandwidth"),
        ({"pulses": [SHORT, {"pulse": 1}]}, "radar.pulses[1].pulse"),
        ({"pulses": [SHORT, {"pulse_s": 0}]}, "radar.pulses[1].pulse_s: 0"),
        ({"pulses": [SHORT] * 9}, "radar.pulses"),
        ({"pulses": [SHORT, {}], "beamwidth_deg": 0.4}, "radar.beamwidth_deg: 0.4 degrees are narrower"),
        ({"pulses": [SHORT, {}], "prf_hz": 35_000}, "5000 m is beyond the 4283 m"),
    ],
)  # fmt: skip
def test_impossible_lists_are_refused_with_the_remedy(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as fault:
        load_scene({"radar": settings})
    assert message in str(fault.value)

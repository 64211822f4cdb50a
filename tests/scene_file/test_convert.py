"""Radar, environment and seaway of a scene file in SI units, defaults of hulls, and which bodies a seaway moves."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.radar.patterns import PATTERNS, Table, Taylor
from radar_service.scene_file.convert import HullExtent, extent_of, hull_from_model
from radar_service.scene_file.describe import describe
from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.moving import HullModel
from radar_service.world.motion import Motion
from radar_service.world.seaway import Sway
from radar_service.world.seaway_motion import SeawayMotion
from radar_service.world.shapes import shape_mesh
from tests.scene_file.model.test_model import HULL
from tests.scenes import point, radar, scene

LIGHT = 299_792_458.0


def test_defaults_and_converted_units() -> None:
    radar = {"pattern": [[0, 0], [1, -3], [2, -40]], "blind_sectors_deg": [[90, 180]], "tilt_deg": -2, "loss_db": 3}
    scene = load_scene({"radar": radar, "environment": {"earth": "flat", "gas_db_per_km": "itu", "wind_from_deg": 90}})
    assert scene.radar.pattern.rows[1] == (pytest.approx(math.radians(1)), pytest.approx(10**-0.3))
    assert scene.radar.blind_sectors == ((pytest.approx(math.pi / 2), pytest.approx(math.pi)),)
    assert scene.radar.loss == pytest.approx(10**0.3)
    assert scene.environment.earth_factor == math.inf
    assert scene.environment.gas_db_per_km == pytest.approx(0.01327, rel=0.1)  # P.676-12 Annex 1; 10 % as Annex 2 claims
    assert scene.environment.wind_from == pytest.approx(math.pi / 2)
    assert scene.radar.sample_rate == 75e6


def test_defaults_of_a_plain_pulse() -> None:
    """A receiver of 1.2 / T, sampled 1.5 times as fast, and no window."""
    made = radar(modulation="none", pulse_s=0.25e-6)
    assert (made.bandwidth, made.sample_rate, made.window) == (pytest.approx(4.8e6), pytest.approx(7.2e6), "none")
    assert made.unambiguous_range == np.inf
    assert radar(prf_hz=1500).unambiguous_range == pytest.approx(LIGHT / 3000)


def test_the_level_of_labels_is_a_power_ratio() -> None:
    assert (radar().label_floor, radar(labels_within_db=20).label_floor) == (1e-3, pytest.approx(0.01))
    assert radar(labels_within_db="none").label_floor == 0.0


def test_patterns_of_both_planes() -> None:
    """The vertical pattern is the horizontal one by default, sinc2 where that is a table, and its own where it is given."""
    assert radar(pattern="cosine").pattern_el == PATTERNS["cosine"]
    assert radar(pattern=[[0, 0], [2, -20]]).pattern_el == PATTERNS["sinc2"]
    assert radar(pattern="taylor", taylor_sidelobe_db=35, taylor_nbar=5).pattern == Taylor(35.0, 5)
    table = radar(pattern_el=[[0, 0], [10, -3]]).pattern_el
    assert isinstance(table, Table) and table.rows[1] == (pytest.approx(np.deg2rad(10)), pytest.approx(10**-0.3))


BOX = {"name": "box", "shape": "box", "length_m": 4, "width_m": 2, "height_m": 2, "position_m": [50, 300, -0.5]}


def law_of(motion: Motion) -> SeawayMotion:
    assert isinstance(motion.sway, SeawayMotion)
    return motion.sway


def seaway(environment: dict[str, Any]) -> Any:
    return scene(environment=environment).environment.seaway


def test_the_sea_state_gives_height_and_period_and_the_wind_the_direction() -> None:
    made = seaway({"sea_state": 5, "wind_from_deg": 200, "seaway": True})
    assert (made.height, made.period) == pytest.approx(
        (2.977, 9.521), abs=1e-3
    )  # 0.04 + 0.1 x 5^2.1; 8.8 + 0.9 x 1.102/1.375
    assert (made.seed, made.spread) == (0, 1.0)
    assert np.rad2deg(made.towards) % 360.0 == pytest.approx(20.0)
    given = seaway({"sea_state": 5, "seaway": {"height_m": 1.375, "from_deg": 10, "seed": 3}})
    assert given.height == 1.375 and given.period == pytest.approx((7.5 + 8.8) / 2)  # between 0.875 and 1.875 m
    assert np.rad2deg(given.towards) == pytest.approx(190.0) and given.seed == 3
    assert seaway({"sea_state": 5}) is None and seaway({"seaway": False}) is None


def test_a_seaway_moves_what_floats() -> None:
    """Hulls and own ship; a box that has a table `hull`; not a pile, a point, nor what sways by itself."""
    bodies = [
        HULL, HULL | {"name": "moored", "hull": {"floats": False}}, HULL | {"name": "own", "roll_deg": 3.0, "list_deg": 1.0},
        BOX, BOX | {"name": "raft", "hull": {}}, point("buoy", 0, 400), point("float", 0, 600, hull={"length_m": 3, "beam_m": 3}),
    ]  # fmt: skip
    made = scene(bodies, environment={"sea_state": 3, "seaway": True})
    moved = [body.name for body in made.bodies if isinstance(body.motion.sway, SeawayMotion)]
    assert moved == ["h", "raft", "float"] and isinstance(made.own_ship.sway, SeawayMotion)
    own = made.bodies[2].motion.sway
    assert isinstance(own, Sway) and own.lean == (np.deg2rad(1.0), 0.0)
    seas = {id(law_of(body.motion).waves) for body in made.bodies if body.name in moved}
    assert len(seas) == 1 and law_of(made.own_ship).waves is law_of(made.bodies[0].motion).waves
    still = scene(bodies, environment={"sea_state": 3})
    assert not any(isinstance(body.motion.sway, SeawayMotion) for body in still.bodies) and still.own_ship.sway is None


def test_own_ship_that_is_a_body_moves_as_that_body() -> None:
    made = scene([HULL, point("p", 0, 900)], own_ship={"body": "h"}, environment={"sea_state": 3, "seaway": True})
    assert law_of(made.own_ship) is law_of(made.world.bodies[0].motion)
    time = np.array([12.0])
    roll = made.own_ship.sway_state(time).values[0, 0]
    assert roll and made.antenna(12.0)[0, 2] != 15.0


def test_lists_and_trims_are_drawn_for_each_ship_by_seed() -> None:
    def leans(**sea: Any) -> np.ndarray:
        ships = [HULL | {"name": f"{k}", "position_m": [200 * k, 500, 0]} for k in range(60)]
        made = scene(ships, environment={"sea_state": 3, "seaway": {"list_deg": 1.0, "trim_deg": 0.3, **sea}})
        return np.rad2deg([law_of(body.motion).lean for body in made.bodies])

    drawn = leans()
    assert drawn.std(axis=0) == pytest.approx([1.0, 0.3], rel=4.0 / np.sqrt(120.0))  # 4 sigma of a deviation of 60
    np.testing.assert_array_equal(leans(), drawn)
    assert (leans(seed=1) != drawn).all() and not leans(list_deg=0.0, trim_deg=0.0).any()
    given = scene([HULL | {"list_deg": -2.0}], environment={"sea_state": 3, "seaway": {"trim_deg": 0.0}})
    assert law_of(given.bodies[0].motion).lean == (np.deg2rad(-2.0), 0.0)


def test_a_list_without_a_seaway_leans_a_ship_for_ever() -> None:
    made = scene([HULL | {"list_deg": 4.0, "trim_deg": -1.0}])
    pose = made.bodies[0].motion.pose(1e6)
    assert pose.rotation is not None
    np.testing.assert_allclose(pose.rotation[0] @ [1.0, 0.0, 0.0], [np.cos(np.deg2rad(4)), -0.00122, -0.06975], atol=1e-4)
    assert pose.rotation[0][2, 1] == pytest.approx(-np.sin(np.deg2rad(1.0)))  # the bow is down


def test_hulls_have_the_sizes_of_their_meshes() -> None:
    mesh = shape_mesh("box", {"length_m": 40.0, "width_m": 9.0, "height_m": 7.0}, 0.1)
    extent = extent_of(mesh, -2.5)
    assert extent == HullExtent(40.0, 9.0, 2.5, (0.0, 0.0)) and extent_of(mesh, 1.0).depth == 0.0
    form = hull_from_model(HullModel(), extent, None, "body[0]")
    assert (form.length, form.breadth, form.draught, form.block, form.roll_damping) == (40.0, 9.0, 2.5, 0.7, 0.1)
    assert form.waterplane == pytest.approx(0.8)
    c = 0.373 + 0.023 * 9.0 / 2.5 - 0.043 * 40.0 / 100.0  # IMO MSC.267(85), part A, 2.3.4
    assert form.roll_period == pytest.approx(2.0 * c * 9.0 / np.sqrt(0.9))


def test_keys_of_a_hull_come_before_its_mesh() -> None:
    extent = HullExtent(40.0, 9.0, 0.0, (1.0, 2.0))
    assert hull_from_model(HullModel(), extent, None, "").draught == pytest.approx(3.6)
    assert hull_from_model(HullModel(), extent, 3.0, "").draught == 3.0
    given = {"length_m": 30.0, "beam_m": 8.0, "draught_m": 2.0, "block": 0.5, "waterplane": 0.75}
    given |= {"roll_period_s": 6.0, "roll_damping": 0.2}
    form = hull_from_model(HullModel(**given), extent, 3.0, "")
    assert list(given.values()) == [
        form.length, form.breadth, form.draught, form.block, form.waterplane, form.roll_period, form.roll_damping
    ]  # fmt: skip
    assert form.middle == (1.0, 2.0)


def test_what_has_no_size_needs_one_to_float() -> None:
    with pytest.raises(rs.SceneError, match=r"body\[0\].hull.length_m: the body has no size of its own; give length_m"):
        scene([point("p", 0, 400, hull={})], environment={"sea_state": 3, "seaway": True})


def test_an_antenna_that_a_high_sea_would_dip_is_refused() -> None:
    sea = {"sea_state": 6, "seaway": True}
    with pytest.raises(rs.SceneError, match="own_ship.heave_m"):
        scene([point("p", 0, 400)], radar={"height_m": 4}, environment=sea)
    assert scene([point("p", 0, 400)], radar={"height_m": 15}, environment=sea).own_ship.sway is not None


def test_check_tells_how_ships_move() -> None:
    made = scene([HULL | {"list_deg": 1.0}], environment={"sea_state": 3, "seaway": {"trim_deg": 0.0}})
    text = describe(made)
    assert "in the seaway up to" in text and "listing 1 degrees" in text
    assert "waves of 1.04 m in 7.72 s from 000.0" in text

"""Resting echoes against the radar equation, and the shadows that moving bodies cast on them against every line of sight."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.resting import PassingShadows
from radar_service.engine.preparation import Prepared, prepare
from radar_service.records.fidelity import PRESETS
from tests.occlusion import occluded
from tests.reference.compressed_pulse import sinc2_beam
from tests.scenes import point, scene

EARTH = 4 / 3 * 6_371_000.0
RADAR = {"range_max_m": 1500, "azimuths": 360, "beamwidth_deg": 4, "beamwidth_el_deg": 20}
SHIP = {"name": "ship", "shape": "hull", "length_m": 120, "beam_m": 20, "height_m": 40, "position_m": [-100, 400, 0],
        "course_deg": 90, "speed_kn": 20, "rcs_dbsm": 10}  # fmt: skip


def prepared(made: rs.Scene) -> Prepared:
    return prepare(made, PRESETS["balanced"], 3)


def test_echoes_of_points_follow_the_radar_equation() -> None:
    """Range, bearing, level and phase by own formulas, by rising bearing; none beyond the last bin and cT/2, 2999 m."""
    rng = np.random.default_rng(4)
    positions = rng.uniform(-1000, 1000, (30, 2))
    bodies = [point(f"p{k}", *map(float, position), up=float(k), rcs_dbsm=k - 10) for k, position in enumerate(positions)]
    made = scene([*bodies, point("far", 0, 3100)], radar=RADAR)
    resting, radar = prepared(made).resting, made.radar
    assert len(resting) == 30 and (np.diff(resting.echoes.azimuth) > 0).all()
    for e, b in enumerate(resting.body):
        d2 = float(positions[b] @ positions[b])
        z = b - 15.0 - d2 / (2 * EARTH)
        r = np.sqrt(d2 + z * z)
        assert resting.echoes.range[e] == pytest.approx(r, rel=1e-14)
        assert resting.echoes.azimuth[e] == pytest.approx(np.arctan2(*positions[b]), rel=1e-12)
        power = radar.power * radar.gain**2 * radar.wavelength**2 * 10 ** (b / 10 - 1) / ((4 * np.pi) ** 3 * r**4)
        level = np.sqrt(power) * sinc2_beam(np.arctan2(z, np.sqrt(d2)), radar.beamwidth_el)
        expected = level * np.exp(-4j * np.pi * r / radar.wavelength)
        assert abs(resting.echoes.amplitude[e] - expected) < 1e-6 * np.sqrt(power)  # the table of the elevation pattern


def test_bodies_at_rest_occlude_and_moving_ones_do_not() -> None:
    wall = {"name": "wall", "shape": "plate", "width_m": 40, "height_m": 60, "position_m": [500, 0, 20], "rcs_dbsm": 0,
            "heading_deg": 90}  # fmt: skip
    ship = {**SHIP, "position_m": [0, 400, 0]}
    made = scene([point("behind ship", 0, 900), point("behind wall", 900, 0), wall, ship], radar=RADAR)
    engine = prepared(made)
    assert [engine.resting_set.bodies[b].name for b in np.unique(engine.resting.body)] == ["behind ship", "wall"]


@pytest.fixture
def quay() -> rs.Scene:
    """A field of points behind the line on which a ship passes."""
    points = [point(f"p{k}{n}", 40.0 * k, 600.0 + 50 * n, up=3 + n) for k in range(-10, 11) for n in range(6)]
    return scene([*points, SHIP], radar=RADAR)


def test_shadows_are_the_echoes_that_a_moving_body_occludes(quay: rs.Scene) -> None:
    """At each step those whose line of sight the ship crosses, every line tried; with opposite sign, so that the sum is 0."""
    engine = prepared(quay)
    resting, interval = engine.resting, engine.moving.visibility.interval
    counts = []
    for step in range(0, 60, 6):
        shadows = engine.shadows.at(step)
        time = (step + 0.5) * interval
        hidden = occluded(engine.line_of_sight, resting.position, resting.antenna, time)
        np.testing.assert_array_equal(shadows.range, resting.echoes.range[hidden])
        np.testing.assert_array_equal(shadows.azimuth, resting.echoes.azimuth[hidden])
        np.testing.assert_array_equal(shadows.amplitude, -resting.echoes.amplitude[hidden])
        np.testing.assert_array_equal(shadows.body, resting.scene_body[hidden])
        counts.append(len(shadows.range))
    assert max(counts) > 15 and min(counts) < max(counts) < len(resting)


def test_shadows_are_possible_where_something_moves_before_something_that_rests() -> None:
    target, small = point("t", 0, 900), point("p", 100, 300, speed_kn=5, course_deg=90)
    bodies = {"both": [target, SHIP], "no ship": [target], "a point": [target, small], "no target": [SHIP]}
    possible = {name: prepared(scene(each, radar=RADAR)).shadows.possible for name, each in bodies.items()}
    assert possible == {"both": True, "no ship": False, "a point": False, "no target": False}


def test_shadows_of_a_step_are_computed_once(quay: rs.Scene) -> None:
    engine = prepared(quay)
    shadows = PassingShadows(engine.resting, engine.line_of_sight, 0.5, np.ones(len(engine.resting_set), dtype=np.bool_))
    first = shadows.at(4)
    assert shadows.at(4) is first and len(first.range)
    anew = shadows.computed(4, 2.25)
    assert anew is not first and np.array_equal(anew.range, first.range)


def test_the_profile_of_a_shadowed_point_is_empty() -> None:
    """Through `profiles`: the finished profile of rest and its shadow cancel to the kernel's -60 dB."""
    ship = {**SHIP, "position_m": [0, 400, 0], "speed_kn": 1, "rcs_dbsm": -80}
    shadowed, free = (scene(bodies, radar=RADAR) for bodies in ([point("t", 0, 900), ship], [point("t", 0, 900)]))
    left, whole = (rs.Simulator(made).scan().power.max() for made in (shadowed, free))
    assert left < 1e-6 * whole

"""Ships of the chart: a corner that rolls, which two bounces have right, and which ships of a scene are taken."""

from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.records.fidelity import PRESETS
from radar_service.study.chart.ships_panel import BOUNCES, METHODS, ROLL, SHIPS, RollingShip, rolling_ships, ships_points
from tests.scattering.physical_optics.meshes import dihedral, write_obj
from tests.scenes import point, scene

RADAR = {"azimuths": 720, "beamwidth_deg": 6.0, "range_max_m": 600, "rpm": 24}
UNDER_WAY = {"scattering": "optics", "material": "steel", "speed_kn": 3.0, "course_deg": 135.0, "heading_deg": 135.0}


def corner(folder: Path) -> rs.Scene:
    """A dihedral of 4 m at 300 m that opens toward the antenna, under way; its 256 triangles share a trace as it rolls."""
    write_obj(folder / "corner.obj", dihedral(4.0, 4.0, 8))
    body = {"name": "corner", "mesh": "corner.obj", "position_m": [0.0, 300.0, 15.0], **UNDER_WAY}
    return rs.load_scene({"radar": RADAR, "environment": {"multipath": False}, "body": [body]}, folder=folder)


def test_two_bounces_have_the_power_of_a_rolling_corner_and_shared_traces_keep_it(tmp_path: Path) -> None:
    """Optics of a corner is exact however it is cut: with two bounces tubes of half the size change it by less than 0.1 dB
    (tests/scattering/physical_optics). One bounce lacks it."""
    ships, done = rolling_ships(corner(tmp_path)), list[int]()
    crossing, nodes = (ship := RollingShip.of(ships[0], PRESETS["balanced"])).nodes(1)
    assert len(ship.passages.runs(0, crossing)) == len(nodes) > 3
    points = ships_points(ships, 1, lambda: done.append(1))
    assert len(points) == METHODS - 1 and len(done) == METHODS
    errors = [each.error_db or 0.0 for each in points]
    assert errors[0] > 10.0 and max(errors[1:]) < 0.1
    assert {each.setting: each.preset for each in points if each.preset} == {
        "3 bounces": "reference",
        "0.1 degrees": "balanced",
    }
    assert all(len(each.times) == 1 and each.spread_db is not None for each in points)


def test_the_three_ships_with_the_most_triangles_roll_alone() -> None:
    hull = {"shape": "hull", "beam_m": 4.0, "height_m": 3.0, **UNDER_WAY}
    ships = [{**hull, "name": f"{k}", "length_m": 10.0 + k, "position_m": [100.0 * k, 300.0, 0.0]} for k in range(4)]
    resting = {**ships[0], "name": "moored", "speed_kn": 0.0}
    made = rolling_ships(scene([*ships, resting, point("buoy", 0, 200)], radar=RADAR))
    assert len(made) == SHIPS and all(len(each.bodies) == 1 for each in made)
    assert "moored" not in [each.bodies[0].name for each in made]
    sway = made[0].bodies[0].motion.sway
    assert sway is not None and sway.amplitude[0] == ROLL
    assert rolling_ships(scene([resting], radar=RADAR)) == []


@pytest.mark.parametrize("bounces", BOUNCES)
def test_finer_facets_are_finer(bounces: int, tmp_path: Path) -> None:
    """Half the edge makes four times as many echo centres or more in range."""
    (ship,) = rolling_ships(corner(tmp_path))
    fidelity = PRESETS["balanced"]
    plain, fine = (RollingShip.of(ship, fidelity, finer) for finer in (1.0, 0.25))
    crossing, nodes = plain.nodes(1)
    counts = [len(each.passages.evaluated(0, nodes[0], 0.0).echoes) for each in (plain, fine)]
    assert counts[1] > counts[0] and np.isfinite(plain.powers(crossing, nodes)).all()


def test_a_ship_beyond_the_range_has_no_point() -> None:
    """Her powers are 0, and so would be what others are compared with."""
    hull = {"name": "far", "shape": "hull", "length_m": 30.0, "beam_m": 6.0, "height_m": 5.0, **UNDER_WAY}
    assert (
        ships_points(rolling_ships(scene([{**hull, "position_m": [0.0, 20_000.0, 0.0]}], radar=RADAR)), 1, lambda: None)
        == []
    )

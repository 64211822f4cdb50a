"""Land of the chart under way: grid and range histories on one slab, the presets that work so, and scenes without such land."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.constants import KNOT
from radar_service.study.chart.land_panel import METHODS, NUMBERS_OF_RINGS, PIECES, STEPS, land_points, land_under_way
from radar_service.study.chart.point import Point
from tests.engine.land_scenes import OWN_SHIP, RADAR, SLAB

AZIMUTHS, REPEATS = 16, 2


def slab(distance: float, **own_ship: Any) -> rs.Scene:
    """A slab of 9 m, north of own ship by so much [m]."""
    body = SLAB | {"position_m": [0.0, distance, 0.0]}
    world = {"environment": {"multipath": True, "noise": True, "sea_state": 3}, "body": [body]}
    return rs.load_scene({"radar": RADAR, "own_ship": OWN_SHIP | own_ship, **world})


def points_of(made: rs.Scene) -> list[Point]:
    """The points of a scene, which has land; `done` is called for all runs of all methods, but the second of the slowest."""
    way, done = land_under_way(made), list[int]()
    assert way is not None
    points = land_points(way, AZIMUTHS, REPEATS, 0, lambda: done.append(1))
    assert len(done) == METHODS * REPEATS - 1
    return points


def errors(points: list[Point], family: str) -> list[float]:
    """The errors of a family [dB], in order of its settings."""
    return [point.error_db or 0.0 for point in points if point.family == family]


def test_rings_count_near_own_ship_and_steps_of_visibility_wherever_faces_turn_to_her() -> None:
    """200 m off bearings change less than in the middle of one ring of all ranges (-41 dB); 8 rings err by -48 dB. Histories have
    the phase of every point, so that their error is that of visibility: -62 dB at steps of 1 m, -30 dB at 20 m."""
    points = points_of(slab(200.0))
    assert len(points) == METHODS - 1
    rings, histories = errors(points, "grid, rings"), errors(points, "range histories")
    assert len(rings) == len(NUMBERS_OF_RINGS) and rings[0] > -44.0 > rings[3]
    assert abs(rings[3] - rings[4]) < 1.0
    pieces = errors(points, "grid, visibility")
    assert pieces[0] < rings[3] < pieces[-1]  # 16, 64 and 128 azimuths
    assert len(histories) == len(STEPS) and histories[1] < -55.0 and histories[-1] > -35.0
    assert [len(each.times) for each in points] == [REPEATS] * (METHODS - 2) + [1]
    assert {each.preset: each.setting for each in points if each.preset} == {
        "balanced": "each 5 m",
        "reference": "each 1 m",
    }


def test_a_slab_is_the_same_on_grids_of_any_pieces_and_rings() -> None:
    """Within the -38 dB that hold at the border, 400 m off, where own ship passes it abeam and each face stays in sight."""
    points = points_of(slab(400.0, course_deg=90.0))
    on_grid = errors(points, "grid, rings") + errors(points, "grid, visibility")
    assert len(on_grid) == len(NUMBERS_OF_RINGS) + len(PIECES)
    assert max(on_grid) < -38.0 and errors(points, "range histories")[0] < -60.0


def test_balanced_takes_the_grid_where_it_saves_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.engine.land_rows.ROW_SECONDS", 0.0)
    presets = {each.preset: each.setting for each in points_of(slab(200.0)) if each.preset}
    assert presets == {"balanced": "8 rings", "reference": "each 1 m"}


def test_own_ship_passes_the_land_alone_straight_ahead() -> None:
    made = land_under_way(slab(200.0, turn_rate_deg_s=3.0, roll_deg=5.0, roll_period_s=8.0))
    assert made is not None and made.own_ship.sway is None
    assert not made.environment.noise and made.environment.sea_state == 0 and made.environment.multipath
    before, after = (made.own_ship.pose(time) for time in (0.0, 100.0))
    way = (after.position - before.position).ravel()
    ahead = np.array([np.sin(np.deg2rad(200.0)), np.cos(np.deg2rad(200.0)), 0.0])
    assert np.allclose(way, 100.0 * 8.0 * KNOT * ahead, atol=1e-6) and after.heading == before.heading


@pytest.mark.parametrize(
    "change", [{"material": "steel"}, {"speed_kn": 3.0, "course_deg": 0.0}, {"swerling": 1, "rcs_dbsm": 9}]
)
def test_metal_movers_and_declared_bodies_are_no_land(change: dict[str, Any]) -> None:
    made = rs.load_scene({"radar": RADAR, "own_ship": OWN_SHIP, "body": [SLAB | change]})
    assert land_under_way(made) is None


def test_land_out_of_range_has_no_points() -> None:
    assert points_of(slab(20_000.0)) == []

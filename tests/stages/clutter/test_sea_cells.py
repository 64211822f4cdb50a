"""Where the sea is seen: geometry against the frames, and what stands in the way."""

from typing import Any

import numpy as np
import pytest

from radar_service.numerics.frames import effective_earth_radius, polar_from_map
from radar_service.stages.clutter import sea_cells
from radar_service.stages.clutter.sea_cells import SeaCells, sea_point
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import scene

SEA = {"environment": {"sea_state": 3, "wind_from_deg": 90}, "radar": {"range_max_m": 1500}}
WALL = {
    "name": "wall", "shape": "box", "length_m": 20, "width_m": 400, "height_m": 60, "position_m": [0, 600, 0],
    "rcs_dbsm": 0,
}  # fmt: skip


@pytest.mark.parametrize("factor", [4 / 3, np.inf])
def test_sea_points_are_where_the_frames_say(factor: float) -> None:
    """Height 0 at the ground distance has the requested slant range (1 mm) and the elevation; grazing is the elevation
    from there back up, less the earth's own slope."""
    radius = effective_earth_radius(factor)
    requested = np.array([16.0, 100.0, 1000.0, 10_000.0])
    point = sea_point(requested, 15.0, radius)
    on_map = np.stack([point.distance, np.zeros(4), np.zeros(4)], axis=1)
    polar = polar_from_map(on_map, np.array([0.0, 0.0, 15.0]), radius)
    np.testing.assert_allclose(polar.range, requested, atol=1e-3)
    np.testing.assert_allclose(polar.elevation, point.elevation, atol=1e-12)
    np.testing.assert_allclose(point.grazing, -polar.elevation - point.distance / radius, atol=1e-12)


def test_grazing_ends_at_the_horizon_and_nothing_lies_within_the_antennas_height() -> None:
    """15 m: horizon 15.964 km; at 1 km 15/1000 rad less 1000/(2 ae)."""
    radius = effective_earth_radius(4 / 3)
    grazing = sea_point(np.array([10.0, 1000.0, 15_960.0, 15_970.0]), 15.0, radius).grazing
    assert grazing[0] == 0.0
    assert grazing[1] == pytest.approx(np.arcsin(0.015) - 1000 / (2 * radius), abs=1e-7)
    assert grazing[2] > 0 > grazing[3]


def cells_of(bodies: list[dict[str, Any]], rows: int, max_range: float = 1500.0, **changes: object) -> SeaCells:
    made = scene(bodies, **(SEA | changes))
    return SeaCells(made, OcclusionScene(made.bodies, effective_earth_radius(4 / 3)), rows, max_range)


def levels(**changes: object) -> tuple[SeaCells, np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    cells = cells_of([WALL], 64, **changes)
    return cells, np.asarray(cells.rows.span(64, 128), dtype=np.float64)


def test_a_wall_shadows_the_sea_behind_it_and_no_other() -> None:
    """The box 20 x 400 m stands from 590 to 610 m north, 200 m each side; cells are judged one clear of its edges."""
    cells, level = levels()
    cell = cells.bins * 1.99862
    before, behind = int(590 / cell) - 1, int(595 / cell) + 1
    assert (level[0, 3:before] > 0).all() and (level[0, behind:] == 0).all()
    assert (level[16, 3:] > 0).all() and (level[32, 3:] > 0).all()  # east and south
    assert (level[:, 0] == 0).all()  # 0 to 10 m: nearer than the antenna is high
    assert level[16, 50] == level[:, 50].max() and level[16, 50] / level[48, 50] > 3  # upwind, 5.9 dB over downwind


def test_shadows_on_the_sea_follow_a_moving_antenna() -> None:
    """Going north at 40 kn past x = -1000: at first the wall bears 059, a minute later (1235 m on) 122 degrees (row 22)."""
    own = {"position_m": [-1000, 0], "course_deg": 0, "speed_kn": 40}
    cells, first = levels(own_ship=own)
    sector = int(np.rint(np.arctan2(1000, 600) / (2 * np.pi) * 64))
    assert first[sector, -1] == 0 and first[22, -1] > 0
    later = cells.rows.span(24 * 64, 25 * 64)
    assert later[sector, -1] > 0 and later[22, -1] == 0


def test_a_moving_body_shadows_the_sea_behind_it_and_takes_its_shadow_along() -> None:
    """The wall goes east at 20 m/s on its 600 m north, 400 m of it across: north of it is dark at first, and 25 s later light;
    then north-east is dark. A wall at rest where it is then gives the same cells, but for its edges (1 m in half a block)."""
    moving = {**WALL, "course_deg": 90, "heading_deg": 0, "speed_kn": 20 / 0.5144444}
    cells = cells_of([moving], 720)
    last, north_east = cells.count - 1, 80
    assert cells.rows.span(0, 1)[0, last] == 0 and cells.rows.span(80, 81)[0, last] > 0
    later = np.array(cells.rows.span(720 * 10, 720 * 10 + 160))
    assert later[0, last] > 0 and later[north_east, last] == 0
    at_rest = cells_of([{**WALL, "position_m": [20.0 * (10 + 80 / 720) * 2.5, 600, 0]}], 720)
    dark = at_rest.rows.span(0, 160) == 0
    assert np.mean((later == 0) != dark) < 0.02 < np.mean(dark)


@pytest.mark.parametrize("own_ship", [{}, {"course_deg": 300, "speed_kn": 25}], ids=["at rest", "under way"])
def test_sweeps_leave_no_shadow_out(own_ship: dict[str, object], monkeypatch: pytest.MonkeyPatch) -> None:
    """Three bodies under way round about, one turning close by, and one at rest that own ship passes: rows are those of a
    computation of all shadows in all rows."""
    bodies = [
        {**WALL, "name": name, "position_m": position, "course_deg": course, "speed_kn": 30, **more}
        for name, position, course, more in (
            ("a", [0, 600, 0], 90, {}), ("b", [-300, -250, 0], 10, {"width_m": 60}), ("c", [90, 20, 0], 180, {"width_m": 30})
        )
    ]  # fmt: skip
    bodies.append({**WALL, "name": "d", "position_m": [-400, 300, 0], "width_m": 50})
    cells, every = (cells_of(bodies, 512, own_ship=own_ship) for _ in range(2))
    swept = [cells.rows.span(512 * scan, 512 * (scan + 1)) for scan in (0, 1, 5)]
    monkeypatch.setattr(sea_cells, "SWEEP_MARGIN", np.pi)  # all round
    for scan, part in zip((0, 1, 5), swept, strict=True):
        whole = every.rows.span(512 * scan, 512 * (scan + 1))
        np.testing.assert_array_equal(part, whole)
        assert (whole[:, 3:] == 0).any()


def test_a_gate_shadows_the_sea_while_own_ship_passes_it() -> None:
    """At 60 kn between two piers at x = -8 and 8, which count together, just as the beam looks west: dark on the row through
    the middle of the western one, midway between two instants at which sweeps are taken, 19 m before and behind."""
    pier = {"shape": "box", "length_m": 8, "width_m": 2, "height_m": 16}
    piers = [{**pier, "name": str(x), "position_m": [x, 0, 0]} for x in (-8, 8)]
    speed = 60 * 1852 / 3600
    own_ship = {"position_m": [-1, -0.75 * 2.5 * speed], "course_deg": 0, "speed_kn": 60}
    cells = cells_of(piers, 512, own_ship=own_ship)
    west = cells.rows.span(384, 385)[0]
    assert not west[1:].any() and cells.rows.span(256, 257)[0, 1:].all()


def test_earlier_requests_change_nothing() -> None:
    """Rows in one go, or one by one, are the same."""
    own = {"course_deg": 0, "speed_kn": 20}
    one, whole = levels(own_ship=own)
    other, _ = levels(own_ship=own)
    np.testing.assert_array_equal(np.concatenate([other.rows.span(r, r + 1) for r in range(64, 128)]), whole)


def test_the_shadow_on_the_sea_comes_with_its_body_row_by_row() -> None:
    """A box that appears while the beam passes its shadow: rows before are those without it, rows after those with it."""
    box = {"name": "b", "shape": "box", "length_m": 20, "width_m": 200, "height_m": 8, "position_m": [0, 150, 0]}
    rows, settings = 512, {"radar": {"rpm": 60}, "environment": {"sea_state": 3}}
    appears = 1.0 + 5.5 / rows  # s
    boxes = ([{**box, "speed_kn": 0.1, "start_s": start}] for start in (appears, 0.0))
    cells = (cells_of(bodies, rows, 400.0, **settings) for bodies in (*boxes, []))
    late, always, never = (each.rows.span(rows, rows + 16) for each in cells)
    assert np.count_nonzero(always != never) > 100
    np.testing.assert_array_equal(late[:6], never[:6])
    np.testing.assert_array_equal(late[6:], always[6:])

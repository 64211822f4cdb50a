"""Bodies in unusual positions give a warning; bodies under the ground have no echo."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.checks.validity import nearest_point, surfaces_above
from tests.scenes import point, scene

BOX = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 8, "rcs_dbsm": 40}


def plateau(folder: Path, *bodies: dict[str, Any], radar: Any = None, **sections: Any) -> rs.Scene:
    """Land 30 m high, 400 m square, 700 m to the north, rising from the sea within 50 m."""
    heights = np.full((9, 9), 30.0)
    heights[[0, -1]] = heights[:, [0, -1]] = -1.0
    np.save(folder / "land.npy", heights)
    land = {"name": "land", "heightmap": "land.npy", "extent_m": [400, 400], "position_m": [0, 700, 0], "material": "land"}
    small = {"range_max_m": 1200, "azimuths": 90, "beamwidth_deg": 8}
    radars = [small | each for each in radar] if isinstance(radar, list) else small | (radar or {})
    return rs.load_scene({"radar": radars, "body": [land, *bodies], **sections}, folder=folder)


def test_bodies_under_the_ground_give_a_warning(tmp_path: Path) -> None:
    made = plateau(
        tmp_path,
        {"name": "cellar", **BOX, "position_m": [10, 700, 5]},
        {"name": "house", **BOX, "position_m": [10, 700, 25]},
        {"name": "half out", **BOX, "length_m": 300, "position_m": [10, 800, 5]},
        {"name": "beside", **BOX, "position_m": [300, 700, 0]},
        point("treasure", 20, 690, 29.9),
        point("bird", 20, 690, 30.1),
    )
    assert [w for w in made.warnings if "ground" in w] == [
        "body[1]: cellar is under the ground of land, so it has no echo; raise it",
        "body[5]: treasure is under the ground of land, so it has no echo; raise it",
    ]


@pytest.mark.parametrize("speed_kn", [0.0, 10.0])
def test_bodies_under_the_ground_have_no_echo(tmp_path: Path, speed_kn: float) -> None:
    """60 dBsm 2 m under a field changes no byte; 2 m over it, it outshines all else."""
    fields = []
    for up in (None, 28.0, 32.0):
        buried = [] if up is None else [point("t", 0, 600, up, 60.0, speed_kn=speed_kn, course_deg=90)]
        fields.append(rs.Simulator(plateau(tmp_path, *buried)).scan().field)
    assert np.isfinite(fields[1]).all()
    np.testing.assert_array_equal(fields[1], fields[0])
    assert np.abs(fields[2]).max() > 10 * np.abs(fields[0]).max()


def test_unusual_positions_give_a_warning_and_others_do_not() -> None:
    box = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 40}
    made = scene(
        [
            {"name": "around", **box},
            {"name": "beside", **box, "position_m": [30, 0, 0]},
            {"name": "overhead", "shape": "plate", "width_m": 9, "height_m": 9, "position_m": [0, 50, 30]},
            {"name": "sunk", **box, "position_m": [300, 0, -41]},
            {"name": "awash", **box, "position_m": [300, 0, -39]},
            point("drowned", 100, 100, -0.1),
            point("touching", 0.3, 0, 15.4),
            point("near", 1.0, 0, 15.0),
        ]
    )
    assert [w.split(":")[0] + w.split(";")[0][8:] for w in made.warnings] == [
        "body[0] the antenna is inside or under around, which occludes all other bodies",
        "body[3] sunk is entirely below the sea, so it has no echo",
        "body[5] drowned is entirely below the sea, so it has no echo",
        "body[6] touching is 0.5 m from the antenna",
    ]


def test_plumb_lines_count_surfaces_once() -> None:
    """Two square floors of two triangles each: the line falls on their diagonals, and counts one triangle of each."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    vertices = np.concatenate([corners, corners + [0, 0, 5]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    assert [surfaces_above(vertices, faces, np.array([0.0, 0.0, up])) for up in (-1.0, 2.0, 6.0)] == [2, 1, 0]
    assert surfaces_above(vertices, faces, np.array([3.0, 0.0, -1.0])) == 0


@pytest.mark.parametrize(
    ("east_north", "height", "words"),
    [
        ((0, 700), 40.0, "own ship is on land, which land has below its antenna; move it to the water, or give the radar a"),
        ((0, 700), 15.0, "the antenna is inside or under land"), ((190, 700), 15.0, "own ship is on land"), ((0, 400), 15.0, ""),
    ],
)  # fmt: skip
@pytest.mark.parametrize("speed_kn", [0.0, 5.0])
def test_own_ship_on_land_gives_a_warning(
    tmp_path: Path, east_north: tuple[float, float], height: float, words: str, speed_kn: float
) -> None:
    """The land is 30 m high, and at its border some 5 m."""
    own_ship = {"position_m": east_north, "speed_kn": speed_kn}
    made = plateau(tmp_path, radar={"height_m": height}, own_ship=own_ship)
    assert [words in warning for warning in made.warnings] == [True] * bool(words)


def test_a_shore_station_may_stand_on_land_and_a_ship_below_a_bridge_on_water(tmp_path: Path) -> None:
    station = [{"id": "vts", "height_m": 40.0, "platform": {"position_m": [0, 700]}}]
    assert plateau(tmp_path, radar=station).warnings == ()
    deck = {"name": "bridge", "shape": "box", "length_m": 9, "width_m": 900, "height_m": 2, "material": "concrete"}
    assert not any("on land" in warning for warning in plateau(tmp_path, {**deck, "position_m": [0, 0, 50]}).warnings)
    assert any("own ship is on land" in warning for warning in plateau(tmp_path, deck, radar={"height_m": 9.0}).warnings)


def test_the_nearest_point_lies_on_an_edge_at_a_corner_or_below() -> None:
    vertices = np.array([[0.0, 0.0, 5.0], [10.0, 0.0, 5.0], [0.0, 10.0, 5.0]])
    faces = np.array([[0, 1, 2]])
    for place, nearest in (
        ((5.0, -3.0), (5.0, 0.0)), ((-3.0, -4.0), (0.0, 0.0)), ((10.0, 10.0), (5.0, 5.0)), ((2.0, 3.0), (2.0, 3.0)),
    ):  # fmt: skip
        np.testing.assert_allclose(nearest_point(vertices, faces, np.array([*place, 7.0])), [*nearest, 7.0], atol=1e-12)

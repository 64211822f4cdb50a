"""Bodies under the ground of a height map: said at loading, and silent."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from tests.scenes import point

BOX = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 8, "rcs_dbsm": 40}


def plateau(folder: Path, *bodies: dict[str, Any]) -> rs.Scene:
    """Land 30 m high, 400 m square, 700 m to the north, rising from the sea within 50 m."""
    heights = np.full((9, 9), 30.0)
    heights[[0, -1]] = heights[:, [0, -1]] = -1.0
    np.save(folder / "land.npy", heights)
    land = {"name": "land", "heightmap": "land.npy", "extent_m": [400, 400], "position_m": [0, 700, 0], "material": "land"}
    radar = {"range_max_m": 1200, "azimuths": 90, "beamwidth_deg": 8}
    return rs.load_scene({"radar": radar, "body": [land, *bodies]}, folder=folder)


def test_what_lies_under_the_ground_is_said(tmp_path: Path) -> None:
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
        "body[1]: cellar lies under the ground of land, so nothing of it is seen; raise it",
        "body[5]: treasure lies under the ground of land, so nothing of it is seen; raise it",
    ]


@pytest.mark.parametrize("speed_kn", [0.0, 10.0])
def test_what_lies_under_the_ground_is_silent(tmp_path: Path, speed_kn: float) -> None:
    """60 dBsm 2 m under a field changes no byte; 2 m over it, it outshines all else."""
    fields = []
    for up in (None, 28.0, 32.0):
        buried = [] if up is None else [point("t", 0, 600, up, 60.0, speed_kn=speed_kn, course_deg=90)]
        fields.append(rs.Simulator(plateau(tmp_path, *buried)).scan().field)
    assert np.isfinite(fields[1]).all()
    np.testing.assert_array_equal(fields[1], fields[0])
    assert np.abs(fields[2]).max() > 10 * np.abs(fields[0]).max()

"""Areas with a tidal stream in scene files: in SI units, by east and north or latitude and longitude, and what is no area."""

import math
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.constants import KNOT
from radar_service.scene_file.describe import describe
from radar_service.scene_file.load import load_scene
from radar_service.world.geo import geographic_from_map
from tests.world.test_currents import HORSESHOE

STREAM: dict[str, Any] = {"current_kn": 2.0, "current_to_deg": 90.0}
ORIGIN = {"latitude_deg": 50.0, "longitude_deg": -1.0}
CORNERS = [[0.0, 0.0], [900.0, 0.0], [900.0, 700.0], [0.0, 700.0]]


def loaded(*areas: dict[str, Any], **scene: Any) -> rs.Scene:
    return load_scene({"current": [STREAM | area for area in areas], **scene})


def test_areas_are_in_si_units() -> None:
    polygon, circle = loaded(
        {"corners_m": CORNERS}, {"position_m": [5, -7], "radius_m": 300, "border_m": 50}
    ).environment.areas
    assert polygon.corners == tuple(map(tuple, CORNERS)) and (polygon.border, polygon.radius) == (200.0, 0.0)
    assert polygon.stream == pytest.approx((2.0 * KNOT, 0.0), abs=1e-15)
    assert (circle.corners, circle.border, circle.radius) == (((5.0, -7.0),), 50.0, 300.0)


def test_latitude_and_longitude_are_the_same_places() -> None:
    """Karney's geodesics come back to a nanometre."""
    corners = geographic_from_map(np.array(CORNERS), (50.0, -1.0)).tolist()
    centre = dict(zip(("latitude_deg", "longitude_deg"), corners[2], strict=True))
    polygon, circle = loaded({"corners_deg": corners}, {**centre, "radius_m": 300}, origin=ORIGIN).environment.areas
    assert np.array(polygon.corners) == pytest.approx(np.array(CORNERS), abs=1e-6)
    assert circle.corners[0] == pytest.approx(CORNERS[2], abs=1e-6)


def test_a_bay_in_an_area_is_no_crossing() -> None:
    """Lines through edges cross there, edges do not."""
    (area,) = loaded({"corners_m": HORSESHOE, "border_m": 50}).environment.areas
    assert area.corners == HORSESHOE


def test_check_prints_them() -> None:
    made = loaded({"corners_m": CORNERS}, {"position_m": [5, -7], "radius_m": 300, "border_m": 50})
    lines = [line for line in describe(made).splitlines() if "current" in line]
    assert lines == [
        "  current   2 kn to 090.0 in a polygon of 4 corners about 450 m E, 350 m N, border 200 m wide",
        "  current   2 kn to 090.0 in a circle of 300 m about 5 m E, -7 m N, border 50 m wide",
    ]


@pytest.mark.parametrize(
    ("area", "message"),
    [
        ({"corners_m": [CORNERS[k] for k in (0, 2, 1, 3)]}, r"current\[0\].corners_m: edges 0 and 2 cross"),
        ({"corners_m": CORNERS, "border_m": 800}, r"current\[0\].border_m: 800 m is too wide .* give at most 787.5 m"),
        ({"position_m": [0, 0], "radius_m": 99}, "give at most 198 m"),
        ({"corners_m": [[0, 0], [500, 0], [900, 0]]}, "give at most 0 m, or a larger area"),
    ],
)
def test_what_is_no_area_is_refused(area: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        loaded(area)


def test_errors_of_areas_stand_beside_others() -> None:
    body = {"name": "b", "shape": "point", "rcs_dbsm": 0, "material": "cheese"}
    with pytest.raises(rs.SceneError) as error:
        loaded({"position_m": [0, 0], "radius_m": 10}, body=[body])
    assert "border_m" in str(error.value) and "cheese" in str(error.value)
    assert math.isfinite(loaded({"position_m": [0, 0], "radius_m": 100}).environment.areas[0].deepest)

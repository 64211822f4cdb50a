"""What a table of an area with a tidal stream may have, and what not."""

from typing import Any

import pytest

from radar_service.scene_file.load import load_scene
from radar_service.scene_file.model.current import CurrentModel
from radar_service.world.error import SceneError
from tests.scene_file.test_currents import CORNERS, STREAM


@pytest.mark.parametrize(
    ("area", "message"),
    [
        ({}, r"corners_m: an area has exactly one of .* this one has none"),
        ({"corners_m": CORNERS, "position_m": [0, 0]}, "this one has corners_m, position_m"),
        ({"corners_m": CORNERS[:2]}, "corners_m"),
        ({"corners_m": CORNERS, "radius_m": 5}, "a polygon has none; remove it"),
        ({"position_m": [0, 0]}, "a circle has radius_m, a polygon has none; add it"),
        ({"latitude_deg": 50.0, "radius_m": 500}, "latitude_deg and longitude_deg together"),
        ({"corners_deg": [[50, 0], [50, 1], [51, 0]]}, r"current\[0\]: latitudes and longitudes need an \[origin\]"),
        ({"position_m": [0, 0], "radius_m": 500, "current_kn": 0}, "current_kn"),
    ],
)
def test_what_does_not_suit_each_other_is_refused(area: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        load_scene({"current": [STREAM | area]})


def test_degrees_make_it_geographic() -> None:
    polygon, circle = {"corners_m": CORNERS}, {"position_m": [0, 0], "radius_m": 9}
    in_degrees = {"corners_deg": [[50, 0], [50, 1], [51, 0]]}, {"latitude_deg": 1, "longitude_deg": 2, "radius_m": 9}
    assert [CurrentModel(**STREAM | area).is_geographic for area in (polygon, circle, *in_degrees)] == [
        False,
        False,
        True,
        True,
    ]

"""Keys of a seaway and of hulls: ranges, and where they are refused."""

from typing import Any

import pytest

import radar_service as rs
from tests.scenes import scene

HULL = {"name": "h", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8, "position_m": [0, 500, 0]}


@pytest.mark.parametrize(
    ("environment", "message"),
    [
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
)
def test_seaways_without_waves_or_out_of_range_are_refused(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message.replace("[", r"\[")):
        scene([HULL], environment=environment)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"hull": {"block": 0.1}}, r"body\[0\].hull.block"),
        ({"hull": {"roll_damping": 0.01}}, r"body\[0\].hull.roll_damping"),
        ({"hull": {"draught_m": 0}}, r"body\[0\].hull.draught_m"),
        ({"list_deg": 50}, r"body\[0\].list_deg"),
    ],
)
def test_hulls_out_of_range_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        scene([HULL | keys])


@pytest.mark.parametrize("key", ["list_deg", "trim_deg", "hull"])
def test_land_neither_lists_nor_floats(key: str) -> None:
    land = {"name": "land", "heightmap": "map.png", key: {} if key == "hull" else 1.0}
    with pytest.raises(rs.SceneError, match=rf"body\[0\].{key}: a height map is land, .* at rest, .*; remove {key}"):
        scene([land])

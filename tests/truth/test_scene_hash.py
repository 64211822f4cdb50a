"""The hash of a scene changes with anything in it, and with nothing else."""

from typing import Any

import pytest

import radar_service as rs
from radar_service.truth.scene_hash import scene_hash
from tests.scenes import point, scene

BODY = point("a", 100, 200)
OPEN_SEA = "8066494bf7c7f60c1625144f92d2c18e428289e431e61ba893f421309563207c"  # by commit f2943c4, 2026-11-22
BOX = {
    "name": "b",
    "shape": "box",
    "length_m": 4,
    "width_m": 3,
    "height_m": 2,
    "position_m": [500, 0, 0],
    "material": "wood",
}


def hash_of(*bodies: dict[str, Any], **sections: Any) -> str:
    return scene_hash(scene(list(bodies or (BODY, BOX)), **sections))


def test_equal_scenes_have_equal_hashes() -> None:
    assert hash_of() == hash_of() == hash_of(errors={"gyro": {}}) and len(hash_of()) == 64
    assert scene_hash(rs.load_scene("open-sea")) == scene_hash(rs.load_scene("open-sea"))


@pytest.mark.parametrize(
    "other",
    [
        hash_of(BODY), hash_of(BOX, BODY), hash_of(BODY | {"name": "c"}, BOX), hash_of(BODY | {"rcs_dbsm": 10.1}, BOX),
        hash_of(BODY | {"mmsi": 235000001}, BOX), hash_of(BODY | {"course_deg": 5, "speed_kn": 1}, BOX),
        hash_of(BODY, BOX | {"length_m": 4.001}), hash_of(BODY, BOX | {"material": "steel"}),
        hash_of(radar={"azimuths": 1024}), hash_of(radar={"pattern": "taylor"}), hash_of(own_ship={"roll_deg": 1}),
        hash_of(errors={"gyro": {"bias_deg": 1}}),
        hash_of(environment={"sea_state": 3}), hash_of(origin={"latitude_deg": 50.0, "longitude_deg": 0.0}),
    ],
)  # fmt: skip
def test_any_change_changes_it(other: str) -> None:
    assert other != hash_of()


def test_what_it_does_not_know_is_an_error() -> None:
    made = scene([BODY]).with_world(environment=object())
    with pytest.raises(TypeError, match="object"):
        scene_hash(made)


def test_a_radar_of_a_scene_has_a_hash_of_its_own() -> None:
    """Radars with equal settings differ by their ids; the id "0" has the hash of a single [radar], a platform's body counts."""
    both = scene([BODY], radar=[{"id": "0"}, {"id": "aft"}])
    assert scene_hash(both) == scene_hash(scene([BODY])) != scene_hash(both.for_radar("aft"))
    assert scene_hash(scene([BODY], own_ship={"body": BODY["name"]})) != scene_hash(scene([BODY]))


def test_scenes_keep_their_hash_from_version_to_version() -> None:
    """Computed before scenes could have several radars."""
    assert scene_hash(rs.load_scene("open-sea")) == OPEN_SEA

"""Kinds of bodies: which model a table becomes, keys of other kinds, and their order."""

import itertools
from typing import Any

import jsonschema
import pytest
from pydantic import ValidationError

from radar_service.scene_file.describe import json_schema
from radar_service.scene_file.document import validated
from radar_service.scene_file.model.body import (
    KINDS,
    OWN_KEYS,
    BodyModel,
    FadingModel,
    HeightMapBodyModel,
    MeshBodyModel,
    ShapeBodyModel,
)
from radar_service.world.error import SceneError
from tests.scene_file.scene_sources import point, problems

SCHEMA = jsonschema.Draft202012Validator(json_schema())
MESH, LAND = {"name": "m", "mesh": "m.obj"}, {"name": "h", "heightmap": "h.png"}
BALL = {"name": "s", "shape": "sphere", "radius_m": 1}


@pytest.mark.parametrize(
    ("table", "kind"), [(BALL, ShapeBodyModel), (MESH, MeshBodyModel), (LAND, HeightMapBodyModel)]
)  # fmt: skip
def test_the_key_tells_the_kind(table: dict[str, Any], kind: type[BodyModel]) -> None:
    (body,) = validated({"body": [table]}).body
    assert isinstance(body, kind) and body.model_dump(exclude_unset=True) == table
    assert body.can_carry is (kind is not HeightMapBodyModel)
    (same,) = validated({"body": [body]}).body
    assert same == body


def test_null_is_as_good_as_absent_for_keys_that_tell_the_kind_and_for_sizes() -> None:
    table = MESH | {"shape": None, "heightmap": None, "radius_m": None}
    (body,) = validated({"body": [table]}).body
    assert body.model_dump(exclude_unset=True) == MESH and SCHEMA.is_valid({"body": [table]})


def is_accepted(scene: dict[str, Any]) -> bool:
    try:
        validated(scene)
    except SceneError:
        return False
    return True


@pytest.mark.parametrize("table", [BALL, MESH, LAND], ids=KINDS)
def test_the_schema_takes_a_key_of_another_kind_where_the_loader_does(table: dict[str, Any]) -> None:
    """Which is null alone, and not for all; for keys of its own kind the schema takes at least what the loader takes."""
    for (kind, keys), value in itertools.product(OWN_KEYS.items(), (None, 1, "y", [1, 2])):
        for key in keys:
            scene = {"body": [table | {key: value}]}
            taken = is_accepted(scene)
            assert SCHEMA.is_valid(scene) is taken or (kind in table and not taken), (key, value)


@pytest.mark.parametrize(
    ("table", "given"),
    [
        ({"name": "a"}, "none of them"), (BALL | MESH, "shape and mesh"), (MESH | LAND, "mesh and heightmap"),
        (BALL | MESH | LAND, "shape and mesh and heightmap"), ({"name": "a", "mesh": None}, "none of them"),
    ],
)  # fmt: skip
def test_a_body_has_one_kind(table: dict[str, Any], given: str) -> None:
    expected = f"body[0].shape: a body has exactly one of shape, mesh, heightmap; this one has {given}: add or remove"
    assert problems({"body": [table]}) == (expected,)


@pytest.mark.parametrize("table", [BALL, MESH, LAND], ids=KINDS)
@pytest.mark.parametrize("key", [key for kind in KINDS for key in OWN_KEYS[kind] if key not in KINDS])
def test_keys_of_another_kind_are_refused(table: dict[str, Any], key: str) -> None:
    """Whatever their value is; those of the same kind are not."""
    (owner,) = (kind for kind in KINDS if key in OWN_KEYS[kind])
    if owner in table:
        return
    assert problems({"body": [table | {key: 1}]}) == (f"body[0].{key}: this key needs a body with {owner}; remove it",)


def test_other_faults_are_told_too() -> None:
    foreign, unknown = problems({"body": [MESH | {"low_m": 1, "positon_m": 3}]})
    assert foreign == "body[0].low_m: this key needs a body with heightmap; remove it"
    assert unknown.startswith("body[0].positon_m: this is not a known key")
    assert problems({"body": [{"name": "a", "meshh": "m.obj"}]}) == (
        'body[0].meshh: this is not a known key; did you mean "mesh"? (nearest of 67 keys: mesh, mesh_heading_deg, name)',
    )


def test_the_order_of_keys_is_that_of_recordings() -> None:
    keys = list(MeshBodyModel.model_fields)
    assert [keys.index(key) for key in ("speed_kn", "name", "mesh", "up", "position_m", "fading")] == sorted(
        keys.index(key) for key in ("speed_kn", "name", "mesh", "up", "position_m", "fading")
    )


def test_sizes_are_those_of_the_shape() -> None:
    (ball, mark) = validated({"body": [BALL, point()]}).body
    assert isinstance(ball, ShapeBodyModel) and ball.sizes() == {"radius_m": 1}
    assert isinstance(mark, ShapeBodyModel) and mark.sizes() == {}


@pytest.mark.parametrize("key", ["roll_deg", "drift_deg", "start_s", "steerable", "waypoints"])
def test_land_neither_moves_nor_goes(key: str) -> None:
    values = {"steerable": {}, "waypoints": [{"position_m": [1, 1], "speed_kn": 1}]}
    (problem,) = problems({"body": [LAND | {key: values.get(key, 1)}]})
    assert problem.startswith(f"body[0].{key}: a height map is land, always there, at rest") and problem.endswith(
        f"remove {key}"
    )


@pytest.mark.parametrize(("present", "of"), [(5, 10), (1, 7), (3, 4), (4, 4), (6, 9)])
def test_a_schedule_has_as_many_units_with_the_body_as_it_says_and_begins_with_one(present: int, of: int) -> None:
    for spread in (False, True):
        pattern = FadingModel(present=present, of=of, spread=spread).pattern()
        assert len(pattern) == of and sum(pattern) == present and pattern[0]


def test_spread_units_are_as_far_apart_as_they_can_be() -> None:
    pattern = FadingModel(present=3, of=10, spread=True).pattern()
    gaps = [unit for unit, there in enumerate(pattern + pattern) if there]
    assert {b - a for a, b in zip(gaps, gaps[1:], strict=False)} == {3, 4}
    assert FadingModel(present=3, of=10).pattern() == [True] * 3 + [False] * 7


def test_more_units_than_there_are_is_refused() -> None:
    with pytest.raises(ValidationError, match="present: 11 units are more than of = 10"):
        FadingModel(present=11, of=10)

"""Sizes that no ship, building or mountain has are warnings; metal that is too large is refused before it is computed."""

import contextlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scattering.physical_optics import model
from radar_service.scene_file.checks.mesh_findings import LONGEST, MAX_OPTICS_AREA, check_optics_area, metres, size_findings
from radar_service.scene_file.model.body import MeshBodyModel, ShapeBodyModel
from radar_service.world.error import SceneError
from radar_service.world.shapes import box

COASTER = Path(rs.__file__).parents[1] / "scenes"


def found(size: tuple[float, float, float], *, afloat: bool = True, **keys: Any) -> list[str]:
    body = MeshBodyModel.model_validate({"name": "b", "mesh": "b.obj", **keys})
    return list(size_findings(body, np.array(size, dtype=np.float64), afloat))


@pytest.mark.parametrize(
    ("size", "keys", "finding"),
    [
        ((60, 500, 40), {}, ""), ((60, 501, 40), {}, "501 m long"), ((501, 60, 40), {}, "501 m long"), ((1, 1, 1), {}, ""),
        ((0.2, 0.9, 0.2), {}, "0.9 m long"), ((13000, 88000, 21500), {}, "88000 m long, and ships have 1 to 500 m: set scale"),
        ((501, 60, 40), {"afloat": False}, ""), ((9e4, 9e4, 999), {"afloat": False, "material": "building"}, ""),
        ((9e4, 9e4, 1001), {"afloat": False, "material": "building"}, "1001 m high, and no building has more than 1000 m: set"),
        ((9e4, 9e4, 8849), {"afloat": False, "material": "rock"}, ""),
        ((9e4, 9e4, 9001), {"afloat": False, "material": "rock"}, "9001 m high, and no rock has more than 9000 m"),
    ],
)  # fmt: skip
def test_sizes_of_meshes(size: tuple[float, float, float], keys: dict[str, Any], finding: str) -> None:
    assert [text[: len(finding)] for text in found(size, **keys)] == [finding] * bool(finding)


@pytest.mark.parametrize(
    ("ais", "keys"),
    [
        ({"length_m": 100}, []), ({"length_m": 80}, []), ({"length_m": 79}, ["length_m"]), ({"length_m": 126}, ["length_m"]),
        ({"length_m": 100, "beam_m": 30}, ["beam_m"]), ({"length_m": 0}, []), ({}, []),
    ],
)  # fmt: skip
def test_a_mesh_is_compared_with_what_ais_says(ais: dict[str, Any], keys: list[str]) -> None:
    """The mesh is 100 m long and 20 m wide; 0 is no length. A shape is compared too."""
    texts = found((20, 100, 9), mmsi=299000001, ais=ais)
    assert [text.split("where ais.")[1].split()[0] for text in texts] == keys
    assert all(text.endswith(f"or correct ais.{key}") and "set scale" in text for text, key in zip(texts, keys, strict=True))
    hull = {"name": "h", "shape": "hull", "length_m": 100, "beam_m": 20, "height_m": 9, "position_m": [0, 900, 0]}
    scene = rs.load_scene({"body": [{**hull, "mmsi": 299000001, "ais": ais}]})
    assert [warning.split(": ")[0] for warning in scene.warnings] == ["body[0]"] * bool(keys)


def test_a_height_map_is_land_and_a_large_one_of_metal_is_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "h.npy", np.full((3, 3), 20.0))
    table = {"name": "shore", "heightmap": "h.npy", "extent_m": [2000, 1000], "position_m": [0, 900, 0]}
    assert rs.load_scene({"body": [table]}, folder=tmp_path).bodies[0].material.name == "land"
    with pytest.raises(
        SceneError, match=r"^body\[0\]: shore is 2000 m .* km2 of steel; .*: set material = \"land\", or give"
    ):
        rs.load_scene({"body": [table | {"material": "steel"}]}, folder=tmp_path)


def test_a_mesh_in_millimetres_is_refused_before_it_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """At rest, under way, in a seaway, and as a platform; of shapes the keys of their sizes are named."""
    monkeypatch.setattr(model, "outward_side", lambda *_: pytest.fail("it is computed"))
    ship = {"name": "coaster", "mesh": "coaster.obj", "scale": 1000, "position_m": [3000, 4000, 0]}
    for keys in ({}, {"speed_kn": 10}):
        with pytest.raises(
            SceneError, match=r"body\[0\]: coaster is 88000 m large, .* of steel; at most 1 km2 .*: set scale"
        ):
            rs.load_scene({"environment": {"sea_state": 3, "seaway": True}, "body": [{**ship, **keys}]}, folder=COASTER)
    slab = {"name": "b", "shape": "box", "length_m": 3000, "width_m": 400, "height_m": 50, "position_m": [0, 4000, 0]}
    with pytest.raises(
        SceneError, match=r"3000 m large, with 2.74 km2 .*: correct length_m, width_m, height_m, or give scatt"
    ):
        rs.load_scene({"body": [slab]})


def test_a_huge_body_that_is_no_metal_works_with_a_warning_before_all_others() -> None:
    ship = {"name": "coaster", "mesh": "coaster.obj", "scale": 1000, "material": "wood", "speed_kn": 10}
    scene = rs.load_scene({"body": [{**ship, "position_m": [3000, 4000, 0]}]}, folder=COASTER)
    assert scene.warnings[0].startswith(
        "body[0].mesh: coaster.obj: 88000 m long, and ships have 1 to 500 m: set scale to the"
    )
    assert len(scene.warnings) == 2 and "antenna is inside" in scene.warnings[1]


def test_metal_is_limited_by_its_surface_beyond_the_longest_ship() -> None:
    """A bridge of 2 km is allowed, and whatever is no longer than LONGEST."""
    body = ShapeBodyModel.model_validate({"name": "b", "shape": "box", "length_m": 1, "width_m": 1, "height_m": 1})
    for sides, refused in (
        ((2000.0, 30.0, 5.0), False), ((LONGEST, LONGEST, 400.0), False), ((LONGEST + 1, LONGEST, 400.0), True),
    ):  # fmt: skip
        mesh = box(*sides)
        assert (2.0 * (sides[0] * sides[1] + (sides[0] + sides[1]) * sides[2]) > MAX_OPTICS_AREA) is (sides[2] == 400.0)
        with pytest.raises(SceneError, match="physical optics") if refused else contextlib.nullcontext():
            check_optics_area(body, mesh, np.ptp(mesh.vertices, axis=0), "body[0]")


def test_lengths_have_no_exponents() -> None:
    assert [metres(value) for value in (0.73485, 26.46, 99.96, 1004.9, 88000.0, 251300.4)] == [
        "0.735", "26.5", "100", "1005", "88000", "251300",
    ]  # fmt: skip

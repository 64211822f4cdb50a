"""Terrain of height maps: positions and heights of samples, removed triangles, bad maps."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scene_file.model.body import HeightMapBodyModel
from radar_service.scene_file.readers.heightmap import Coverage, heightmap_terrain
from radar_service.scene_file.readers.raster import Raster
from radar_service.world.body import Mesh
from radar_service.world.error import SceneError
from radar_service.world.geo import map_from_geographic
from tests.scene_file.readers.height_maps import land_vertices, load, npy, picture, world_vertices


def test_row_0_is_north_and_corners_are_outer_samples(tmp_path: Path) -> None:
    heights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])  # 3 across, 2 down
    (body,) = load(tmp_path, "h.npy", npy(heights), extent_m=[200, 50], position_m=[1000, 2000, 10]).bodies
    np.testing.assert_allclose(body.motion.position, [[1000, 2000, 10]])
    expected = [[900, 2025, 11], [1000, 2025, 12], [1100, 2025, 13], [900, 1975, 14], [1000, 1975, 15], [1100, 1975, 16]]
    np.testing.assert_allclose(sorted(world_vertices(body).tolist()), sorted(expected), rtol=1e-12)
    assert body.mesh is not None and body.one_sided
    a, b, c = body.mesh.vertices[body.mesh.faces].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] >= 0).all() and len(
        body.mesh.faces
    ) == 4 + 2 * 6  # land looks up; skirts are upright
    assert (body.scattering, body.length, body.beam) == ("diffuse", 50.0, 200.0)


@pytest.mark.parametrize(
    "name, content, expected",
    [
        ("h.png", picture(np.array([[0, 51], [102, 255]], dtype=np.uint8)), [[-100, 0], [100, 400]]),
        ("h.png", picture(np.array([[0, 13107], [26214, 65535]], dtype=np.uint16)), [[-100, 0], [100, 400]]),
        ("h.npy", npy(np.array([[-128, -77], [-26, 127]], dtype=np.int8)), [[-100, 0], [100, 400]]),
        ("h.tif", picture(np.array([[0, 13107], [26214, 65535]], dtype=np.uint16), "TIFF"), [[-100, 0], [100, 400]]),
    ],
)
def test_greys_span_low_to_high(tmp_path: Path, name: str, content: bytes, expected: list[list[float]]) -> None:
    (body,) = load(tmp_path, name, content, low_m=-100, high_m=400, extent_m=[100, 100]).bodies
    assert sorted(world_vertices(body)[:, 2]) == pytest.approx(sorted(np.ravel(expected)), abs=1e-9)


def test_arrays_and_tiff_are_metres(tmp_path: Path) -> None:
    for name, content in (
        ("a.npy", npy(np.array([[1, 2], [3, 40]], dtype=np.int16))),
        ("b.npy", npy(np.array([[1, 2], [3, 40.0]]))),
        ("c.tif", picture(np.array([[1, 2], [3, 40]], dtype=np.float32), "TIFF")),
    ):
        (body,) = load(tmp_path, name, content, extent_m=[100, 100]).bodies
        assert sorted(world_vertices(body)[:, 2]) == pytest.approx([1, 2, 3, 40])


def test_corners_in_degrees_place_every_sample_on_the_geodesic() -> None:
    """150 samples a side are more than the geodesic is solved on; splines between must not be felt."""
    side = 150
    body = HeightMapBodyModel(name="h", heightmap="h.npy", south_west_deg=(46.0, -4.0), north_east_deg=(56.0, 6.0))
    raster = Raster(np.full((side, side), 5.0), grey=False)
    terrain = heightmap_terrain(body, raster, np.array([0.0, 0.0, 3.0]), (50.9, 1.4), Coverage(0.0, 0.0, np.inf), "body[0]")
    assert terrain.position is not None
    result = land_vertices(terrain.mesh) + terrain.position
    latitude, longitude = np.meshgrid(np.linspace(56, 46, side), np.linspace(-4, 6, side), indexing="ij")
    expected = map_from_geographic(latitude, longitude, (50.9, 1.4)).reshape(-1, 2)
    assert len(result) == side**2
    np.testing.assert_allclose(result[:, :2], expected, atol=1e-3)  # m: the bound that the spline's step was chosen for
    np.testing.assert_allclose(result[:, 2], 8.0)


def test_sea_and_land_beyond_coverage_are_removed(tmp_path: Path) -> None:
    heights = np.full((11, 11), -5.0)
    heights[5, 4] = heights[5, 9] = 20.0
    scene = load(tmp_path, "h.npy", npy(heights), range_max_m=2900, extent_m=[10_000, 10_000])
    (body,) = scene.bodies
    assert body.mesh is not None and len(body.mesh.faces) == 6  # round the peak 1000 m west; the one 4000 m east is too far
    assert scene.notes == (
        "body[0].heightmap: h.npy: 6 of 200 triangles kept, those above the sea and within radar coverage",
    )


def edges(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Directed edges (3 F, 2) of a mesh by position, and how often each runs the other way."""
    _, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    corner = place.ravel()[mesh.faces]
    directed = np.stack([corner, np.roll(corner, -1, axis=1)], axis=2).reshape(-1, 2)
    key = directed @ [len(mesh.vertices), 1]
    return directed, (key[:, None] == (directed[:, ::-1] @ [len(mesh.vertices), 1])[None]).sum(axis=1)


def test_a_skirt_closes_the_rim_where_it_is_above_the_sea(tmp_path: Path) -> None:
    """Heights drawn at random, a third of them below the sea: each edge that rises above it joins two triangles, wound alike; the
    rim's own walls stand upright, face outward, and end 1 m below the sea."""
    heights = np.random.default_rng(7).uniform(-10.0, 20.0, (7, 9))
    (body,) = load(tmp_path, "h.npy", npy(heights), extent_m=[80, 60], position_m=[300, 200, 0]).bodies
    assert body.mesh is not None
    directed, reverse = edges(body.mesh)
    _, first = np.unique(body.mesh.vertices, axis=0, return_index=True)
    high = (body.mesh.vertices[first, 2] > 0.0)[directed].any(axis=1)
    assert (reverse[high] == 1).all() and (reverse[~high] <= 1).all()
    a, b, c = body.mesh.vertices[body.mesh.faces].transpose(1, 0, 2)
    normal, middle = np.cross(b - a, c - a), (a + b + c) / 3.0
    wall = np.abs(normal[:, 2]) < 1e-9  # m^2: rounding of 10 m x 30 m
    on_west_or_east = np.abs(middle[:, 0]) > 39.99
    outward = np.where(on_west_or_east, middle[:, 0] * normal[:, 0], middle[:, 1] * normal[:, 1])
    assert wall.sum() > 20 and (outward[wall] > 0.0).all()
    assert (np.min([a[wall, 2], b[wall, 2], c[wall, 2]], axis=0) <= -1.0).all()


@pytest.mark.parametrize(("height", "walls"), [(0.0, 0), (0.5, 16)])
def test_a_rim_at_the_sea_needs_no_skirt(tmp_path: Path, height: float, walls: int) -> None:
    """A map of 3 x 3 samples with a peak in the middle: eight edges of its rim, two triangles under each."""
    heights = np.full((3, 3), height)
    heights[1, 1] = 8.0
    made = load(tmp_path, "h.npy", npy(heights), extent_m=[80, 60])
    assert made.bodies[0].mesh is not None and len(made.bodies[0].mesh.faces) == 8 + walls
    expected = ("body[0].heightmap: h.npy: its rim stands up to 0.5 m above the sea: a wall closes it",) if walls else ()
    assert made.notes == expected


FLAT = npy(np.ones((3, 3)))

GREY = picture(np.full((3, 3), 200, dtype=np.uint8))


@pytest.mark.parametrize(
    "name, content, keys, message",
    [
        ("h.png", GREY, {}, "body[0].low_m: missing; grey values are not metres"),
        ("h.npy", FLAT, {}, "body[0].extent_m: missing"),
        ("h.npy", FLAT, {"low_m": 0, "high_m": 1, "extent_m": [9, 9]}, "body[0].low_m: float64 samples are already metres"),
        ("h.npy", npy(np.ones((3, 3)) * np.nan), {"extent_m": [9, 9]}, "9 samples are not finite"),
        ("h.npy", npy(np.full((3, 3), -32768)), {"extent_m": [9, 9]}, "heights from -32768 to -32768 m"),
        ("h.npy", npy(np.full((3, 3), -5.0)), {"extent_m": [9, 9]}, "none of the 8 triangles rises above the sea"),
        ("h.npy", npy(np.ones(9)), {"extent_m": [9, 9]}, "9 samples; two sides of 2 to 4097"),
        ("h.npy", npy(np.ones((1, 9))), {"extent_m": [9, 9]}, "1 x 9 samples; two sides of 2 to 4097"),
        ("h.npy", npy(np.ones((3, 3), dtype=complex)), {"extent_m": [9, 9]}, "samples have the type complex128"),
        ("h.npy", npy(np.ones((3, 3), dtype=bool)), {"extent_m": [9, 9]}, "samples have the type bool"),
        ("h.npy", npy(np.array([[{}, {}], [{}, {}]])), {"extent_m": [9, 9]}, "samples have the type object"),
        ("h.npy", FLAT[:-8], {"extent_m": [9, 9]}, "is not readable as"),
        ("h.npy", FLAT[:20], {"extent_m": [9, 9]}, "is not readable as"),
        ("h.npy", GREY, {"extent_m": [9, 9]}, "is not a NPY file"),
        ("h.png", FLAT, {"low_m": 0, "high_m": 9, "extent_m": [9, 9]}, "is not a PNG file"),
        ("h.png", GREY[:45], {"low_m": 0, "high_m": 9, "extent_m": [9, 9]}, "is not readable as"),
        ("h.png", picture(np.zeros((3, 3, 3), dtype=np.uint8)), {"low_m": 0, "high_m": 9, "extent_m": [9, 9]}, '"RGB"'),
        ("h.jpg", b"\xff\xd8\xff", {"extent_m": [9, 9]}, "does not end in .npy, .png, .tif, .tiff"),
        ("h.npy", FLAT, {"south_west_deg": [51, 1], "north_east_deg": [50, 2]}, "is not south and west of"),
        ("h.npy", FLAT, {"extent_m": [9, 9], "position_m": [1e6, 0, 0]}, "rises above the sea within 50000 m"),
        ("h.npy", FLAT, {"south_west_deg": [0, -179], "north_east_deg": [1, -178]}, "m from the origin; at most 2e+06"),
    ],
)
def test_bad_height_maps(tmp_path: Path, name: str, content: bytes, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, name, content, **keys)
    assert str(caught.value).startswith("body[0].") and message in str(caught.value)

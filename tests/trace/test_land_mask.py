"""The land mask: against triangles asked one by one, what counts as land, and its bounds."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.trace import land_mask
from radar_service.trace.land_mask import LandMask
from radar_service.world.body import MATERIALS, Body, Mesh
from tests.scenes import point, scene

NUMBER = {name: number for number, name in enumerate(MATERIALS, 1)}


def box(name: str, material: str = "land", **more: Any) -> dict[str, Any]:
    """A box of 20 x 40 m, 5 m high."""
    size = {"length_m": 40.0, "width_m": 20.0, "height_m": 5.0}
    return {"name": name, "shape": "box", "material": material, **size, **more}


def soup(seed: int, material: str) -> Body:
    """Triangles without order: small and large ones, slivers, upright and level ones, some of them under water."""
    rng = np.random.default_rng(seed)
    size = np.array([3.0, 10.0, 100.0])[rng.integers(3, size=60)][:, None, None]
    corner = rng.uniform(-300, 300, (60, 1, 3)) * [1, 1, 0.01] + rng.uniform(-1, 1, (60, 3, 3)) * [*[1, 1], 0.1] * size
    corner[:10, 1, :2] = corner[:10, 0, :2] + [0.0, 0.05]
    corner[10:15, 1, :2] = corner[10:15, 0, :2]
    corner[15:20, :, 2] = 2.0
    (made,) = scene([box(material, material)]).bodies
    return replace(made, mesh=Mesh(corner.reshape(-1, 3), np.arange(180).reshape(60, 3)))


def highest(body: Body, east: Floats, north: Floats) -> Floats:
    """Heights (N,) of the highest triangle over positions (N,), 0 over none: by barycentric coordinates of each triangle."""
    assert body.mesh is not None
    top = np.zeros(len(east))
    for a, b, c in body.mesh.vertices[body.mesh.faces]:
        turn = np.array([[b[0] - a[0], c[0] - a[0]], [b[1] - a[1], c[1] - a[1]]])
        if np.linalg.det(turn) == 0.0:
            continue
        u, v = np.linalg.solve(turn, np.stack([east - a[0], north - a[1]]))
        inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
        top[inside] = np.maximum(top[inside], (a + np.outer(u, b - a) + np.outer(v, c - a))[inside, 2])
    return top


@pytest.mark.parametrize(("rows", "covered"), [(2**16, 2**20), (1, 1), (50, 1000)])
def test_each_cell_has_the_highest_land_over_its_middle(rows: int, covered: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two bodies of 60 triangles, however many are worked on at once; heights to the rounding of float32."""
    monkeypatch.setattr(land_mask, "ROWS", rows)
    monkeypatch.setattr(land_mask, "COVERED", covered)
    bodies = [soup(1, "sand"), soup(2, "rock")]
    monkeypatch.setattr(land_mask, "CELLS", 4000)
    mask = LandMask.of(bodies)
    assert mask is not None
    row, column = np.indices(mask.material.shape)
    east, north = mask.corner[0] + mask.cell * column.ravel(), mask.corner[1] + mask.cell * row.ravel()
    tops = np.array([highest(body, east, north) for body in bodies])
    np.testing.assert_allclose(mask.height.ravel(), tops.max(axis=0), atol=1e-5)
    clear = np.abs(tops[0] - tops[1]) > 1e-5
    expected = np.where(tops[0] > tops[1], NUMBER["sand"], NUMBER["rock"])
    np.testing.assert_array_equal(mask.material.ravel()[clear], expected[clear])
    assert set(np.unique(mask.material)) == {0, NUMBER["sand"], NUMBER["rock"]}
    assert not mask.material[[0, -1]].any() and not mask.material[:, [0, -1]].any()


def test_positions_find_their_cells_and_all_beyond_is_water() -> None:
    """A box of 20 x 40 m turned by 90 degrees, with cells of 1 m: 40 m to the east, 20 m to the north."""
    mask = LandMask.of(scene([box("quay", "concrete", position_m=[100, 50, 1], heading_deg=90)]).bodies)
    assert mask is not None and mask.cell == 1.0
    east = np.array([80.4, 119.6, 79.4, 120.6, 100.0, 100.0, 100.0, 100.0, -1e9, 1e9])
    north = np.array([50.0, 50.0, 50.0, 50.0, 40.4, 59.6, 39.4, 60.6, 50.0, 1e9])
    cells = mask.at(east, north)
    assert mask.material.take(cells).tolist() == [NUMBER["concrete"] * land for land in (1, 1, 0, 0, 1, 1, 0, 0, 0, 0)]
    assert mask.height.take(cells)[:2].tolist() == [6.0, 6.0]


def test_land_is_what_rests_for_good_and_no_vessel() -> None:
    """Neither ships and points, nor land that moves, comes and goes, or lies under water."""
    others = [
        box("ship", "steel"), point("mark", 0, 0), box("barge", "sand", speed_kn=3), box("tide", "sand", start_s=5),
        box("moored", "wood"), {**box("marked", "land"), "position_m": [900, 0, 0], "rcs_dbsm": 3.0},
    ]  # fmt: skip
    assert LandMask.of(scene(others[:5]).bodies) is None
    made = scene([box("shoal", "rock", position_m=[500, 0, -5]), *others]).bodies
    mask = LandMask.of(made)
    assert mask is not None and mask.diffuse.tolist() == [body.name in ("shoal", "tide") for body in made]
    assert set(np.unique(mask.material)) == {0, NUMBER["land"]}


def test_landmasses_are_connected_also_across_corners() -> None:
    near, far = box("a"), box("b", "rock", position_m=[20.5, 40, 0])  # they touch at a corner
    mask = LandMask.of(scene([near, far, box("c", position_m=[300, 0, 0])]).bodies)
    assert mask is not None
    parts = mask.landmass.take(mask.at(np.array([0.0, 20.0, 300.0, 150.0]), np.array([0.0, 40.0, 0.0, 0.0])))
    assert parts[0] == parts[1] > 0 and parts[2] not in (0, parts[0]) and parts[3] == 0


@pytest.mark.parametrize("size", [(3.0, 1.0), (3e3, 2e3), (8e4, 9e4), (1e5, 1.0), (1.0, 1e5)])
def test_a_raster_has_a_million_cells_at_most(size: tuple[float, float], monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells are square, 1 m or as large as the land asks; strips one cell wide have as many beside them."""
    monkeypatch.setattr(land_mask, "CELLS", 2**12)
    mask = LandMask.of(scene([box("land", width_m=size[0], length_m=size[1])]).bodies)
    assert mask is not None and mask.material.size <= 3 * (2**12 + 200)
    assert mask.cell == pytest.approx(max(1.0, np.sqrt(size[0] * size[1] / 2**12), max(size) / 2**12))
    assert mask.material.any() or min(size) < mask.cell

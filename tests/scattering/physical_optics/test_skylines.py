"""Outlines of many triangles before a body hide what ray casting says."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.types import Flags, Floats
from radar_service.scattering.physical_optics import cast_shadows
from radar_service.scattering.physical_optics.cast_shadows import MAX_TRIANGLES, RINGS, CastShadows, Onlooker
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.scattering.physical_optics.skylines import FINEST, SHARE
from radar_service.trace.line_of_sight import OcclusionScene, SurfacePoints
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world.body import Mesh
from radar_service.world.poses import MAP_POSE
from tests.reference.legs import reflection_points
from tests.reference.metal_on_water import EARTH
from tests.reference.shadow_witnesses import lit
from tests.scattering.physical_optics.test_cast_shadows import box, lit_area, onlooker
from tests.scenes import point, scene


def terrain(draw: np.random.Generator, columns: int, rows: int, far: float, top: float) -> Mesh:
    """Islands and rough hills, some under water, up to a top [m] and from a tenth to all of a distance to the north [m]."""
    east, north = np.meshgrid(np.linspace(-0.15, 0.15, columns) * far, np.linspace(0.1, 1.0, rows) * far)
    height = np.full(east.shape, -0.35 * top)
    for _ in range(int(draw.integers(4, 16))):
        middle, size = draw.uniform([-0.15, 0.1], [0.15, 1.0]) * far, draw.uniform(0.01, 0.08, 2) * far
        height += (
            draw.uniform(0.2, 1.0)
            * top
            * np.exp(-(((east - middle[0]) / size[0]) ** 2) - ((north - middle[1]) / size[1]) ** 2)
        )
    height += draw.normal(0.0, 0.03 * top, east.shape)
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + columns], 1), np.stack([a + 1, a + columns + 1, a + columns], 1)])
    return Mesh(np.stack([east.ravel(), north.ravel(), height.ravel()], axis=1), faces)


def body_box(distance: float, width: float, height: float) -> Floats:
    """The corners (8, 3) of a box upon the sea to the north."""
    return np.stack(
        np.meshgrid([-width / 2, width / 2], [distance, distance + 0.2 * width], [0.0, height]), axis=-1
    ).reshape(8, 3)


def face(corners: Floats, count: int) -> Floats:
    """Points (count^2, 3) on the near face of a box."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    across, up = np.meshgrid(*(low[k] + (high[k] - low[k]) * (np.arange(count) + 0.5) / count for k in (0, 2)))
    return np.stack([across.ravel(), np.full(across.size, low[1]), up.ravel()], axis=1)


def ray_cast(meshes: list[Mesh], points: Floats, picture: Picture) -> Flags:
    """Which points (M, 3) the antenna has in a picture past meshes."""
    first, *others = scene([point("t", 0, 900), *({"name": f"m{k}", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9,
                                                  "rcs_dbsm": 0} for k in range(len(meshes)))]).bodies  # fmt: skip
    made = OcclusionScene(
        [first, *(replace(body, mesh=mesh) for body, mesh in zip(others, meshes, strict=True))], picture.earth_radius
    )
    surface = SurfacePoints(np.zeros(len(points), dtype=np.int64), np.full(len(points), -1), points)
    if not picture.by_sea:
        return made.visible(surface, picture.antenna, 0.0, 1e6)
    reflection, _ = reflection_points(points, picture.antenna, picture.earth_radius)
    return made.visible_by_sea(surface, reflection, picture.antenna, 0.0, 1e6)


def differing(made: Onlooker, shadows: CastShadows, meshes: list[Mesh], count: int = 60) -> Flags:
    """Which points of the near face (up, across) are seen past the shadows, or by rays, not by both."""
    points = face(made.box, count)
    seen = ray_cast(meshes, points, shadows.picture)
    return np.asarray(seen != lit(shadows, points)).reshape(count, count)


# Of 40: those where something hides part of the face.
@pytest.mark.parametrize("seed", [2, 3, 4, 9, 12, 17, 24, 29, 35, 38, 39])
def test_an_outline_of_terrain_hides_what_rays_do_not_reach(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Random islands and hills before a random box: less than 0.5 % of its face differs from ray casting. At each place across,
    the height that differs is the stated error of two edges, and by the sea of a gap between shores that is filled."""
    monkeypatch.setattr(cast_shadows, "FEW_TRIANGLES", 0)
    draw, earth = np.random.default_rng(seed), (np.inf, EARTH)[seed % 2]
    distance, antenna = draw.uniform(600.0, 4000.0), np.array([0.0, 0.0, draw.uniform(8.0, 40.0)])
    columns, rows = (int(n) for n in draw.integers([20, 30], [60, 120]))
    land = terrain(draw, columns, rows, distance * draw.uniform(0.5, 0.98), draw.uniform(5.0, 40.0))
    corners = body_box(distance, draw.uniform(10.0, 200.0), draw.uniform(5.0, 40.0))
    made = Onlooker(corners, tuple(Picture(antenna, earth, by_sea) for by_sea in (False, True)))
    exact, drawn = (made.shadows([(TriangleClusters(land, is_ground), MAP_POSE)]) for is_ground in (False, True))
    for triangles, outline in zip(exact, drawn, strict=True):
        assert len(outline) <= max(2, 0.6 * len(triangles))
        wrong = differing(made, outline, [land])
        assert wrong.mean() < 0.005
        error = 2.0 * max(SHARE, FINEST / float(np.ptp(corners[:, 2]))) + outline.picture.by_sea / RINGS
        assert wrong.sum(axis=0).max() <= np.ceil(60 * error)


def test_what_ground_hides_does_not_depend_on_what_was_asked_before() -> None:
    """Bodies and antennas that wander through cells: the same triangles, to the byte, as are found anew."""
    draw = np.random.default_rng(8)
    land = TriangleClusters(terrain(draw, 25, 80, 900.0, 12.0), True)
    found = 0
    for k in range(40):
        along = 0.15 * k * np.array([1.0, -1.0, 0.1])
        antenna, shift = np.array([0.0, 0.0, 15.0]) + along, np.array([2.0, -1.0, 0.5]) * along
        legs = tuple(Picture(antenna, EARTH, by_sea) for by_sea in (False, True))
        made = Onlooker(body_box(1000.0, 30.0, 9.0) + shift, legs)
        own = made.windows()
        anew, shared = made.before(land, MAP_POSE, own), made.ground(land, MAP_POSE, own)
        np.testing.assert_array_equal(shared, anew)
        found += len(anew)
    assert found > 100 and 1 < len(land.kept) < 40


def row_of_boxes(count: int, bottom: float, top: float) -> Mesh:
    """Boxes side by side from 5 m west to 5 m east, 60 m to the north."""
    ends = np.linspace(-5.0, 5.0, count + 1)
    each = [box((west, 60.0, bottom), (east, 60.5, top)) for west, east in itertools.pairwise(ends)]
    faces = np.concatenate([one.faces + 8 * k for k, one in enumerate(each)])
    return Mesh(np.concatenate([one.vertices for one in each]), faces)


@pytest.mark.parametrize("bottom", [0.0, 8.5], ids=["wall", "bridge"])
def test_too_many_triangles_cast_the_shadow_of_their_outline(bottom: float) -> None:
    """By similar triangles from 15 m to a plate at 100 m; what lies below a bridge is no part of its outline. 2 cm an edge."""
    boxes = row_of_boxes(MAX_TRIANGLES // 4, bottom, 9.5)
    shadows, by_sea = onlooker(100.0, by_sea=True).shadows([(TriangleClusters(boxes), MAP_POSE)])
    assert len(shadows) <= 8
    hidden = 15.0 - 5.5 * 100.0 / 60.5 - max(15.0 - (15.0 - bottom) * 100.0 / 60.0, 0.0)
    assert 48.0 - lit_area(shadows, 100.0) == pytest.approx(8.0 * hidden, abs=8.0 * 2 * FINEST)
    assert lit_area(by_sea, 100.0) == pytest.approx(
        48.0 if bottom else 0.0, abs=1e-6
    )  # at 60 m these rays are up to 6 m high


def test_land_in_which_a_body_stands_hides_it_up_to_its_middle(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slabs that reach from before a box to behind it, too many to stay triangles."""
    monkeypatch.setattr(cast_shadows, "MAX_TRIANGLES", 5)
    slabs = [box((-50.0, 90.0, 0.0), (50.0, 120.0, top)) for top in (1.0, 2.0, 3.0)]
    joined = Mesh(
        np.concatenate([slab.vertices for slab in slabs]),
        np.concatenate([slab.faces + 8 * k for k, slab in enumerate(slabs)]),
    )
    made = Onlooker(body_box(100.0, 10.0, 6.0), (Picture(np.array([0.0, 0.0, 15.0]), np.inf, False),))
    (shadows,) = made.shadows([(TriangleClusters(joined, True), MAP_POSE)])
    up = np.linspace(0.1, 5.9, 581)
    near, far = (lit(shadows, np.stack([0.0 * up, 0.0 * up + north, up], axis=1)) for north in (100.0, 102.0))
    # 2 cm of 6 m: the near face behind the slabs' near walls, and the far one behind their tops before the middle
    assert (near == (up > 15.0 - 12.0 * 100.0 / 90.0)).mean() > 0.99
    assert (far == (up > 15.0 - 12.0 * 102.0 / 101.0)).mean() > 0.99

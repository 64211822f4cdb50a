"""Shadows of other bodies: no triangle that may cast one is missed, and facets are cut exactly where they end."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.cast_shadows import CastShadows, Onlooker
from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world.body import Mesh
from radar_service.world.poses import MAP_POSE
from tests.kernels.both import use_witnesses
from tests.reference import shadow_witnesses
from tests.reference.cast_shadows import picture_of
from tests.reference.metal_on_water import EARTH, Setting

ANTENNA = np.array([0.0, 0.0, 15.0])
FLAT, CURVED = Picture(ANTENNA, np.inf, False), Picture(ANTENNA, EARTH, False)
PLATE = np.array([[-4.0, 0, 0], [4, 0, 0], [4, 0, 6], [-4, 0, 6]])  # upright, facing south
QUAD = np.array([[0, 1, 2], [0, 2, 3]])


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    """A closed box between two corners, its triangles turned outward."""
    corner = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, 8).T
    rings = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(corner, np.array([f for a, b, c, d in rings for f in ((a, b, c), (a, c, d))]))


def onlooker(north: float, picture: Picture = FLAT, by_sea: bool = False) -> Onlooker:
    """A plate 8 m wide and 6 m high that stands on the sea to the north."""
    legs = (picture, picture._replace(by_sea=True)) if by_sea else (picture,)
    low, high = np.array([-4.0, north, 0.0]), np.array([4.0, north + 0.1, 6.0])
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(8, 3)
    return Onlooker(corners, legs, 2)


def lit_area(shadows: CastShadows, north: float) -> float:
    """What of the plate is in the light [m^2]."""
    plate = PLATE[QUAD]
    parts, origin, lit = shadows.cut(plate, lambda points: points + [0.0, north, 0.0])
    assert areas(parts).sum() == pytest.approx(areas(plate[np.unique(origin)]).sum(), rel=1e-9)  # rounding
    return float(areas(plate).sum() - areas(parts[~lit]).sum())


@pytest.mark.parametrize("name, low, high, dark", [
    ("a wall hides the foot", (-50.0, 80.0, 0.0), (50.0, 82.0, 7.0), 8.0 * (15.0 - 8.0 * 100.0 / 82.0)),
    ("a mast hides a strip", (-0.1, 60.0, 0.0), (0.1, 60.2, 30.0), 0.2 * 100.0 / 60.0 * 6.0),
    ("a low box hides a corner", (-10.0, 50.0, 0.0), (0.5, 50.0, 8.0), 5.0 * (15.0 - 7.0 * 100.0 / 50.0)),
    ("a box behind hides nothing", (-50.0, 120.0, 0.0), (50.0, 130.0, 30.0), 0.0),
    ("a box aside hides nothing", (40.0, 50.0, 0.0), (60.0, 60.0, 30.0), 0.0),
    ("a box before it hides all", (-50.0, 40.0, 0.0), (50.0, 50.0, 30.0), 48.0),
], ids=lambda value: value.replace(" ", "-") if isinstance(value, str) else "")  # fmt: skip
def test_the_shadow_of_a_box_has_its_area(
    name: str, low: tuple[float, float, float], high: tuple[float, float, float], dark: float
) -> None:
    """By similar triangles from 15 m over a flat sea to a plate at 100 m; a thousandth of a part of 1e-6 m cut off is left."""
    (shadows,) = onlooker(100.0).shadows([(TriangleClusters(box(low, high)), MAP_POSE)])
    assert 48.0 - lit_area(shadows, 100.0) == pytest.approx(max(dark, 0.0), abs=1e-4)


def test_a_wall_hides_the_foot_of_a_plate_from_the_mirrored_antenna() -> None:
    """A wall 1.5 m high at 90 m: rays by the sea to heights below z = 1.5 x 100 / 90 + 15 x 10 / 90 pass it too low behind the
    reflection, or before it at the sea, where the ray to z meets the sea at 100 x 15 / (15 + z)."""
    (_, shadows) = onlooker(100.0, by_sea=True).shadows([(TriangleClusters(box((-50, 88, 0), (50, 90, 1.5))), MAP_POSE)])
    heights = np.linspace(0.005, 5.995, 600)
    reflection = 100.0 * 15.0 / (15.0 + heights)
    before = (15.0 * (1.0 - 90.0 / reflection) < 1.5) & (88.0 < reflection)
    behind = (reflection < 90.0) & ((88.0 - reflection) * heights / (100.0 - reflection) < 1.5)
    exact = np.mean(before | behind) * 48.0
    assert 48.0 - lit_area(shadows, 100.0) == pytest.approx(exact, abs=48.0 / 600)  # one height of the grid


def test_no_body_that_casts_a_shadow_is_missed() -> None:
    """300 boxes about the line of sight over the curved sea: whichever hides one of 200 points of the plate has triangles in the
    shadows, direct or by the sea; each point is in them if it is in the oracle's picture of the box."""
    rng, setting = np.random.default_rng(3), Setting(wavelength=0.1, antenna_height=15.0, earth_radius=EARTH)
    points = np.stack([rng.uniform(-4, 4, 200), np.full(200, 2000.0), rng.uniform(0.01, 6.0, 200)], axis=1)
    ahead, seen = np.array([0.0, 1.0]), 0
    for _ in range(300):
        size, place = (
            rng.uniform(0.5, 40.0, 3) * (1.0, 1.0, 0.3),
            np.array([rng.uniform(-40, 40), rng.uniform(50, 1900), 0.0]),
        )
        mesh = box(tuple(place - size * (0.5, 0.0, 0.1)), tuple(place + size * (0.5, 1.0, 1.0)))
        direct, sea = onlooker(2000.0, CURVED, by_sea=True).shadows([(TriangleClusters(mesh), MAP_POSE)])
        faces = [mesh.vertices[face] for face in mesh.faces]
        for shadows, by_sea in ((direct, False), (sea, True)):
            hull = picture_of(faces, ahead, setting, by_sea)
            assert hull is not None
            virtual = shadows.picture.virtual(points)
            flat, following = virtual[:, [0, 2]] / virtual[:, 1:2], np.roll(hull, -1, axis=0)
            along, toward = following - hull, flat[:, None] - hull
            side = along[:, 0] * toward[..., 1] - along[:, 1] * toward[..., 0]
            inside = (side > 1e-6 * np.linalg.norm(along, axis=1)).all(axis=1)  # 2 mm at 2 km from an edge
            assert not shadows.visible(points)[inside].any()
            seen += int(inside.any())
    assert seen > 40  # of 600 pairs of a box and a leg


def test_a_mast_through_a_roof_shows_what_stands_above_it() -> None:
    """A plate that stands 2 m in a box and 4 m above it: it is cut where it meets the roof, which is no silhouette."""
    (shadows,) = onlooker(100.0).shadows([(TriangleClusters(box((-9, 99, 0), (9, 101, 2.0))), MAP_POSE)])
    assert lit_area(shadows, 100.0) == pytest.approx(
        48.0 - 8.0 * 2.0, abs=8.0 * 13.0 / 99.0
    )  # what the near rim hides above


def rough_land(rng: np.random.Generator, rows: int, columns: int, top: float) -> Mesh:
    """Land of odd heights up to a top [m] from 40 to 90 m to the north: many of its silhouettes lie before other land."""
    east, north = np.meshgrid(np.linspace(-30.0, 30.0, columns), np.linspace(40.0, 90.0, rows))
    height = rng.uniform(-0.2 * top, top, east.shape)
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + columns], 1), np.stack([a + 1, a + columns + 1, a + columns], 1)])
    return Mesh(np.stack([east.ravel(), north.ravel(), height.ravel()], axis=1), faces)


@pytest.mark.parametrize("seed", range(12))
def test_light_among_a_cloud_of_triangles_is_what_all_their_edges_leave(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Triangles of 2 to 12 m before a body, in it, and about the antenna, direct and by the sea: each facet has the light that it
    has where all edges of all of them cut it, by numpy; 1e-9 m^2 is the rounding of facets of up to 16 m^2."""
    rng = np.random.default_rng(seed)
    size, low = ((2.0, [-12, 20, -11]), (6.0, [-12, 20, -11]), (12.0, [-60, -60, -11]))[seed % 3]
    count = int(rng.integers(20, 80))
    cloud = rng.uniform(low, [12.0, 105.0, 4.0], (count, 1, 3)) + rng.normal(0.0, size, (count, 3, 3))
    body = rng.uniform([-10, 96, 0], [10, 104, 9], (25, 1, 3)) + rng.normal(0.0, 2.0, (25, 3, 3))
    shadows = CastShadows((FLAT, CURVED)[seed // 3 % 2]._replace(by_sea=seed >= 6), cloud)

    def light() -> Floats:
        parts, origin, lit = shadows.cut(body, lambda points: points)
        return np.asarray(areas(body) - np.bincount(origin, areas(parts) * ~lit, minlength=len(body)))

    usual = light()
    use_witnesses(monkeypatch)
    by_numpy = light()
    monkeypatch.setattr(shadow_witnesses, "is_covered", lambda *_: False)
    every = light()
    np.testing.assert_allclose(usual, every, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(by_numpy, every, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_silhouettes_that_other_land_covers_cut_nothing_and_no_light_is_lost(
    by_sea: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rough land before a plate: what is in the light, against 40,000 points; and against cuts at all silhouettes: more parts of
    the same area."""
    fewer = partly = 0
    for seed in range(6):
        land = TriangleClusters(rough_land(np.random.default_rng(seed), 9, 21, 1.2 if by_sea else 9.0))
        shadows = onlooker(100.0, by_sea=by_sea).shadows([(land, MAP_POSE)])[-1]
        across, up = np.meshgrid(np.linspace(-3.99, 3.99, 200), np.linspace(0.015, 5.985, 200))
        points = np.stack([across.ravel(), np.full(across.size, 100.0), up.ravel()], axis=1)
        lit = lit_area(shadows, 100.0)
        assert lit == pytest.approx(48.0 * shadows.visible(points).mean(), abs=0.12)  # an edge of 40 m in cells of 3 cm
        parts = shadows.cut(PLATE[QUAD], lambda points: points + [0.0, 100.0, 0.0])[0]
        with monkeypatch.context() as every:
            use_witnesses(every)
            every.setattr(shadow_witnesses, "is_covered", lambda *_: False)
            assert lit_area(shadows, 100.0) == pytest.approx(lit, abs=1e-5)  # 40 m of edges within GRAZING of 100 m
            fewer += len(parts) < len(shadows.cut(PLATE[QUAD], lambda points: points + [0.0, 100.0, 0.0])[0])
        partly += 1.0 < lit < 47.0
    assert fewer > 0 and partly > 2

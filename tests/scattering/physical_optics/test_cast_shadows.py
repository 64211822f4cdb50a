"""Shadows of other bodies: no triangle that may cast one is missed, and they end where they should."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.cast_shadows import CastShadows, Onlooker
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world.body import Mesh
from radar_service.world.poses import MAP_POSE
from tests.reference.cast_shadows import picture_of
from tests.reference.metal_on_water import EARTH, Setting
from tests.reference.shadow_witnesses import lit

ANTENNA = np.array([0.0, 0.0, 15.0])
FLAT, CURVED = Picture(ANTENNA, np.inf, False), Picture(ANTENNA, EARTH, False)


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
    return Onlooker(corners, legs)


def lit_area(shadows: CastShadows, north: float) -> float:
    """What of the plate is in the light [m^2], of 300,000 points."""
    across, up = np.meshgrid((np.arange(800) + 0.5) / 100.0 - 4.0, (np.arange(375) + 0.5) / 62.5)
    points = np.stack([across.ravel(), np.full(across.size, north), up.ravel()], axis=1)
    return 48.0 * float(lit(shadows, points).mean())


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
    """By similar triangles from 15 m over a flat sea to a plate at 100 m; half a row or a column of points."""
    (shadows,) = onlooker(100.0).shadows([(TriangleClusters(box(low, high)), MAP_POSE)])
    assert 48.0 - lit_area(shadows, 100.0) == pytest.approx(max(dark, 0.0), abs=8.0 * 0.008)


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
    """150 boxes about the line of sight over the curved sea: whichever hides one of 200 points of the plate has triangles in the
    shadows, direct or by the sea; each point is in them if it is in the oracle's picture of the box."""
    rng, setting = np.random.default_rng(3), Setting(wavelength=0.1, antenna_height=15.0, earth_radius=EARTH)
    points = np.stack([rng.uniform(-4, 4, 200), np.full(200, 2000.0), rng.uniform(0.01, 6.0, 200)], axis=1)
    ahead, seen = np.array([0.0, 1.0]), 0
    for _ in range(150):
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
            assert not lit(shadows, points)[inside].any()
            seen += int(inside.any())
    assert seen > 20  # of 300 pairs of a box and a leg


def test_a_mast_through_a_roof_shows_what_stands_above_it() -> None:
    """A plate that stands 2 m in a box and 4 m above it: the shadow ends where it meets the roof, which is no silhouette."""
    (shadows,) = onlooker(100.0).shadows([(TriangleClusters(box((-9, 99, 0), (9, 101, 2.0))), MAP_POSE)])
    assert lit_area(shadows, 100.0) == pytest.approx(
        48.0 - 8.0 * 2.0, abs=8.0 * 13.0 / 99.0
    )  # what the near rim hides above

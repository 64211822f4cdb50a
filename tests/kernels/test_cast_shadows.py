"""Kernels of the shadows of other bodies against numpy."""

import numpy as np
import pytest

from radar_service.numerics.types import Flags, Floats
from radar_service.scattering.physical_optics.cast_shadows import CastShadows, Onlooker
from radar_service.scattering.physical_optics.picture import Picture
from radar_service.trace.triangle_clusters import Test, TriangleClusters
from radar_service.world.poses import BodyPose
from tests.kernels.both import both

LEAN = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]) @ np.array([[1, 0, 0], [0, 1, -0.003], [0, 0.003, 1]])
IN_LINE = [[2.5, 55.9, -8.3], [-8.7, 65.6, 7.4], [1.3800000000000001, 56.87, -6.73]]  # but for rounding
PICTURE = Picture(np.array([0.0, 0.0, 12.0]), np.inf, False)


def shadows(count: int) -> CastShadows:
    """Of triangles about 50 m away, some of which overlap, one edge-on, and two that share an edge."""
    draw = np.random.default_rng(11)
    corners = draw.uniform([-6.0, 40.0, -11.0], [6.0, 60.0, -2.0], (8, 3, 3))
    corners[1] = np.stack([corners[0, 1], corners[0, 0], corners[1, 2]])
    corners[2] = [[0.0, 50.0, -5.0], [0.0, 55.0, -5.0], [0.0, 55.0, -9.0]]
    return CastShadows(PICTURE, corners[:count])


@pytest.mark.parametrize("casters", [0, 1, 8])
def test_planes_of_shadows_are_those_of_numpy(casters: int) -> None:
    """In the same order; triangles that are seen edge-on, or have no width, cast none, and two share an edge."""
    corners = shadows(8).corners[:casters]
    edge_on = np.array([[[0.0, 50.0, -5.0], [0.0, 55.0, -5.0], [0.0, 55.0, -9.0]], IN_LINE])
    compiled, by_numpy = both(lambda: CastShadows(PICTURE, np.concatenate([corners, edge_on])))
    for name in ("corners", "plane", "offset", "distance"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(by_numpy, name), rtol=1e-12, atol=1e-14)
    assert len(compiled) == len(corners)


class Asked(TriangleClusters):
    """Triangles that keep which hulls of points may concern a question, and answer that none does."""

    def __init__(self, points: Floats) -> None:
        self.points = points

    def chosen(self, concerns: Test) -> Floats:
        self.flags = concerns(self.points)
        return np.zeros((0, 3, 3))


@pytest.mark.parametrize("lean", [None, LEAN], ids=["upright", "leaning"])
@pytest.mark.parametrize("earth", [4 / 3 * 6_371_000.0, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_hulls_that_may_stand_before_a_body_are_those_of_numpy(by_sea: bool, earth: float, lean: np.ndarray | None) -> None:
    """Triangles and boxes all round and about the antenna, below the sea and above it; where they may have moved by 20 m too."""
    draw = np.random.default_rng(17)
    middle = draw.uniform([-3000.0, -3000.0, -9.0], [3000.0, 4000.0, 25.0], (4000, 1, 3))
    middle[:200] = [[[-25.0, 70.0, 0.0]]] + draw.uniform(-3.0, 3.0, (200, 1, 3))  # at the antenna's foot
    pose = BodyPose(np.array([40.0, 60.0, 0.5]), 2.1, lean)
    box = np.array(np.meshgrid([-1500.0, 1500.0], [3600.0, 3620.0], [4.0, 20.0])).reshape(3, 8).T
    pictures = tuple(Picture(PICTURE.antenna, earth, way) for way in (False, True)[: 1 + by_sea])
    for corners in (3, 8):
        asked = Asked(middle + draw.uniform(-4.0, 4.0, (4000, corners, 3)))

        def flags(moved: float, asked: Asked = asked) -> Flags:
            Onlooker(box, pictures).nearest(asked, pose, moved, 2.0)
            return asked.flags

        for moved in (0.0, 20.0):
            compiled, by_numpy = both(lambda moved=moved: flags(moved))
            np.testing.assert_array_equal(compiled, by_numpy)
            assert 5 < by_numpy.sum() < 2000

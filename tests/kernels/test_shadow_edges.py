"""Kernels that cut facets along the edges of shadows against numpy."""

import numpy as np
import pytest

from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.shadow_edges import visible_parts
from tests.kernels.both import both

COUNT = 60


def sunny(points: Floats, triangle: Indices) -> Flags:
    """Beyond a straight line; of odd triangles also inside a circle, whose edge no straight line explains."""
    inside = np.hypot(points[:, 0], points[:, 1]) < 0.8
    return (points @ [0.6, 0.8, 0.1] < 0.2) & (inside | (triangle % 2 == 0))


def exact(hidden: Floats, seen: Floats, triangle: Indices) -> Floats:
    """Where ways cross that line; none is found of odd triangles."""
    normal = np.array([0.6, 0.8, 0.1])
    share = (0.2 - hidden @ normal) / ((seen - hidden) @ normal)
    return np.where(triangle % 2 == 0, share, np.nan)


@pytest.mark.parametrize("exactly", [True, False], ids=["edges by triangles", "edges by search"])
@pytest.mark.parametrize("count", [0, 1, COUNT])
def test_parts_are_those_of_numpy(count: int, exactly: bool) -> None:
    """In the same order, to the rounding of coordinates of 1 m; with isosceles facets, one without area, and ones on one side."""
    corners = np.random.default_rng(4).uniform(-1.0, 1.0, (COUNT, 3, 3))
    corners[1], corners[2], corners[3] = [[-1, -1, 0], [1, -1, 0], [0, 2, 0]], [[0, 0, 0], [1, 0, 0], [0, 1, 0]], 0.3
    corners[4] = [[9, 9, 0], [10, 9, 0], [9, 10, 0]]
    args = corners[:count], np.arange(count), sunny, 12.0, exact if exactly else None
    compiled, by_numpy = both(lambda: visible_parts(*args))
    np.testing.assert_array_equal(compiled.origin, by_numpy.origin)
    np.testing.assert_array_equal(compiled.share, by_numpy.share)
    np.testing.assert_allclose(compiled.corners, by_numpy.corners, rtol=0.0, atol=1e-13)
    if count == COUNT:
        assert {0.0, 1.0} < {*compiled.share} and len(compiled.origin) > 2 * COUNT

"""Triangles that a test concerns are found without a look at all of them, and none is missed."""

import numpy as np
import pytest

from radar_service.numerics.types import Flags, Floats
from radar_service.trace.triangle_clusters import TriangleClusters
from radar_service.world.body import Mesh


def soup(count: int, seed: int) -> Mesh:
    """Triangles of 1 m at random in a cube of 100 m, in no order."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0.0, 100.0, (count, 1, 3)) + rng.uniform(-0.5, 0.5, (count, 3, 3))
    return Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def near(points: Floats) -> Flags:
    """Which hulls may have a part in a cube of 10 m."""
    return np.asarray(((points.min(axis=1) < 30.0) & (points.max(axis=1) > 20.0)).all(axis=1))


@pytest.mark.parametrize("count", [1, 15, 17, 1025, 20_000])
def test_no_triangle_is_missed(count: int) -> None:
    mesh = soup(count, count)
    corners = mesh.vertices[mesh.faces]
    expected, found = corners[near(corners)], TriangleClusters(mesh).chosen(near)
    assert sorted(map(tuple, found.reshape(-1, 9).tolist())) == sorted(map(tuple, expected.reshape(-1, 9).tolist()))


def test_few_of_many_triangles_are_looked_at() -> None:
    """A sheet of 300 x 300 squares of 1 m in rows, of which 10 x 10 concern: some hundred boxes and a thousand triangles."""
    side = 301
    east, north = np.meshgrid(np.arange(side, dtype=np.float64), np.arange(side, dtype=np.float64))
    square = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.stack([square, square + 1, square + side, square + 1, square + side + 1, square + side], axis=1).reshape(
        -1, 3
    )
    asked = []

    def counted(points: Floats) -> Flags:
        asked.append(len(points))
        return near(points)

    mesh = Mesh(np.stack([east.ravel(), north.ravel(), 25.0 + 0.0 * east.ravel()], axis=1), faces)
    assert len(TriangleClusters(mesh).chosen(counted)) >= 200 and sum(asked) < 0.03 * len(faces)

"""Triangles cut along a line keep their area, and each part lies on its own side."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.triangle_cuts import cut

RNG = np.random.default_rng(4)


def test_parts_lie_on_their_sides_and_make_up_the_whole() -> None:
    """200 triangles at random, cut by a plane: areas to rounding."""
    corners = RNG.uniform(-1.0, 1.0, (200, 3, 3))
    normal = np.array([0.3, -0.5, 0.8])
    (kept, first), (lost, second) = cut(corners, corners @ normal - 0.1)
    assert (kept @ normal >= 0.1 - 1e-12).all() and (lost @ normal <= 0.1 + 1e-12).all()
    total = np.bincount(first, areas(kept), 200) + np.bincount(second, areas(lost), 200)
    np.testing.assert_allclose(total, areas(corners), rtol=1e-9)


def test_what_lies_on_one_side_stays_as_it_is() -> None:
    corners = RNG.uniform(0.0, 1.0, (5, 3, 3))
    (kept, first), (lost, second) = cut(corners, np.ones((5, 3)))
    assert np.array_equal(kept, corners) and first.tolist() == [0, 1, 2, 3, 4] and not len(lost) and not len(second)


def test_further_columns_are_interpolated_along_the_edges() -> None:
    """A column that is linear over the triangle stays so."""
    corners = RNG.uniform(-1.0, 1.0, (20, 3, 3))
    wide = np.concatenate([corners, corners @ np.array([[2.0], [-1.0], [0.5]])], axis=2)
    for part, _ in cut(wide, corners[..., 0]):
        assert part[..., 3] == pytest.approx(part[..., :3] @ np.array([2.0, -1.0, 0.5]), abs=1e-12)

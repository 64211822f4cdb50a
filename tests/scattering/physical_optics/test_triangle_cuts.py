"""Triangles cut along a line keep their area, and each part lies on its own side."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.triangle_cuts import above_water, cut
from tests.scattering.physical_optics.meshes import areas

RNG = np.random.default_rng(4)


def test_parts_lie_on_their_sides_and_make_up_the_whole() -> None:
    """200 triangles at random, cut by a plane: areas to rounding. The parts face the way of their triangles."""
    corners = RNG.uniform(-1.0, 1.0, (200, 3, 3))
    normal = np.array([0.3, -0.5, 0.8])
    (kept, first), (lost, second) = cut(corners, corners @ normal - 0.1)
    assert (kept @ normal >= 0.1 - 1e-12).all() and (lost @ normal <= 0.1 + 1e-12).all()
    for parts, whole in ((kept, first), (lost, second)):
        ahead = [np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in (parts, corners[whole])]
        assert (np.einsum("ij,ij->i", *ahead) > 0.0).all()
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


def test_a_plate_keeps_what_rises_above_the_water() -> None:
    """4 m wide and high, about the origin: 0.4 m of it above water is 1.6 m^2, and no corner lies below."""
    a, b, c, d = np.array([[-2.0, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]])
    corners = np.array([[a, b, c], [a, c, d]])
    for rises in (0.4, 0.8, 1.3, 3.9):
        cut, origin = above_water(corners, 2.0 - rises)
        np.testing.assert_allclose(areas(cut).sum(), 4.0 * rises, rtol=1e-12)
        assert cut[:, :, 2].min() >= 2.0 - rises - 1e-12 and set(origin) <= {0, 1}


def test_parts_are_those_of_their_triangles() -> None:
    """Random triangles: each part lies in its triangle's plane, and areas above and below add up."""
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(200, 3, 3))
    upper, origin = above_water(corners, 0.1)
    lower, below = above_water(-corners, -0.1)
    total = np.bincount(origin, areas(upper), 200) + np.bincount(below, areas(lower), 200)
    np.testing.assert_allclose(total, areas(corners), rtol=1e-9)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[origin]
    height = np.einsum("nci,ni->nc", upper - corners[origin][:, :1], normal)
    np.testing.assert_allclose(height, 0.0, atol=1e-12)


def test_bodies_above_the_water_are_left_as_they_are() -> None:
    corners = np.arange(18.0).reshape(2, 3, 3)
    cut, origin = above_water(corners, -np.inf)
    assert cut is corners and origin.tolist() == [0, 1]
    assert len(above_water(corners, 100.0)[0]) == 0

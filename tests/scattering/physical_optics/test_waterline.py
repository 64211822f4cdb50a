"""What lies below the water is cut off, what lies above is kept exactly."""

import numpy as np

from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.waterline import above_water


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

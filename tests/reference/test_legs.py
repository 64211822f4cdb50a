"""Legs: what the curved sea leaves of a reflection; lengths and directions meet the kernels."""

import numpy as np
import pytest

from radar_service.propagation.multipath import specular_geometry
from tests.reference.legs import sea_divergence

EARTH = 4 / 3 * 6_371_000.0


def test_what_the_curved_sea_leaves_is_the_divergence_of_the_two_rays() -> None:
    """Kerr's factor of ground distances; legs have slant ones, which differ by the square of elevations of 0.02. 1 at the sea."""
    antenna, up = np.array([30.0, -20.0, 10.0]), np.array([0.0, 0.01, 0.5, 3.0, 30.0])
    for distance in (700.0, 5000.0, 12_500.0):
        positions = antenna + np.array([0.6, 0.8, 0.0]) * distance + np.outer(up - 10.0, [0.0, 0.0, 1.0])
        result = sea_divergence(positions, antenna, EARTH)
        np.testing.assert_allclose(result, specular_geometry(distance, up, 10.0, EARTH).divergence, rtol=1e-3)
        assert result[0] == pytest.approx(1.0, abs=1e-9) and (sea_divergence(positions, antenna, np.inf) == 1.0).all()
    assert sea_divergence(antenna + [[0.0, 20_000.0, -9.0]], antenna, EARTH) == 0.0

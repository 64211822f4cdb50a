"""Legs: lengths as the echo stage has them, directions as their derivatives."""

import numpy as np
import pytest

from radar_service.numerics.frames import polar_from_map
from radar_service.propagation.multipath import specular_geometry
from tests.reference.legs import direct_leg, leg_length, reflection_points, sea_divergence, sea_leg

ANTENNA = np.array([10.0, -20.0, 15.0])
EARTH = 4 / 3 * 6_371_000.0
EARTHS = (np.inf, EARTH)


def points(distance: float, height: float) -> np.ndarray:
    turn = np.array([0.3, 2.0, 4.4])
    return np.stack([10 + distance * np.sin(turn), -20 + distance * np.cos(turn), np.full(3, height)], axis=1)


@pytest.mark.parametrize("earth", EARTHS)
@pytest.mark.parametrize(("distance", "height"), [(100.0, 0.5), (450.0, 7.0), (4000.0, 3.0), (9000.0, 30.0)])
def test_lengths_are_those_of_the_echoes(earth: float, distance: float, height: float) -> None:
    position = points(distance, height)
    polar = polar_from_map(position, ANTENNA, earth)
    np.testing.assert_allclose(direct_leg(position, ANTENNA, earth).length, polar.range, rtol=1e-14)
    geometry = specular_geometry(polar.distance, position[:, 2], 15.0, earth)
    np.testing.assert_allclose(sea_leg(position, ANTENNA, earth).length, geometry.first + geometry.second, rtol=1e-14)
    for by_sea, leg in ((False, direct_leg), (True, sea_leg)):
        length = leg(position, ANTENNA, earth).length
        np.testing.assert_allclose(leg_length(position, ANTENNA, earth, by_sea), length, rtol=1e-15)


@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
@pytest.mark.parametrize("earth", EARTHS)
@pytest.mark.parametrize(("distance", "height"), [(100.0, 2.0), (450.0, 7.0), (4000.0, 13.0), (12000.0, 30.0)])
def test_directions_are_derivatives_of_the_length(by_sea: bool, earth: float, distance: float, height: float) -> None:
    """Differences over 1 cm: 1e-7 of rounding in 12 km / 1 cm. The earth's tilt
    enters the horizontal derivative by tilt times rise, 1e-5."""
    leg = sea_leg if by_sea else direct_leg
    position = points(distance, height)
    made = leg(position, ANTENNA, earth)
    level = np.concatenate([made.level, np.zeros((3, 1))], axis=1)
    up = np.array([0.0, 0.0, 1.0])

    def length(offset: np.ndarray) -> np.ndarray:
        return leg(position + offset, ANTENNA, earth).length

    rise = (length(0.01 * up) - length(-0.01 * up)) / 0.02
    ahead = (length(0.01 * level) - length(-0.01 * level)) / 0.02
    np.testing.assert_allclose(made.rise, rise, atol=1e-6)
    np.testing.assert_allclose(np.sqrt(1 - made.rise**2), ahead, atol=2e-5)


@pytest.mark.parametrize("earth", EARTHS)
def test_reflection_points_divide_the_way(earth: float) -> None:
    """Both straight parts, bent as frames have it, add up to the leg's length."""
    position = points(2500.0, 8.0)
    foot, reflects = reflection_points(position, ANTENNA, earth)
    assert reflects.all() and (foot[:, 2] == 0.0).all()
    bent = [p - [0, 0, 1] * (((p - ANTENNA)[:, :2] ** 2).sum(axis=1, keepdims=True) / (2 * earth)) for p in (foot, position)]
    total = np.linalg.norm(bent[0] - ANTENNA, axis=1) + np.linalg.norm(bent[1] - bent[0], axis=1)
    np.testing.assert_allclose(total, sea_leg(position, ANTENNA, earth).length, rtol=1e-12)


def test_what_the_curved_sea_leaves_is_the_divergence_of_the_two_rays() -> None:
    """Kerr's factor of ground distances; legs have slant ones, which differ by the square of elevations of 0.02. 1 at the sea."""
    antenna, up = np.array([30.0, -20.0, 10.0]), np.array([0.0, 0.01, 0.5, 3.0, 30.0])
    for distance in (700.0, 5000.0, 12_500.0):
        positions = antenna + np.array([0.6, 0.8, 0.0]) * distance + np.outer(up - 10.0, [0.0, 0.0, 1.0])
        result = sea_divergence(positions, antenna, EARTH)
        np.testing.assert_allclose(result, specular_geometry(distance, up, 10.0, EARTH).divergence, rtol=1e-3)
        assert result[0] == pytest.approx(1.0, abs=1e-9) and (sea_divergence(positions, antenna, np.inf) == 1.0).all()
    assert sea_divergence(antenna + [[0.0, 20_000.0, -9.0]], antenna, EARTH) == 0.0

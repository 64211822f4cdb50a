"""Positions relative to the antenna and rotations by hand; the intervals of angles, with their ends."""

import numpy as np
import pytest

from radar_service.numerics.frames import (
    body_rotation,
    direction,
    distances_from_map,
    effective_earth_radius,
    map_from_body,
    map_from_deck,
    polar_from_map,
    wrap_angle,
    wrap_bearing,
)

TURN = 2.0 * np.pi


@pytest.mark.parametrize("angle", [-1e-17, -5e-324, -TURN, TURN, 0.0, -1e-17 - TURN])
def test_a_bearing_of_north_is_zero_and_never_a_whole_turn(angle: float) -> None:
    assert float(wrap_bearing(angle)) == 0.0


def test_bearings_are_in_one_turn_and_angles_in_half_a_turn_either_way() -> None:
    angle = np.concatenate([np.linspace(-20.0, 20.0, 1001), np.nextafter(TURN * np.arange(-3, 4), -np.inf)])
    bearing, wrapped = wrap_bearing(angle), wrap_angle(angle)
    assert bearing.min() >= 0.0 and bearing.max() < TURN and np.abs(wrapped).max() <= np.pi
    for same in (bearing, wrapped):  # two roundings of at most 20 rad and one of the cosine's argument
        np.testing.assert_allclose(np.exp(1j * same), np.exp(1j * angle), rtol=0, atol=4 * 20 * np.finfo(float).eps)


def test_the_standard_atmosphere_has_an_earth_of_8495_km() -> None:
    assert effective_earth_radius(4 / 3) == pytest.approx(8_494_667, abs=1)
    assert np.isinf(effective_earth_radius(np.inf))


def test_polar_coordinates_of_a_3_4_5_triangle() -> None:
    """3 m east, 4 m north and 12 m up of the antenna on a flat earth: 5 m of ground, 13 m of range."""
    polar = polar_from_map(np.array([[103.0, 204.0, 27.0]]), np.array([100.0, 200.0, 15.0]), np.inf)
    assert polar.distance[0] == pytest.approx(5.0) and polar.range[0] == pytest.approx(13.0)
    assert polar.azimuth[0] == pytest.approx(np.arctan2(3, 4)) and polar.elevation[0] == pytest.approx(np.arctan2(12, 5))


def test_the_earth_drops_by_the_parabola() -> None:
    """d^2 / (2 ae) at 12 km and 4/3: 8.4759 m. Bearings run clockwise from north through east, south and west."""
    position = 12_000.0 * np.array([[0, 1, 0], [1, 0, 0], [0, -1, 0], [-1, 0, 0]])
    polar = polar_from_map(position, np.zeros(3), effective_earth_radius(4 / 3))
    np.testing.assert_allclose(polar.range * np.sin(polar.elevation), -8.4759, atol=1e-4)
    np.testing.assert_allclose(wrap_bearing(polar.azimuth), np.deg2rad([0, 90, 180, 270]))


def test_distances_are_those_of_the_polar_coordinates() -> None:
    """Two arithmetics; rounding of squares of 1e4 m."""
    position = np.random.default_rng(1).uniform(-1e4, 1e4, (200, 3))
    antenna = np.array([5.0, -7.0, 15.0])
    ground, slant = distances_from_map(position, antenna, 8.5e6)
    polar = polar_from_map(position, antenna, 8.5e6)
    np.testing.assert_allclose(ground, polar.distance, rtol=1e-12)
    np.testing.assert_allclose(slant, polar.range, rtol=1e-12)


def test_directions_point_where_their_angles_say() -> None:
    azimuth, elevation = np.deg2rad([0.0, 90.0, 200.0, 10.0]), np.deg2rad([0.0, 30.0, -5.0, 90.0])
    unit = direction(azimuth, elevation)
    np.testing.assert_allclose(unit[:2], [[0, 1, 0], [np.sqrt(0.75), 0, 0.5]], atol=1e-15)
    polar = polar_from_map(1000.0 * unit[:3], np.zeros(3), np.inf)
    np.testing.assert_allclose(wrap_bearing(polar.azimuth), azimuth[:3], atol=1e-12)
    np.testing.assert_allclose(polar.elevation, elevation[:3], atol=1e-12)
    np.testing.assert_allclose(unit[3], [0, 0, 1], atol=1e-15)


def test_the_bow_points_along_the_heading() -> None:
    """Heading 090: the bow (+y) is east, starboard (+x) is south."""
    points = np.array([[0.0, 10.0, 0.0], [2.0, 0.0, 5.0]])
    on_map = map_from_body(points, np.array([100.0, 50.0, 1.0]), np.deg2rad(90.0))
    np.testing.assert_allclose(on_map, [[110.0, 50.0, 1.0], [100.0, 48.0, 6.0]], atol=1e-12)


def test_a_deck_rolls_to_starboard_and_pitches_the_bow_up() -> None:
    """Without sway it is the rotation of a body. Rolled by 30 degrees starboard is half as low as it is far; pitched, the bow
    half as high. Any angles are a rotation: orthonormal, determinant 1."""
    heading = np.array([0.3])
    zero = np.zeros(1)
    np.testing.assert_allclose(map_from_deck(heading, zero, zero)[0], body_rotation(0.3), atol=1e-15)
    rolled = map_from_deck(zero, np.deg2rad([30.0]), zero)[0]
    np.testing.assert_allclose(rolled @ [1, 0, 0], [np.sqrt(0.75), 0, -0.5], atol=1e-15)
    pitched = map_from_deck(zero, zero, np.deg2rad([30.0]))[0]
    np.testing.assert_allclose(pitched @ [0, 1, 0], [0, np.sqrt(0.75), 0.5], atol=1e-15)
    matrix = map_from_deck(np.array([1.0]), np.array([0.4]), np.array([-0.2]))[0]
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    np.testing.assert_allclose(
        matrix @ [0, 1, 0], direction(np.array(1.0), np.array(-0.2)), atol=1e-15
    )  # roll leaves the bow

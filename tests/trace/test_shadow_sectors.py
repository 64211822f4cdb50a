"""The sectors behind spheres, and the points in them, against each pair tried."""

import numpy as np
import pytest

from radar_service.trace.shadow_sectors import ShadowSectors, points_behind, shadow_sectors

ANTENNA = np.array([100.0, -50.0, 15.0])


def test_a_sector_lies_behind_its_sphere() -> None:
    """99 m and 1.01 r + 1 m = 10.09 m, r = 9 m: the half width is asin(10.09 / 99)."""
    made = shadow_sectors(ANTENNA + [[99.0, 0, 0], [0, -99, 40], [5, 5, 0]], np.full(3, 9.0), ANTENNA)
    np.testing.assert_allclose(made.middle, [np.pi / 2, np.pi, np.pi / 4], rtol=1e-12)  # rounding
    np.testing.assert_allclose(made.half, [np.arcsin(10.09 / 99)] * 2 + [np.pi], rtol=1e-12)
    np.testing.assert_allclose(made.begin, [88.91, 88.91, 0], rtol=1e-12)


def every_pair(sectors: ShadowSectors, azimuth: np.ndarray, distance: np.ndarray) -> dict[int, list[int]]:
    aside = np.abs((azimuth - sectors.middle[:, None] + np.pi) % (2 * np.pi) - np.pi)
    behind = (aside <= sectors.half[:, None]) & (distance >= sectors.begin[:, None])
    return {n: np.flatnonzero(row).tolist() for n, row in enumerate(behind) if row.any()}


@pytest.mark.parametrize(("middle", "width"), [(0.0, np.pi), (np.pi, 0.4), (-2.0, 0.01), (1.0, 0.0)])
def test_points_behind_are_those_of_every_pair_also_past_south(middle: float, width: float) -> None:
    rng = np.random.default_rng(4)
    east, north = rng.uniform(-3000, 3000, (2, 60))
    centre = np.stack([east, north, np.zeros(60)], axis=1) + ANTENNA
    sectors = shadow_sectors(np.concatenate([centre, ANTENNA[None] + 1.0]), rng.uniform(1, 300, 61), ANTENNA)
    azimuth = (middle + rng.uniform(-width, width, 500) + np.pi) % (2 * np.pi) - np.pi
    distance = rng.uniform(0, 4000, 500)
    result = {n: points.tolist() for n, points in points_behind(sectors, azimuth, distance)}
    assert result == every_pair(sectors, azimuth, distance)
    assert 60 in result and len(result) > 1


def test_without_points_or_bodies_there_is_nothing() -> None:
    none = np.zeros(0)
    assert not list(points_behind(shadow_sectors(np.zeros((1, 3)), np.ones(1), ANTENNA), none, none))
    assert not list(points_behind(shadow_sectors(np.zeros((0, 3)), none, ANTENNA), np.ones(3), np.ones(3)))


def test_a_body_beyond_the_points_of_its_sector_has_none_behind_it() -> None:
    """The point 100 m off to the north lies before it, the one farther off beside it."""
    sectors = shadow_sectors(ANTENNA + [[0.0, 1000.0, 0.0]], np.full(1, 50.0), ANTENNA)
    azimuth, distance = np.array([0.0, 0.5]), np.array([100.0, 4000.0])
    assert not list(points_behind(sectors, azimuth, distance))
    assert list(points_behind(sectors, azimuth, distance[::-1]))[0][1].tolist() == [0]

"""The sectors behind spheres, and the points in them, against each pair tried."""

from collections.abc import Iterable
from itertools import groupby

import numpy as np
import pytest

from radar_service.trace.shadow_sectors import ShadowSectors, points_behind, shadow_sectors, top_slopes

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


def pairs_of(batches: Iterable[tuple[np.ndarray, np.ndarray]]) -> dict[int, list[int]]:
    """The points of each body, rising; raises where a pair comes twice."""
    pairs = sorted(pair for body, point in batches for pair in zip(body.tolist(), point.tolist(), strict=True))
    assert len(set(pairs)) == len(pairs)
    return {body: [point for _, point in some] for body, some in groupby(pairs, key=lambda pair: pair[0])}


@pytest.mark.parametrize(("middle", "width"), [(0.0, np.pi), (np.pi, 0.4), (-2.0, 0.01), (1.0, 0.0)])
def test_points_behind_are_those_of_every_pair_also_past_south(
    middle: float, width: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(4)
    east, north = rng.uniform(-3000, 3000, (2, 60))
    centre = np.stack([east, north, np.zeros(60)], axis=1) + ANTENNA
    sectors = shadow_sectors(np.concatenate([centre, ANTENNA[None] + 1.0]), rng.uniform(1, 300, 61), ANTENNA)
    azimuth = (middle + rng.uniform(-width, width, 500) + np.pi) % (2 * np.pi) - np.pi
    distance = rng.uniform(0, 4000, 500)
    monkeypatch.setattr("radar_service.trace.shadow_sectors.PAIRS", 700)  # some bodies at a time, and one that has more
    batches = list(points_behind(sectors, azimuth, distance))
    result = pairs_of(batches)
    assert result == every_pair(sectors, azimuth, distance)
    assert 60 in result and len(result) > 1 and len(batches) > 1


def test_without_points_or_bodies_there_is_nothing() -> None:
    none = np.zeros(0)
    assert not list(points_behind(shadow_sectors(np.zeros((1, 3)), np.ones(1), ANTENNA), none, none))
    assert not list(points_behind(shadow_sectors(np.zeros((0, 3)), none, ANTENNA), np.ones(3), np.ones(3)))


def test_a_body_beyond_the_points_of_its_sector_has_none_behind_it() -> None:
    """The point 100 m off to the north lies before it, the one farther off beside it."""
    sectors = shadow_sectors(ANTENNA + [[0.0, 1000.0, 0.0]], np.full(1, 50.0), ANTENNA)
    azimuth, distance = np.array([0.0, 0.5]), np.array([100.0, 4000.0])
    assert not list(points_behind(sectors, azimuth, distance))
    assert pairs_of(points_behind(sectors, azimuth, distance[::-1])) == {0: [0]}


@pytest.mark.parametrize("earth", [4 / 3 * 6_371_000.0, np.inf], ids=["curved", "flat"])
@pytest.mark.parametrize("height", [2.0, 15.0, 60.0], ids=["below the antenna", "as high", "above it"])
def test_no_point_of_a_body_lies_above_its_top_slope(height: float, earth: float) -> None:
    """The rim of a cylinder of 30 m, 35 m to 9 km off. The slope is no more than the sector's margins above it: a sphere wider by
    1 % and 1 m on either side, 0.1 m of height, and what the slope to the sea falls over the body."""
    rng = np.random.default_rng(2)
    for away in (35.0, 200.0, 9000.0):
        centre = ANTENNA + [away, 0.0, height / 2.0 - ANTENNA[2]]
        radius, turn = float(np.hypot(30.0, height / 2.0)), rng.uniform(0.0, 2.0 * np.pi, 2000)
        (slope,) = top_slopes(centre[None], np.array([radius]), np.array([height]), ANTENNA, earth)
        distance = np.hypot(away + 30.0 * np.cos(turn), 30.0 * np.sin(turn))
        highest = ((height - ANTENNA[2]) / distance - distance / (2.0 * earth)).max()
        assert highest <= slope
        wide = radius * 1.01 + 1.0
        margin = (abs(height - ANTENNA[2]) * 2.0 * wide / away + 0.2) / (away - wide) + wide / earth
        assert away < wide or slope - highest < margin


def test_points_over_a_body_are_not_paired_with_it() -> None:
    """From 15 m the level line to a point at 900 m passes 11 m over a body of 4 m before it; that to the sea's level meets it."""
    sectors = shadow_sectors(ANTENNA + [[0.0, 850.0, 0.0]], np.full(1, 5.0), ANTENNA)
    tops = top_slopes(ANTENNA + [[0.0, 850.0, -13.0]], np.full(1, 5.0), np.full(1, 4.0), ANTENNA, np.inf)
    slopes = (np.array([15.0, 0.0]) - ANTENNA[2]) / 900.0
    ((body, point),) = points_behind(sectors, np.zeros(2), np.full(2, 900.0), (tops, slopes))
    assert body.tolist() == [0] and point.tolist() == [1]

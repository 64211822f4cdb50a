"""Crossings: closed forms, a slow search from spoke to spoke, and the border between two scans."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from radar_service.numerics.types import Floats, Indices
from radar_service.radar.crossing_times import CrossingSearch

PERIOD, SPOKES = 2.5, 720


class Straight:
    """Points on straight courses, relative to the antenna."""

    def __init__(self, position: Floats, velocity: Floats) -> None:
        self.position, self.velocity = np.asarray(position, dtype=float), np.asarray(velocity, dtype=float)

    def __call__(self, points: Indices, time: Floats) -> Floats:
        return np.asarray(self.position[points] + self.velocity[points] * time[:, None])

    def search(self) -> CrossingSearch:
        return CrossingSearch(self, len(self.position), PERIOD, SPOKES)

    def ahead(self, point: int, time: Floats) -> Floats:
        """How far the boresight is ahead at times (...), -pi to pi."""
        east, north = (self.position[point, k] + self.velocity[point, k] * time for k in (0, 1))
        return np.asarray((2 * np.pi * time / PERIOD - np.arctan2(east, north) + np.pi) % (2 * np.pi) - np.pi)

    def slow_crossings(self, point: int, scan: int, steps: int = 20_000) -> list[float]:
        """By a fine search for changes of sign, each refined by Brent's method."""
        times = (scan + np.arange(steps + 1) / steps) * PERIOD
        ahead = self.ahead(point, times)
        changes = np.flatnonzero((ahead[:-1] * ahead[1:] < 0) & (np.abs(ahead[:-1]) < 1))
        return [brentq(lambda t: self.ahead(point, t), times[k], times[k + 1], xtol=1e-14) for k in changes]


def test_points_at_rest_are_crossed_when_the_boresight_points_at_them() -> None:
    angles = np.deg2rad([0.0, 0.1, 90.0, 180.0, 270.0, 359.9])
    found = Straight(1000 * np.stack([np.sin(angles), np.cos(angles)], axis=1), np.zeros((6, 2))).search().within(7)
    np.testing.assert_array_equal(found.point, np.arange(6))
    np.testing.assert_allclose(found.time, (7 + angles / (2 * np.pi)) * PERIOD, rtol=1e-15)  # rounding


@pytest.mark.parametrize("scan", [0, 400])
def test_points_under_way_agree_with_a_slow_search(scan: int) -> None:
    """Drawn courses: far ones, and some that pass within metres of the antenna during the scan. Tolerance: rounding of
    the time, 1e-13 s at t = 1000 s, and of a bearing that turns by up to 30 rad/s, both times ten."""
    rng = np.random.default_rng(20261122 + scan)
    velocity = rng.uniform(-25, 25, (40, 2))
    distance = np.geomspace(2, 20_000, 40)[:, None]
    heading = rng.uniform(0, 2 * np.pi, 40)
    middle = distance * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    points = Straight(middle - velocity * (scan + 0.5) * PERIOD, velocity)
    found = points.search().within(scan)
    assert (np.diff(found.time) >= 0).all()
    for point in range(40):
        times = found.time[found.point == point]
        np.testing.assert_allclose(times, points.slow_crossings(point, scan), atol=1e-11, rtol=0)
    both, later = points.search().within(scan, 2), points.search().within(scan + 1)
    for together, *alone in zip(both, found, later, strict=True):
        np.testing.assert_array_equal(together, np.concatenate(alone))


@pytest.mark.parametrize(("drift", "counts"), [(25.0, {0, 1}), (-25.0, {1, 2})], ids=["with the beam", "against it"])
def test_a_target_near_north_is_crossed_never_once_or_twice_in_a_scan(drift: float, counts: set[int]) -> None:
    """It passes north slowly; over all scans it is crossed as often as the boresight overtakes it."""
    points = Straight([[-drift * 25.0 * PERIOD, 3000.0]], [[drift, 0.0]])
    per_scan = [points.search().within(scan).time for scan in range(50)]
    assert {len(times) for times in per_scan} == counts
    every = np.concatenate(per_scan)
    ends = [math.atan2(*(points.position[0] + points.velocity[0] * t)) for t in (0.0, 50 * PERIOD)]
    assert len(every) == 50 - math.floor(ends[1] / (2 * math.pi)) + math.floor(ends[0] / (2 * math.pi))
    assert (np.diff(every) > 0.9 * PERIOD).all()


@pytest.mark.parametrize("east", [0.0, -1e-18, 1e-18, -1e-10])
@pytest.mark.parametrize("scan", [0, 1, 12_345])
def test_a_target_exactly_north_belongs_to_one_scan(east: float, scan: int) -> None:
    points = Straight([[east, 1000.0]], [[0.0, 0.0]])
    counts = [len(points.search().within(number).time) for number in (scan, scan + 1)]
    assert counts == [1, 1]


def test_without_points_there_is_nothing() -> None:
    found = Straight(np.zeros((0, 2)), np.zeros((0, 2))).search().within(0)
    assert len(found.point) == len(found.time) == 0

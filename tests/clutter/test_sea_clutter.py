"""The texture that a scene's sea and own ship make: length, life and drift of the rows that the clutter is made from."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.clutter.clutter import prepare_clutter
from radar_service.clutter.texture import gamma_from_gaussian
from radar_service.frames import effective_earth_radius
from radar_service.receive.compression import compression_for
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import scene

STEP = 299_792_458 / 150e6  # m, of a bin at 75 MSPS
RADAR = {"range_max_m": 8000, "azimuths": 72, "beamwidth_deg": 10, "rpm": 60}
SEA = {"sea_state": 5, "wind_from_deg": 90, "sea_texture_shape": 2}  # wind 11 m/s: waves of 12.543 m/s and 8.036 s
SPEED, LIFETIME = 11 / 0.877, 2 * np.pi * 11 / 0.877 / 9.80665


def rows(count: int, seed: int = 1, **own_ship: Any) -> NDArray[np.float64]:
    """Gaussian texture (count revolutions of a second, rows of the turn, bins)."""
    made = scene([], radar=RADAR, environment=SEA, own_ship=own_ship)
    line_of_sight = OcclusionScene((), effective_earth_radius(4 / 3))
    clutter = prepare_clutter(made, line_of_sight, compression_for(made.radar, 6), seed)
    assert clutter is not None and clutter.sea is not None
    per_scan = clutter.sea.texture.rows_per_scan
    taken = [np.array(clutter.sea.texture.span(scan * per_scan, (scan + 1) * per_scan)) for scan in range(count)]
    return np.stack(taken).astype(np.float64)


def best_lag(before: NDArray[np.float64], after: NDArray[np.float64], maximum: int = 40) -> int:
    """By how many bins `after` lies farther out than `before` (n,)."""
    middle = before[maximum:-maximum]
    lags = range(-maximum, maximum + 1)
    return int(np.argmax([middle @ after[maximum + lag : len(after) - maximum + lag] for lag in lags])) - maximum


def test_length_is_the_published_one_after_the_gamma_law() -> None:
    """Watts at 11 m/s: 19.38 m across the wind, 38.76 m along it. The textures' correlation there is 1/e; 0.06 is sampling
    error of 6 x 8 km / 2 L stretches whose texture has a fourth moment of 15."""
    gaussian = rows(60)[::10]
    texture = gamma_from_gaussian(gaussian, 2.0) - 1
    for row, length in ((0, 19.38), (gaussian.shape[1] // 4, 38.76), (gaussian.shape[1] // 2, 19.38)):
        lag = length / STEP
        some = texture[:, row]
        result = [np.mean(some[:, n:] * some[:, : some.shape[1] - n]) * 2.0 for n in (int(lag), int(lag) + 1)]
        assert np.interp(lag % 1, (0, 1), result) == pytest.approx(np.exp(-1), abs=0.06)


def test_waves_run_downwind_and_own_ship_leaves_them_behind() -> None:
    """Wind from the east: in a second waves come 12.5 m (6 bins) nearer upwind and go as far away downwind, abeam nothing.
    Own ship at 20 m/s adds to it what it leaves behind: 32.5 m (16 bins) and 7.5 m (4 bins)."""
    turn = rows(1).shape[1]
    east, west, north = turn // 4, 3 * turn // 4, 0
    at_rest = rows(2)
    assert [best_lag(at_rest[0, r], at_rest[1, r]) for r in (east, west, north)] == pytest.approx([-6, 6, 0], abs=1)
    for course_deg, lags in ((90, [-16, 16]), (270, [4, -4])):
        moved = rows(2, course_deg=course_deg, speed_kn=20 / 0.5144444)
        assert [best_lag(moved[0, r], moved[1, r]) for r in (east, west)] == pytest.approx(lags, abs=1)


def test_life_is_the_period_of_the_tallest_waves() -> None:
    """Abeam of the wind nothing moves: the correlation after s seconds is that of the cosine weights for 8.036 s; 5 sigma of
    16 km / 2 L independent stretches, L = 26 m that of the Gaussian."""
    gaussian = rows(12)[:, 0]

    def weights(time: float) -> NDArray[np.float64]:
        share, k = np.pi / 2 * (time / LIFETIME % 1), int(time // LIFETIME)
        result = np.zeros(4)
        result[k : k + 2] = np.cos(share), np.sin(share)
        return result

    for later in range(12):
        expected = weights(0.0) @ weights(float(later))
        assert np.mean(gaussian[0] * gaussian[later]) == pytest.approx(expected, abs=5 * np.sqrt(2 * 26 / 8000))

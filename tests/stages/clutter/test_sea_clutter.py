"""The texture that a scene's sea and own ship make: length, life and drift of the rows that the clutter is made from."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.numerics.frames import effective_earth_radius
from radar_service.receive.compression import compression_for
from radar_service.stages.clutter.azimuth_rows import weight_rows
from radar_service.stages.clutter.clutter import prepare_clutter
from radar_service.stages.clutter.resolution_cell import resolution_cell
from radar_service.stages.clutter.sea_clutter import Sea
from radar_service.trace.line_of_sight import OcclusionScene
from tests.reference.compressed_pulse import sinc2_beam
from tests.scenes import scene

COLUMN = 3 * 299_792_458 / 150e6  # m, of a column of texture: three bins at 75 MSPS, a quarter of the shortest length
RADAR = {"range_max_m": 8000, "azimuths": 72, "beamwidth_deg": 10, "rpm": 60}
SEA = {"sea_state": 5, "wind_from_deg": 90, "sea_texture_shape": 2}  # wind 11.45 m/s: waves of 13.057 m/s and 8.366 s
SPEED = 3.16 * 5**0.8 / 0.877
LIFETIME = 2 * np.pi * SPEED / 9.80665


def rows(count: int, seed: int = 1, **own_ship: Any) -> NDArray[np.float64]:
    """Gaussian texture (count revolutions of a second, rows of the turn, bins)."""
    made = scene([], radar=RADAR, environment=SEA, own_ship=own_ship)
    line_of_sight = OcclusionScene((), effective_earth_radius(4 / 3))
    clutter = prepare_clutter(made, line_of_sight, compression_for(made.radar, 6), seed, seed)
    assert clutter is not None and clutter.sea is not None
    per_scan = clutter.sea.texture.rows_per_scan
    taken = [np.array(clutter.sea.texture.span(scan * per_scan, (scan + 1) * per_scan)) for scan in range(count)]
    return np.stack(taken).astype(np.float64)


def best_lag(before: NDArray[np.float64], after: NDArray[np.float64], maximum: int = 20) -> float:
    """By how far `after` lies farther out than `before` (n,) [m]."""
    middle = before[maximum:-maximum]
    lags = range(-maximum, maximum + 1)
    return (int(np.argmax([middle @ after[maximum + lag : len(after) - maximum + lag] for lag in lags])) - maximum) * COLUMN


WINDS = {state: 3.16 * state**0.8 for state in (3, 5, 6)}  # m/s
FINE = {"range_max_m": 5400, "azimuths": 1440, "beamwidth_deg": 1.0, "rpm": 48, "power_w": 1e6}


def averaged_length(state: int, off_wind: float, distance: float, pulse_length: float, across: bool) -> float:
    """Distance [m] along range or across it over which the covariance of the mean power falls to 1/e.

    By sums over the map: the texture's exp(-(x / 2 L)^2 - (y / L)^2) with the overlaps of a sinc^4 beam (its power both ways)
    and of the pulse.
    """
    length = np.pi / 2 * WINDS[state] ** 2 / 9.80665
    theta = np.arange(-100, 101) * np.deg2rad(0.05)
    beam = sinc2_beam(theta, np.deg2rad(1.0)) ** 2
    beam_overlap = np.correlate(beam, beam, "same")
    s = theta * distance
    r = np.linspace(-2.0, 2.0, 41) * pulse_length
    pulse_overlap = np.exp(-np.pi * r**2 / 2 / pulse_length**2)

    def covariance(dr: float, ds: float) -> float:
        out, over = np.meshgrid(r + dr, s + ds, indexing="ij")
        x, y = out * np.cos(off_wind) - over * np.sin(off_wind), out * np.sin(off_wind) + over * np.cos(off_wind)
        field = np.exp(-((x / 2 / length) ** 2) - (y / length) ** 2)
        return float(pulse_overlap @ field @ beam_overlap)

    lags = np.linspace(0.0, 4 * length + 3 * 0.01 * distance, 80)
    result = np.array([covariance(0.0, lag) if across else covariance(lag, 0.0) for lag in lags])
    return float(np.interp(-np.exp(-1), -result / result[0], lags))


def measured_length(covariance: list[float], lag: float) -> float:
    """Distance [m] at which a covariance at multiples of a lag [m], the first of which is the variance, falls to 1/e."""
    share = np.array(covariance) / covariance[0]
    last = int(np.argmax(share < np.exp(-1)))
    return float(np.interp(-np.exp(-1), -share[last - 1 : last + 1], np.arange(last - 1, last + 1) * lag))


@pytest.mark.sample(2)
@pytest.mark.parametrize(("distance", "scans"), [(175, 50), (1000, 40), (5000, 10)])
@pytest.mark.parametrize(("state", "shape", "bandwidth_hz"), [(3, 5.0, 50e6), (5, 1.0, 40e6), (6, 0.5, 20e6)])
def test_texture_falls_to_one_over_e_on_the_ellipse(
    state: int, shape: float, bandwidth_hz: float, distance: int, scans: int
) -> None:
    """At 0, 45 and 90 degrees off the wind, along range and across it: the distance over which the mean power decorrelates is
    within 20 % (required) of what beam and pulse make of L and 2 L. Each 16th scan, 20 s apart, has new waves."""
    radar = FINE | {"bandwidth_hz": bandwidth_hz, "range_max_m": 1.15 * distance + 250}
    made = scene([], radar=radar, environment={"sea_state": state, "wind_from_deg": 0, "sea_texture_shape": shape})
    compression = compression_for(made.radar, 6)
    clutter = prepare_clutter(made, OcclusionScene((), effective_earth_radius(4 / 3)), compression, 1, 1)
    assert clutter is not None and clutter.sea is not None
    step, azimuth_step = made.radar.range_step * clutter.sea.column_bins, 2 * np.pi / FINE["azimuths"]
    pulse_length = resolution_cell(made.radar.azimuth_gain, compression, made.radar.range_step).length
    count = {175: 150, 1000: 56, 5000: 22}[distance]
    low = int(max(0.85 * distance, 60) / step)
    for off_wind_deg in (0, 45, 90):
        middle = 1440 + round(np.deg2rad(off_wind_deg) / azimuth_step)
        number = np.arange(middle - count // 2, middle + count // 2)
        halves = np.split(number, np.flatnonzero(np.diff(number // 1440)) + 1)  # at north
        taken = [
            np.concatenate([sum_rows(clutter.sea, half + 1440 * 16 * scan) for half in halves])[:, low:]
            for scan in range(scans)
        ]
        texture = np.stack(taken).astype(np.float64) - 1
        near = texture[..., : int(0.3 * distance / step)].swapaxes(1, 2)
        for values, lag, across in ((texture, step, False), (near, azimuth_step * distance, True)):
            expected = averaged_length(state, np.deg2rad(off_wind_deg), distance, pulse_length, across)
            last = int(1.5 * expected / lag) + 2
            if last < values.shape[2]:
                result = [np.mean(values[..., k:] * values[..., : values.shape[2] - k]) for k in range(last)]
                assert measured_length(result, lag) == pytest.approx(expected, rel=0.2), (off_wind_deg, across)


def sum_rows(sea: Sea, number: NDArray[np.int64]) -> NDArray[np.float32]:
    """Texture (K, columns) at consecutive azimuths of a scan."""
    first, stop, weights = sea.texture_beam.at(number)
    return np.asarray(sea.table.roots(weight_rows(weights, sea.texture.span(first, stop))) ** 2)


def test_waves_run_downwind_and_own_ship_leaves_them_behind() -> None:
    """Wind from the east: in a second waves come 13.1 m nearer upwind and go as far away downwind, abeam nothing. Own ship at
    20 m/s adds to it what it leaves behind: 33.1 m and 6.9 m. To the column (6 m)."""
    turn = rows(1).shape[1]
    east, west, north = turn // 4, 3 * turn // 4, 0
    at_rest = rows(2)
    lags = [best_lag(at_rest[0, r], at_rest[1, r]) for r in (east, west, north)]
    assert lags == pytest.approx([-SPEED, SPEED, 0], abs=COLUMN)
    for course_deg, expected in ((90, SPEED + 20), (270, SPEED - 20)):
        moved = rows(2, course_deg=course_deg, speed_kn=20 / 0.5144444)
        lags = [best_lag(moved[0, r], moved[1, r]) for r in (east, west)]
        assert lags == pytest.approx([-expected, expected], abs=COLUMN)


def test_life_is_the_period_of_the_tallest_waves() -> None:
    """Abeam of the wind nothing moves: the correlation after s seconds is that of the cosine weights for 8.366 s; 5 sigma of
    16 km / 2 L independent stretches, L = 28 m that of the Gaussian."""
    gaussian = rows(12)[:, 0]

    def weights(time: float) -> NDArray[np.float64]:
        share, k = np.pi / 2 * (time / LIFETIME % 1), int(time // LIFETIME)
        result = np.zeros(4)
        result[k : k + 2] = np.cos(share), np.sin(share)
        return result

    for later in range(12):
        expected = weights(0.0) @ weights(float(later))
        assert np.mean(gaussian[0] * gaussian[later]) == pytest.approx(expected, abs=5 * np.sqrt(2 * 28 / 8000))

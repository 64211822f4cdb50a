"""Waves of a seaway: their heights, frequencies and directions against the spectrum they are drawn from."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.constants import GRAVITY
from radar_service.numerics.types import Floats
from radar_service.world.seaway import WAVES, Seaway, drawn_waves, energy_below

SEA = Seaway(height=2.0, period=8.0, towards=np.deg2rad(130.0), spread=1.0, seed=4, list_rms=0.0, trim_rms=0.0)
PEAK = 2.0 * np.pi / 8.0
PLACE = np.array([[300.0, -800.0]])


def test_the_spectrum_is_that_of_the_ittc() -> None:
    """S = 5/16 H^2 wp^4 w^-5 exp(-5/4 (wp / w)^4), whose peak is wp and whose variance is H^2 / 16."""
    frequency = np.linspace(0.4 * PEAK, 4.0 * PEAK, 40001)
    density = np.gradient(energy_below(frequency, PEAK), frequency) * 2.0**2 / 16.0
    expected = 5.0 / 16.0 * 4.0 * PEAK**4 * frequency**-5.0 * np.exp(-1.25 * (PEAK / frequency) ** 4)
    np.testing.assert_allclose(density[1:-1], expected[1:-1], atol=1e-6 * expected.max())
    assert frequency[density.argmax()] == pytest.approx(PEAK, rel=1e-3)


@pytest.mark.parametrize("seed", [0, 7])
def test_significant_height_is_four_standard_deviations(seed: int) -> None:
    """Of the elevation at a point, over a time in which no two waves stay in step: an hour of 450 waves errs by 1 / sqrt(450) of
    the variance for each of some ten waves that count, 3 sigma of it are 5 % of the deviation; and exactly by amplitudes."""
    waves = drawn_waves(replace(SEA, seed=seed))
    assert 4.0 * np.sqrt((waves.amplitude**2).sum() / 2.0) == pytest.approx(2.0, rel=1e-12)
    time = np.linspace(0.0, 36_000.0, 8_001)
    elevation = waves.elevation(np.repeat(PLACE, len(time), axis=0), time)
    assert 4.0 * elevation.std() == pytest.approx(2.0, rel=0.02)
    assert abs(elevation.mean()) < 0.01


def test_energy_lies_where_the_spectrum_has_it() -> None:
    """Each wave has the energy of its band, at most 4.5 % of all, and lies within it; 0.9 % of all lies outside of all bands."""
    waves = drawn_waves(SEA)
    order = np.argsort(waves.frequency)
    energy = waves.amplitude[order] ** 2 / 2.0 / (2.0 / 4.0) ** 2
    assert energy.max() < 0.045
    below = np.cumsum(energy) - energy / 2.0  # to the middle of each band
    assert (np.abs(below - energy_below(waves.frequency[order], PEAK)) < energy / 2.0 + 0.009).all()
    assert waves.frequency.min() > 0.5 * PEAK and waves.frequency.max() < 3.6 * PEAK


@pytest.mark.parametrize("spread", [1.0, 4.0])
def test_directions_are_those_of_the_distribution(spread: float) -> None:
    """cos^(2 s): its mean is the given direction, and the mean of sin^2 is 1 / (2 s + 2). Of shares that are spread evenly with
    a draw in each the mean over N errs by less than 1 / N of the half circle."""
    waves = drawn_waves(replace(SEA, spread=spread))
    off = np.arctan2(*waves.wavenumber.T) - SEA.towards
    assert np.abs(np.sin(off).mean()) < np.pi / WAVES
    assert np.mean(np.sin(off) ** 2) == pytest.approx(1.0 / (2.0 * spread + 2.0), abs=np.pi / WAVES)
    assert (np.cos(off) > 0.0).all()
    assert abs(np.corrcoef(off, waves.frequency)[0, 1]) < 4.0 / np.sqrt(WAVES)  # in random order: 4 sigma


def test_waves_are_those_of_deep_water() -> None:
    waves = drawn_waves(SEA)
    np.testing.assert_allclose(np.hypot(*waves.wavenumber.T), waves.frequency**2 / GRAVITY)
    np.testing.assert_array_equal(waves.over_ground, waves.frequency)


def test_waves_go_with_the_stream() -> None:
    stream = (1.2, -0.7)
    time: Floats = np.array([0.0, 40.0, 4000.0])
    still = drawn_waves(SEA).elevation(np.repeat(PLACE, 3, axis=0), time)
    drifting = drawn_waves(SEA, stream).elevation(PLACE + time[:, None] * stream, time)
    np.testing.assert_allclose(drifting, still, atol=1e-9)


def test_a_seed_draws_one_sea() -> None:
    first, again, other = (drawn_waves(replace(SEA, seed=seed)) for seed in (4, 4, 5))
    np.testing.assert_array_equal(first.phase, again.phase)
    assert not np.isin(first.phase, other.phase).any() and not np.isin(first.frequency, other.frequency).any()
    higher = drawn_waves(replace(SEA, height=4.0))
    np.testing.assert_allclose(higher.amplitude, 2.0 * first.amplitude)
    np.testing.assert_array_equal(higher.phase, first.phase)

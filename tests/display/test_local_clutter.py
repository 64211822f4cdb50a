"""Auto gain and auto sea: false alarms as theory says, ships and coasts kept, every spoke judged by itself."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.display.video import (
    AUTO_PFA,
    MARGIN_DB,
    RANK,
    WINDOW,
    clutter_level,
)

STEP = 2.0  # m
CELLS = 2500
RANGE = STEP * (np.arange(CELLS) + 0.5)
Powers = NDArray[np.float64]


def level_of(power: Powers) -> Powers:
    """The level [dB] of power (K, N) over the noise."""
    return clutter_level(power.astype(np.float32), 1.0, RANGE[0], STEP).astype(np.float64)


def threshold(power: Powers) -> Powers:
    """Threshold of both automatics, as power over the noise."""
    return 10.0 ** ((level_of(power) + MARGIN_DB) / 10.0)


def exponential(seed: int, spokes: int = 400) -> Powers:
    return np.random.default_rng(seed).exponential(1.0, (spokes, CELLS))


def sea_mean(over_noise_db: float) -> Powers:
    """Mean of noise, and of clutter that falls as R^-3 from a level at 500 m; the mean noise is 1."""
    return 1.0 + 10.0 ** (over_noise_db / 10.0) * (500.0 / np.maximum(RANGE, 50.0)) ** 3


def test_noise_alone_gives_the_stated_false_alarms() -> None:
    """Given the threshold T, noise of mean 1 exceeds it with probability exp(-T): no rare event need be awaited. T is never
    below that of the noise itself. Means of 75 cells err by 0.12, the eighth of eleven lies half of that above 1, and is
    higher before it falls by R^-3 over half a kilometre: the rate falls by a factor of exp(13.8 x 0.1) at most."""
    rate = np.exp(-threshold(exponential(1))).mean(axis=0)
    assert np.all(rate <= AUTO_PFA * (1 + 1e-4))  # float32
    assert rate.mean() > AUTO_PFA / 4


def test_exponential_clutter_gives_the_stated_false_alarms() -> None:
    """T errs by some 0.07 of itself, of 13.8: the mean rate is within a factor of 5, at each range beyond the nearest
    blocks. These have 16 cells, whose means err by a quarter."""
    mean = sea_mean(50.0)
    rate = (np.exp(-threshold(mean * exponential(2)) / mean).mean(axis=0))[(RANGE > 300.0) & (RANGE < 2000.0)]
    assert AUTO_PFA / 5 < rate.min() and rate.max() < 5 * AUTO_PFA


@pytest.mark.parametrize("over_noise_db", [0.0, 10.0, 30.0, 50.0])
def test_sea_clutter_rarely_shows(over_noise_db: float) -> None:
    """From 50 m on; the level of the sea is right to 1 dB, over the noise as well as in it."""
    mean = sea_mean(over_noise_db)
    power = mean * exponential(3)
    beyond = RANGE > 300.0
    assert np.exp(-threshold(power) / mean).mean(axis=0)[RANGE > 50.0].mean() < 2 * AUTO_PFA
    error_db = level_of(power)[:, beyond] - 10.0 * np.log10(mean[beyond])
    assert -0.5 < np.median(error_db) < 1.0


def test_a_ship_barely_raises_the_threshold() -> None:
    """200 m of ship, 60 dB over the sea, in up to three of eleven blocks: the rank moves up by three, to the greatest of eight
    means that err by 0.5 dB."""
    power = sea_mean(30.0) * exponential(4, 100)
    without = level_of(power)
    power[:, (RANGE > 1500) & (RANGE < 1700)] *= 1e6
    change = level_of(power) - without
    assert change.min() >= 0.0 and change.mean(axis=0).max() < 1.5 and change.max() < 3.0
    assert WINDOW - RANK == 3


def test_land_behind_the_sea_is_not_subtracted() -> None:
    """Land from 2 to 4 km, 40 dB over the noise: what is subtracted is the sea before it, falling as R^-3, and 6 dB."""
    power = sea_mean(20.0) * exponential(5, 100)
    land = (RANGE > 2000) & (RANGE < 4000)
    power[:, land] *= 1e4
    sea_db = 10.0 * np.log10(sea_mean(20.0)[land])
    assert (level_of(power)[:, land] - sea_db).max() < 6.0 + 2.0  # dB; the level before the coast errs by 1 dB


@pytest.mark.parametrize("cells", [1, 3, 16, 17, 40, 200])
def test_short_spokes_and_cells_without_power_are_possible(cells: int) -> None:
    level = clutter_level(np.zeros((2, cells), np.float32), 1e-15, 5.0, 10.0)
    assert level.shape == (2, cells) and level.max() < 0.01  # dB: EMPTY, at 1/100 of the range


def test_the_strongest_echoes_that_a_scene_may_have_are_finite() -> None:
    level = clutter_level(np.full((2, 200), 1e34, np.float32), 1e-15, 5.0, 10.0)
    assert np.isfinite(level).all()

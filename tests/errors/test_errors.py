"""The short modules of errors, each under its name."""

import numpy as np
import pytest

from radar_service.errors.sensors import BLOCK, SINUSOIDS, SensorNoise, draws
from radar_service.records.reports import Readings
from radar_service.service.radio.error_stage import ReadingsHistory


# history: true readings of earlier spokes, from a memory of bounded size.
def readings(first: int, count: int) -> Readings:
    """Readings whose values tell the number."""
    number = np.arange(first, first + count, dtype=np.float64)
    return Readings(number, number + 0.1, np.stack([number + 0.2, number + 0.3], axis=1), number + 0.4, number + 0.5)


def found(history: ReadingsHistory, *number: int) -> list[float]:
    """The azimuths of spokes; the other columns must belong to them."""
    made = history.readings(np.array(number))
    columns = (made.heading - 0.1, made.position[:, 0] - 0.2, made.position[:, 1] - 0.3, made.course - 0.4, made.speed - 0.5)
    for column in columns:
        np.testing.assert_allclose(column, made.azimuth, atol=1e-12)  # rounding
    return list(made.azimuth)


def test_it_returns_the_readings_of_each_spoke() -> None:
    history = ReadingsHistory(16)
    history.add(0, readings(0, 10))
    history.add(10, readings(10, 10))
    assert found(history, 4, 19, 12) == [4, 19, 12]


def test_what_is_not_kept_is_that_of_the_newest_before_it() -> None:
    history = ReadingsHistory(16)
    history.add(5, readings(5, 5))
    assert found(history, 0, 5, 9, 30) == [5, 5, 9, 9]  # none is before 0
    history.add(12, readings(12, 3))  # 10 and 11 were never sent
    assert found(history, 10, 11, 12, 14, 15) == [9, 9, 12, 14, 14]
    history.add(15, readings(15, 10))
    assert found(history, 2, 13, 24) == [9, 13, 24]  # 9 is the oldest of 16: 9 and 12 to 24


# sensors: noise of sensors against its law. Seeds are fixed; bounds are 4.4 standard errors, a level of 1e-5 for each.
SEEDS, SIGMAS = 3000, 4.4
TIME = 30.0  # s, the correlation time
LAGS = TIME * np.array([0.0, 0.5, 1.0, 2.0])


def test_mean_deviation_and_correlation_over_many_seeds() -> None:
    start = 1234.5
    values = np.array([SensorNoise(TIME, seed, 1).at(np.zeros(4, dtype=np.int64), start + LAGS) for seed in range(SEEDS)])
    assert np.abs(values.mean(axis=0)).max() < SIGMAS / np.sqrt(SEEDS)
    kurtosis = 3.0 - 1.5 / SINUSOIDS
    assert np.abs(np.mean(values**2, axis=0) - 1.0).max() < SIGMAS * np.sqrt((kurtosis - 1.0) / SEEDS)
    correlation = np.mean(values[:, :1] * values, axis=0)
    expected = np.exp(-LAGS / TIME)
    error = SIGMAS * np.sqrt((1.0 + expected**2) / SEEDS)  # of the product of two normal numbers
    assert (np.abs(correlation - expected) < error).all()


def test_a_single_run_has_the_deviation_and_the_correlation_time_too() -> None:
    """Over 2000 correlation times; frequencies are one in each of equal shares, which leaves less than 0.05 of either."""
    step = TIME / 10.0
    values = SensorNoise(TIME, 5, 1).at(np.zeros(20_000, dtype=np.int64), step * np.arange(20_000))
    assert abs(values.mean()) < 0.05 and values.std() == pytest.approx(1.0, abs=0.05)
    assert np.mean(values[:-10] * values[10:]) == pytest.approx(np.exp(-1.0), abs=0.05)


def test_noise_is_a_function_of_time() -> None:
    noise, number = SensorNoise(TIME, 5, 1), np.arange(100)
    whole = noise.at(number, 0.1 * number)
    np.testing.assert_array_equal(SensorNoise(TIME, 5, 1).at(number[40:], 0.1 * number[40:]), whole[40:])
    for other in (SensorNoise(TIME, 6, 1), SensorNoise(TIME, 5, 2)):
        assert abs(np.mean(other.at(number, 40.0 * number) * noise.at(number, 40.0 * number))) < SIGMAS / np.sqrt(100)


def test_without_a_correlation_time_spokes_are_independent() -> None:
    number = np.arange(50_000)
    values = SensorNoise(0.0, 5, 1).at(number, np.zeros(50_000))
    assert abs(values.mean()) < SIGMAS / np.sqrt(50_000)
    assert abs(np.mean(values**2) - 1.0) < SIGMAS * np.sqrt(2.0 / 50_000)
    assert abs(np.mean(values[1:] * values[:-1])) < SIGMAS / np.sqrt(50_000)
    some = np.array([BLOCK - 1, BLOCK, 7, 40_000])
    np.testing.assert_array_equal(SensorNoise(0.0, 5, 1).at(some, np.zeros(4)), values[some])


def test_uniform_draws_are_even_and_belong_to_their_spoke() -> None:
    values = draws(np.arange(20_000), 2, 9, 4)
    assert values.min() >= 0.0 and values.max() < 1.0
    counts = np.stack([np.histogram(column, 20, (0.0, 1.0))[0] for column in values.T])
    chi_square = ((counts - 1000.0) ** 2 / 1000.0).sum(axis=1)
    assert chi_square.max() < 57.0  # chi-square of 19 degrees of freedom at a level of 1e-5
    np.testing.assert_array_equal(draws(np.array([300, 5]), 2, 9, 4), values[[300, 5]])

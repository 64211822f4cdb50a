"""Factors of CFAR detectors against closed forms for independent samples, and against drawn noise for correlated ones."""

import numpy as np
import pytest
from scipy.optimize import brentq

from radar_service.plots.false_alarms import (
    cell_averaging_factor,
    covariance,
    noise_correlation,
    ordered_statistic_factor,
)
from tests.scenes import radar

OFFSETS = np.array([-6, -5, -4, -3, 3, 4, 5, 6])
WHITE = np.array([1.0 + 0j])
SMOOTH = np.array([1.0, 0.8, 0.4, 0.1], dtype=np.complex128)


def drawn(correlation: np.ndarray, cells: np.ndarray, count: int) -> np.ndarray:
    """Power (count, N) of complex Gaussian noise of unit power in `cells`, of any correlation."""
    lag = np.abs(cells[:, None] - cells)
    root = np.linalg.cholesky(np.where(lag < len(correlation), correlation[np.minimum(lag, len(correlation) - 1)], 0.0))
    rng = np.random.default_rng(5)
    white = rng.standard_normal((count, len(cells), 2)) @ np.array([1.0, 1.0j]) / np.sqrt(2.0)
    return np.abs(white @ root.T) ** 2


@pytest.mark.parametrize("pfa", [1e-2, 1e-4, 1e-6])
def test_independent_cells_give_the_textbook_factor(pfa: float) -> None:
    """N (pfa^(-1/N) - 1), Finn and Johnson 1968; solved to 1e-6 of its logarithm."""
    n = len(OFFSETS)
    assert cell_averaging_factor(pfa, OFFSETS, WHITE) == pytest.approx(n * (pfa ** (-1.0 / n) - 1.0), rel=1e-5)


@pytest.mark.parametrize("pulses", [5, 10])
def test_averaged_pulses_keep_the_rate_over_a_mean_and_over_a_rank(pulses: int) -> None:
    """Against 200,000 draws of all pulses at 1e-2, within four standard errors of 2 %: independent cells, and cells that are as
    correlated in each pulse, of which the engine keeps the correlation of the mean field alone."""
    pfa, count = 1e-2, 200_000
    rng = np.random.default_rng(3)
    mean_field = drawn(SMOOTH, np.append(50, OFFSETS), count)
    correlated = (mean_field + rng.standard_gamma(pulses - 1, mean_field.shape)) / pulses
    white = rng.standard_gamma(pulses, mean_field.shape) / pulses
    for power, correlation in ((white, WHITE), (correlated, SMOOTH)):
        mean = cell_averaging_factor(pfa, OFFSETS, correlation, pulses) * power[:, 1:].mean(axis=1)
        rank = ordered_statistic_factor(pfa, 6, OFFSETS, correlation, pulses) * np.sort(power[:, 1:], axis=1)[:, 5]
        for level in (mean, rank):
            assert np.mean(power[:, 0] > level) == pytest.approx(pfa, rel=0.09)
    assert cell_averaging_factor(1e-4, OFFSETS, WHITE, pulses) < 0.4 * cell_averaging_factor(1e-4, OFFSETS, WHITE)


def test_an_ordered_statistic_of_independent_cells_has_rohlings_factor() -> None:
    """pfa = prod over i < k of (N - i) / (N - i + factor), Rohling 1983. 0.5 %: three deviations of the drawn levels."""
    n, rank, pfa = 32, 24, 1e-4
    i = np.arange(rank)
    exact = brentq(lambda t: float(np.log((n - i) / (n - i + t)).sum() - np.log(pfa)), 0.1, 1000.0)
    offsets = np.concatenate([np.arange(-18, -2), np.arange(3, 19)])
    assert ordered_statistic_factor(pfa, rank, offsets, WHITE) == pytest.approx(exact, rel=5e-3)


def test_correlated_cells_keep_the_false_alarm_rate() -> None:
    """Against 100,000 draws at 1e-2, whose standard error is 3 % of it: within four; the textbook's factor is beyond ten."""
    pfa, count = 1e-2, 100_000
    power = drawn(SMOOTH, np.append(0, OFFSETS), count)
    error = np.sqrt(pfa / count)

    def rate(level: np.ndarray, factor: float) -> float:
        return float(np.mean(power[:, 0] > factor * level))

    mean = power[:, 1:].mean(axis=1)
    assert abs(rate(mean, cell_averaging_factor(pfa, OFFSETS, SMOOTH)) - pfa) < 4 * error
    assert rate(mean, cell_averaging_factor(pfa, OFFSETS, WHITE)) > pfa + 10 * error
    ranked = np.sort(power[:, 1:], axis=1)[:, 5]
    far = drawn(SMOOTH, np.append(50, OFFSETS), count)  # the guard leaves no correlation with the cell under test
    assert abs(rate(ranked, ordered_statistic_factor(pfa, 6, OFFSETS, SMOOTH)) - pfa) < 0.1 * pfa
    assert abs(
        np.mean(far[:, 0] > ordered_statistic_factor(pfa, 6, OFFSETS, SMOOTH) * np.sort(far[:, 1:], 1)[:, 5]) - pfa
    ) < (4 * error + 0.005 * pfa)


def test_noise_of_a_receiver_is_correlated_as_its_band_says() -> None:
    """Samples at the bandwidth of a chirp without window are nearly independent; at 1.5 times they are not."""
    wide = radar(pulse_s=1e-5, window="none", bandwidth_hz=25e6, sample_rate_hz=25e6)
    over = radar(pulse_s=1e-5, window="hamming", bandwidth_hz=25e6, sample_rate_hz=37.5e6)
    assert noise_correlation(wide, 2)[0] == pytest.approx(1.0)
    assert abs(noise_correlation(wide, 4)[1:]).max() < 0.1 < 0.7 < abs(noise_correlation(over, 2)[1])


def test_covariance_is_hermitian() -> None:
    cells = np.array([4, 0, 9])
    matrix = covariance(cells, np.array([1.0, 0.1, 0.2, 0.3, 0.5j]))
    assert np.array_equal(matrix, matrix.conj().T) and matrix[0, 1] == 0.5j and matrix[0, 2] == 0.0

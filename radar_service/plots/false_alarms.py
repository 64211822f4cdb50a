"""The factor of a CFAR detector that gives the requested probability of false alarm in correlated receiver noise.

Samples of a profile are correlated, as the receiver's band is narrower than the sampling rate. Factors for independent samples
then give too many false alarms. Noise is complex Gaussian, so the exact probabilities follow from its correlation alone.
"""

from collections.abc import Callable

import numpy as np
import scipy.fft
from scipy.linalg import toeplitz
from scipy.optimize import brentq

from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.numerics.random import ORDER_STATISTIC, generator
from radar_service.numerics.types import Complexes, Floats, Indices
from radar_service.radar.parameters import Radar
from radar_service.receive.compression import noise_spectrum

SPECTRUM_SIZE = 2**14  # samples; a longer one changes no correlation by 1e-6
DRAWS = 2**15  # of reference cells: the factor of an ordered statistic errs by less than 0.2 %
DRAW_ROWS = 2**12
MAX_FACTOR = 1e9  # of a threshold over the level


def noise_correlation(radar: Radar, lags: int) -> Complexes:
    """Returns the correlation coefficient (L,) of receiver noise between samples n and n + lag, for lags 0 to `lags` - 1."""
    frequency = scipy.fft.fftfreq(SPECTRUM_SIZE, 1.0 / radar.sample_rate)
    spectrum = noise_spectrum(radar, frequency)
    return np.asarray(scipy.fft.ifft(spectrum)[:lags] / spectrum.mean())


def covariance(cells: Indices, correlation: Complexes) -> Complexes:
    """Returns the covariance (N, N) of noise of unit power in `cells` (N,), numbers along range.

    correlation: (L,) at lags 0 to L - 1, as `noise_correlation` gives it; 0 beyond.
    """
    span = int(np.ptp(cells)) + 1
    lags = np.zeros(max(span, len(correlation)), dtype=np.complex128)
    lags[: len(correlation)] = correlation
    matrix = toeplitz(lags[:span], np.conj(lags[:span]))
    place = cells - cells.min()
    return np.asarray(matrix[np.ix_(place, place)])


def known_level_factor(pfa: float) -> float:
    """Returns the factor on a known mean of exponential power: -ln(pfa)."""
    return float(-np.log(pfa))


@BLAS_LIMIT.held()
def cell_averaging_factor(pfa: float, offsets: Indices, correlation: Complexes) -> float:
    """Returns the factor on the mean of reference cells (N,) at these offsets from the cell under test, none of them 0.

    The cell exceeds factor x mean where a quadratic form of Gaussian variables is positive. Its probability is exact:
    prod 1 / (1 - mu_k / mu_0) over the negative eigenvalues mu_k, mu_0 being the positive one (Imhof 1961, complex case).
    The form is |z|^2 - c D, of rank one and diagonal, so mu_0 and the product are sums over D: with s = c / mu_0, mu_0 is
    sum |z|^2 / (1 + s D), and the probability mu_0 / sum(|z|^2 / (1 + s D)^2) / prod(1 + s D).
    """
    root = np.linalg.cholesky(covariance(np.append(0, offsets), correlation) + 1e-12 * np.eye(len(offsets) + 1))
    values, vectors = np.linalg.eigh(np.conj(root[1:].T) @ root[1:])
    power, diagonal = np.abs(root[0] @ vectors) ** 2, values.clip(min=0.0)

    def log_probability(log_ratio: float) -> float:
        grown = 1.0 + np.exp(log_ratio) * diagonal
        largest, slope = (power / grown).sum(), (power / grown**2).sum()
        return float(np.log(largest / slope) - np.log(grown).sum() - np.log(pfa))

    ratio = _root(log_probability)
    return float(len(offsets) * ratio * (power / (1.0 + ratio * diagonal)).sum())


@BLAS_LIMIT.held()
def ordered_statistic_factor(pfa: float, rank: int, offsets: Indices, correlation: Complexes) -> float:
    """Returns the factor on the `rank`-th weakest (from 1) of reference cells (N,) at these offsets from the cell under test.

    The cell under test is independent of them: the guard cells are to see to that. Given the level z, the cell exceeds factor x z
    with probability exp(-factor z), whose mean over drawn levels is set to `pfa`. The draws are the same each time.
    """
    root = np.linalg.cholesky(covariance(offsets, correlation) + 1e-12 * np.eye(len(offsets)))
    rng = generator(0, ORDER_STATISTIC)
    levels = []
    for _ in range(DRAWS // DRAW_ROWS):
        white = rng.standard_normal((2, DRAW_ROWS, len(offsets)))
        power = np.abs((white[0] + 1j * white[1]) @ root.T) ** 2 / 2.0
        levels.append(np.partition(power, rank - 1, axis=1)[:, rank - 1])
    level: Floats = np.concatenate(levels)

    def log_probability(log_factor: float) -> float:
        return float(np.log(np.exp(-np.exp(log_factor) * level).mean() + 1e-300) - np.log(pfa))

    return _root(log_probability)


def _root(log_probability: Callable[[float], float]) -> float:
    return float(np.exp(brentq(log_probability, np.log(1e-6), np.log(MAX_FACTOR), xtol=1e-6)))

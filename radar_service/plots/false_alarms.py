"""The factor of a CFAR detector that gives the requested probability of false alarm in correlated receiver noise.

Samples of a profile are correlated, as the receiver's band is narrower than the sampling rate. Factors for independent samples
then give too many false alarms. Noise is complex Gaussian, so the exact probabilities follow from its correlation alone.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import scipy.fft
from scipy.linalg import toeplitz
from scipy.optimize import brentq
from scipy.special import gammaincc, gammainccinv, gammaincinv
from scipy.stats import f as f_law

from radar_service.numerics import BLAS_LIMIT, ORDER_STATISTIC, Complexes, Floats, Indices, generator
from radar_service.radar import Radar
from radar_service.receive import noise_spectrum

SPECTRUM_SIZE = 2**14  # samples; a longer one changes no correlation by 1e-6
DRAWS = 2**15  # of reference cells: the factor of an ordered statistic errs by less than 0.2 %
DRAW_ROWS = 2**12
MAX_FACTOR = 1e9  # of a threshold over the level
TAILS = np.array([0.05, 0.02, 0.01, 0.005, 0.002, 0.001])  # of the cells of a region, whose quantile tells the shape
LOG_POWER = np.linspace(-10.0, 8.0, 145)  # of the laws of clutter, of unit mean
SHAPES = np.geomspace(100.0, 0.02, 16)  # of texture: as noise, to the spikiest of the sea along the waves
CLUTTER_TO_NOISE = 10.0 ** np.arange(-1.0, 3.1, 0.25)
TINY = 1e-300


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


@BLAS_LIMIT.held()
def cell_averaging_factor(pfa: float, offsets: Indices, correlation: Complexes, pulses: int = 1) -> float:
    """Returns the factor on the mean of reference cells (N,) at these offsets from the cell under test, none of them 0.

    pulses: averaged, by `receive.noise.integrate`. Cell over mean then has an F distribution, exact where cells are independent.

    Of one pulse, the cell exceeds factor x mean where a quadratic form of Gaussian variables is positive. Its probability is
    exact: prod 1 / (1 - mu_k / mu_0) over the negative eigenvalues mu_k, mu_0 being the positive one (Imhof 1961, complex case).
    """
    if pulses > 1:  # correlated cells count as fewer, by the variance of their mean
        alike = np.abs(covariance(offsets, correlation)) ** 2 / pulses
        np.fill_diagonal(alike, 1.0)
        return float(f_law.isf(pfa, 2 * pulses, 2 * pulses * len(offsets) ** 2 / alike.sum()))
    # The form is |z|^2 - c D, of rank one and diagonal, so mu_0 and the product are sums over D: with s = c / mu_0, mu_0 is
    # sum |z|^2 / (1 + s D), and the probability mu_0 / sum(|z|^2 / (1 + s D)^2) / prod(1 + s D).
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
def ordered_statistic_factor(pfa: float, rank: int, offsets: Indices, correlation: Complexes, pulses: int = 1) -> float:
    """Returns the factor on the `rank`-th weakest (from 1) of reference cells (N,) at these offsets from the cell under test.

    The cell under test is independent of them: the guard cells are to see to that. Given the level z, the cell exceeds factor x z
    with probability exp(-factor z), or the gamma tail of averaged pulses. Its mean
    over drawn levels is set to `pfa`.
    """
    root = np.linalg.cholesky(covariance(offsets, correlation) + 1e-12 * np.eye(len(offsets)))
    rng = generator(0, ORDER_STATISTIC)
    levels = []
    for _ in range(DRAWS // DRAW_ROWS):
        white = rng.standard_normal((2, DRAW_ROWS, len(offsets)))
        power = np.abs((white[0] + 1j * white[1]) @ root.T) ** 2 / 2.0
        if pulses > 1:
            power = (power + rng.standard_gamma(pulses - 1, power.shape)) / pulses
        levels.append(np.partition(power, rank - 1, axis=1)[:, rank - 1])
    level: Floats = np.concatenate(levels)

    def log_probability(log_factor: float) -> float:
        excess = np.exp(log_factor) * level
        tail = np.exp(-excess) if pulses == 1 else gammaincc(pulses, pulses * excess)
        return float(np.log(tail.mean() + 1e-300) - np.log(pfa))

    return _root(log_probability)


def _root(log_probability: Callable[[float], float]) -> float:
    return float(np.exp(brentq(log_probability, np.log(1e-6), np.log(MAX_FACTOR), xtol=1e-6)))


def effective_looks(radar: Radar, spokes: int) -> float:
    """Returns the number of independent looks in the mean of `spokes` spokes of clutter whose speckle rests as the beam passes.

    Of the sea's, which changes, there are more, so factors by this number are on the safe side.
    The field of a spoke is the sum of the clutter's over azimuth, weighted by the one-way power gain, so that two spokes have its
    autocorrelation.
    """
    span = int(np.ceil(4.0 * radar.beamwidth / radar.azimuth_step))
    gain = radar.azimuth_gain(np.arange(-4.0 * span, 4.0 * span + 1.0) * (radar.azimuth_step / 4.0))
    correlation = np.correlate(gain, gain, "full")[len(gain) - 1 :: 4] / np.sum(gain**2)
    lag = np.arange(1, spokes)
    return float(spokes**2 / (spokes + 2.0 * np.sum((spokes - lag) * correlation[lag] ** 2)))


@lru_cache(maxsize=16)
def spread_and_factor(spokes: int, looks: float, pfa: float, pulses: int = 1) -> tuple[Floats, Floats]:
    """Returns how widely laws of clutter spread (Q, C, S), rising, and their factors (C, S) on the median, exceeded with `pfa`.

    Both are natural logarithms; the first is of quantiles that TAILS exceed. Rows have CLUTTER_TO_NOISE / pulses,
    columns the SHAPES of texture: the K distribution with noise (Ward, Tough and Watts, "Sea Clutter", 2006, ch. 4). A CFAR's
    multiplier follows them (Ward, Tough and Shepherd, IET RSN 1(6), 425, 2007).
    spokes: whose mean is taken; looks: independent ones of clutter among them; pulses: averaged in a spoke.
    """
    levels = -np.log([0.5, *TAILS, pfa])
    laws = [
        [_negative_log_tail(spokes * pulses, looks, ratio / pulses, shape) for shape in SHAPES] for ratio in CLUTTER_TO_NOISE
    ]
    quantiles = np.array([[np.interp(levels, law, LOG_POWER) for law in row] for row in laws])
    spread = np.moveaxis(quantiles[..., 1:-1] - quantiles[..., :1], -1, 0)
    return np.maximum.accumulate(spread, axis=-1), quantiles[..., -1] - quantiles[..., 0]


def _negative_log_tail(noise_looks: int, looks: float, ratio: float, shape: float) -> Floats:
    """-ln of the probability that the mean over spokes exceeds exp(LOG_POWER), in units of its own mean.

    Given the texture, the covariance of spokes is noise's identity, and that of speckle times
    texture and `ratio`, clutter to noise. The sum of its exponential modes is taken for a gamma variate of its mean and variance.
    """
    odds = np.linspace(-16.0, 16.0, 129)  # the logit of the texture's probability: equal steps reach far into both tails
    share = 1.0 / (1.0 + np.exp(-odds))
    texture = np.where(odds < 0.0, gammaincinv(shape, share), gammainccinv(shape, share[::-1])) / shape  # by the small tail
    clutter = ratio * texture
    effective = _effective(clutter, noise_looks, looks)
    tail = gammaincc(effective, effective * np.exp(LOG_POWER)[:, None] * (ratio + 1.0) / (clutter + 1.0))
    weight = share * (1.0 - share)
    return np.asarray(-np.log(np.maximum(tail @ (weight / weight.sum()), TINY)))


def speckle_factor(ratio: Floats, noise_looks: int, looks: float, pfa: float) -> Floats:
    """Returns the factor (R,) on the mean power of noise and clutter without texture, exceeded with `pfa`.

    ratio: (R,) of clutter to noise; noise_looks, looks: independent ones of noise and of clutter in the mean.
    """
    effective = _effective(ratio, noise_looks, looks)
    return np.asarray(gammainccinv(effective, pfa) / effective)


def _effective(clutter: Floats, noise_looks: int, looks: float) -> Floats:
    """Squared mean over variance (R,) of a mean of these looks, by clutter to noise (R,)."""
    return np.asarray((clutter + 1.0) ** 2 / (clutter**2 / looks + (2.0 * clutter + 1.0) / noise_looks))

"""The two factors of sea clutter: speckle with the correlation of the pulse, and gamma texture made from a Gaussian.

Speckle consists of azimuth rows (`azimuth_rows`), which the beam then weights. They are independent of each other and of the
scan before. Each row depends on its own number alone, not on the order of requests.
"""

from functools import lru_cache

import numpy as np
import scipy.fft
from scipy.special import gammainccinv, gammaincinv, ndtr

from radar_service.numerics.random import SPECKLE, generator
from radar_service.numerics.types import Floats, Indices, Profiles, Singles
from radar_service.receive.noise import GaussianSpectrum

MAX_SIGMA = 6.5  # end of the table of texture; one sample in 10^10 lies beyond
STEPS = 128  # table entries per sigma: errors of at most 0.4 % of a sigma
SHAPE_RATIO = 1.05  # between shapes of the table: errors of at most 2.5 %
HERMITE_TERMS = 40  # at a shape of 0.1 further terms change the 1/e correlation by less than 1e-3


class SpeckleRows:
    """Complex Gaussian rows of unit mean power with the correlation of the compressed pulse along range."""

    def __init__(self, pulse_power: Floats, columns: int, seed: int, key: tuple[int, ...] = ()) -> None:
        """pulse_power: (S,) |spectrum|^2 of the compressed pulse in FFT order at the sampling rate of the `columns`; key: of the
        radar, Scene.random_key."""
        size = int(scipy.fft.next_fast_len(columns + 64))  # 64 bins: many main lobes, so that the ends do not correlate
        grid = np.fft.fftshift(np.fft.fftfreq(len(pulse_power)))
        power = np.interp(np.fft.fftfreq(size), grid, np.fft.fftshift(pulse_power))
        self._spectrum = GaussianSpectrum(power, 1.0)
        self._columns, self._key = columns, (seed, SPECKLE, *key)

    def make(self, scan: int, start: int, stop: int) -> Profiles:
        """Rows start to stop (exclusive) of a scan from -1 on, (stop - start, columns)."""
        rng = generator(*self._key, scan + 1, start)
        spectrum = self._spectrum.draw(stop - start, rng)
        return np.ascontiguousarray(scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)[:, : self._columns])


class TextureTable:
    """The root of gamma texture of unit mean from a standard Gaussian, for the shape nu of each range bin (N,)."""

    def __init__(self, shape: Floats, factors: Floats | None = None) -> None:
        """factors: (D,) on the shapes, by direction; None for 1 in all."""
        known = np.ones(1) if factors is None else factors
        low, high = float(shape.min() * known.min()), float(shape.max() * known.max())
        if factors is not None:  # each of both rounds to a level
            low, high = low / SHAPE_RATIO, high * SHAPE_RATIO
        levels = max(1, int(np.ceil(np.log(high / low) / np.log(SHAPE_RATIO))) + 1)
        shapes = np.geomspace(low, high, levels)
        nearest = np.searchsorted(np.sqrt(shapes[1:] * shapes[:-1]), shape)
        roots = _root_table(low, high, levels)
        self._roots = roots.ravel()
        middle = nearest * roots.shape[1] + MAX_SIGMA * STEPS + 0.5  # truncation then rounds
        self._middle = middle.astype(np.float32)
        self._turned: Singles | None = None
        if factors is not None:
            steps = np.rint(np.log(factors) / np.log(shapes[1] / shapes[0]))
            self._turned = (steps * roots.shape[1]).astype(np.float32)

    def roots(self, gaussian: Singles, direction: Indices | None = None) -> Singles:
        """Amplitude factors (K, n) of Gaussians (K, n) of the first n range bins; direction: (K,) whose factors hold."""
        entry = gaussian * np.float32(STEPS)
        entry += self._middle[: gaussian.shape[1]]
        if self._turned is not None and direction is not None:
            entry += self._turned[direction % len(self._turned), None]
        return self._roots.take(entry.astype(np.intp), mode="clip")


@lru_cache(maxsize=8)
def _root_table(minimum: float, maximum: float, levels: int) -> Singles:
    """The roots (levels, entries) of a table's shapes, kept as scenes with the same sea follow each other."""
    gaussian = np.arange(-MAX_SIGMA, MAX_SIGMA + 0.5 / STEPS, 1.0 / STEPS)
    result = np.sqrt(gamma_from_gaussian(gaussian, np.geomspace(minimum, maximum, levels)[:, None])).astype(np.float32)
    result.flags.writeable = False
    return np.asarray(result)


def gamma_from_gaussian(gaussian: Floats, shape: Floats | float) -> Floats:
    """Gamma variates of unit mean and shape nu with the quantiles of standard Gaussian ones; the arguments broadcast."""
    deviate, nu = np.broadcast_arrays(gaussian, np.asarray(shape, dtype=np.float64))
    below = deviate < 0.0  # each half by its small tail
    variate = np.empty(deviate.shape)
    variate[below] = gammaincinv(nu[below], ndtr(deviate[below]))
    variate[~below] = gammainccinv(nu[~below], ndtr(-deviate[~below]))
    return np.asarray(variate / nu)


def gaussian_correlation(shape: float, texture_correlation: float) -> float:
    """Correlation of Gaussians whose gamma textures of shape nu have the given one (Tough and Ward, J. Phys. D 32, 1999).

    The texture's is sum c_n^2 rho^n / n! over that sum at 1, c_n the Hermite coefficients of the transformation.
    """
    x, weight = np.polynomial.hermite_e.hermegauss(180)
    texture = gamma_from_gaussian(x, shape)
    terms = np.zeros(HERMITE_TERMS)
    previous, current = np.ones_like(x), x  # He_n / sqrt(n!)
    for n in range(1, HERMITE_TERMS + 1):
        terms[n - 1] = float(np.sum(weight * texture * current)) ** 2 / (2.0 * np.pi)
        previous, current = current, (x * current - np.sqrt(n) * previous) / np.sqrt(n + 1)
    rho = np.linspace(0.0, 1.0, 2001)
    resulting = np.polynomial.polynomial.polyval(rho, np.concatenate([[0.0], terms])) / terms.sum()
    return float(np.interp(texture_correlation, resulting, rho))

"""The two factors of sea clutter: speckle with the correlation of the pulse, and gamma texture made from a Gaussian.

Speckle consists of azimuth rows (`azimuth_rows`), which the beam then weights. They are independent of each other and of the
scan before. Each row depends on its own number alone, not on the order of requests.

On the map the Gaussian field has the correlation exp(-(x / along)^2 - (y / across)^2), x along the wind and y across it.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
from scipy.special import gammainccinv, gammaincinv, ndtr

from radar_service.numerics import SPECKLE, Floats, Indices, Profiles, Singles, generator
from radar_service.receive import GaussianSpectrum

NEAR, FAR = 1.0, 1.6  # row spacing over correlation length: up to the first rows sample the map, from the second on they are
# independent; between them both are blended
TAP_REACH = 1.2  # of a cell's length: the weight of the pulse is 1 % there
NEGLIGIBLE_CELL = 0.2  # of the length across the wind: a shorter cell lengthens the correlation by less than 2 %
DIRECTIONS, DISTANCES = 33, 65  # of the table of gains: neighbours differ by less than 2 %
MAX_SIGMA = 6.5  # end of the table of texture; one sample in 10^10 lies beyond
STEPS = 128  # table entries per sigma: errors of at most 0.4 % of a sigma
SHAPE_RATIO = 1.05  # between shapes of the table: errors of at most 2.5 %
HERMITE_TERMS = 40  # at a shape of 0.1 further terms change the 1/e correlation by less than 1e-3


@dataclass(frozen=True)
class TextureLaw:
    """Correlation of the Gaussian field of a sea, and the cell that averages it along range.

    along, across: distance along and across the wind over which it falls to 1/e [m].
    wind_from: direction of the wind's origin [rad].
    cell: 1/e length of the correlation that the pulse gives to a white field [m].
    """

    along: float
    across: float
    wind_from: float
    cell: float

    def form(self, bearing: Floats) -> tuple[Floats, Floats, Floats]:
        """Coefficients (a, b, c) of -log correlation = a r^2 + 2 b r s + c s^2, each (J,) [1/m^2].

        bearing: (J,) [rad]; r lies outward along it, s 90 degrees clockwise of it.
        """
        cos, sin = np.cos(bearing - self.wind_from), np.sin(bearing - self.wind_from)
        along, across = self.along**-2, self.across**-2
        mixed = sin * cos * (across - along)
        return cos**2 * along + sin**2 * across, mixed, sin**2 * along + cos**2 * across

    def beam_averaged_length(self, bearing: Floats) -> Floats:
        """1/e length along range (J,) [m] where the beam is wider than the waves are long, without the pulse.

        The field itself has 1 / sqrt(a) of `form`. Its average over a line across has sqrt(along^2 cos^2 + across^2 sin^2),
        which is Watts' law. A beam's width lies between, so the geometric mean is taken: within 12 % of both.
        """
        cos, sin = np.cos(bearing - self.wind_from), np.sin(bearing - self.wind_from)
        average = np.hypot(self.along * cos, self.across * sin)
        return np.sqrt(average / np.sqrt(self.form(bearing)[0]))

    def taps(self, step: float) -> Floats:
        """Weights (odd count,) of the pulse on neighbours `step` [m] apart; their correlation is that of `cell`."""
        if self.cell < NEGLIGIBLE_CELL * self.across:
            return np.ones(1)
        length = self.cell * np.sqrt(np.pi / 2.0)  # of exp(-pi r^2 / length^2), whose correlation has the 1/e length `cell`
        reach = int(np.ceil(TAP_REACH * length / step))
        return np.asarray(np.exp(-np.pi * (np.arange(-reach, reach + 1) * step / length) ** 2))


class TextureGains:
    """Factors on rows sampled from the map and on independent rows that give their beam-weighted sum unit variance."""

    def __init__(self, law: TextureLaw, rows_per_scan: int, step: float, columns: int, overlap: Floats) -> None:
        """step: between columns [m]; overlap: (2 M + 1,) mean of the sum of products of beam weights that lie -M to M rows
        apart, 1 in the middle."""
        self._law, self._step = law, step
        self._spacing = 2.0 * np.pi / rows_per_scan
        widest = max(law.along, law.across)
        self.columns = min(columns, int(np.ceil(FAR * widest / self._spacing / step)))  # beyond, rows are independent
        off_wind = np.linspace(0.0, np.pi, DIRECTIONS)
        node = np.linspace(0.0, self.columns, DISTANCES)
        near, far = self._at_nodes(law.wind_from + off_wind, node * step, overlap)
        between = interpolation(np.arange(self.columns, dtype=np.float64) + 0.5, node)
        self._near, self._far = (near @ between).astype(np.float32), (far @ between).astype(np.float32)
        bearing = np.arange(rows_per_scan, dtype=np.float64) * self._spacing
        turned = interpolation((bearing - law.wind_from) % np.pi, np.linspace(0.0, np.pi, DIRECTIONS))
        self._direction = turned.T.astype(np.float32)
        self._across = law.form(bearing)[2] ** -0.5 / self._spacing / step  # columns within which rows correlate

    def rows(self, start: int, stop: int, columns: int) -> tuple[Singles, Singles]:
        """Factors (stop - start, columns) on rows from the map and on independent ones; 0 and 1 in all columns beyond."""
        weights = self._direction[start:stop]
        return weights @ self._near[:, :columns], weights @ self._far[:, :columns]

    def zone(self, start: int, stop: int) -> tuple[int, int]:
        """Where rows start to stop of the map give way to independent ones, farther off: from which column to before which."""
        across = self._across[start:stop]
        margin = 2.0 * self.columns / DISTANCES + 1.0  # the table's step along range, and as much for that in direction
        first = max(0, int(NEAR * across.min() - margin))
        return min(self.columns, first), min(self.columns, int(np.ceil(FAR * across.max() + margin)))

    def _at_nodes(self, bearing: Floats, distance: Floats, overlap: Floats) -> tuple[Floats, Floats]:
        """Both factors (directions, distances) at the nodes of the table."""
        a, b, c = (part[:, None] for part in self._law.form(bearing))
        ratio = distance * self._spacing * np.sqrt(c)
        blend = 0.5 * np.pi * np.clip((ratio - NEAR) / (FAR - NEAR), 0.0, 1.0)
        taps = self._law.taps(self._step)
        pulse, reach = np.correlate(taps, taps, "full"), len(taps) - 1
        variance, lags = np.sin(blend) ** 2, len(overlap) // 2
        own = np.zeros_like(variance)  # variance of one row after the pulse
        summed = np.zeros_like(variance)  # of the rows summed by the beam
        for t, share in enumerate(pulse, start=-reach):
            r = t * self._step
            own += share * np.exp(-a * r**2)
            for m, weight in enumerate(overlap, start=-lags):
                s = m * distance * self._spacing
                summed += share * weight * np.exp(-(a * r**2 + 2.0 * b * r * s + c * s**2))
        total = np.sqrt(np.cos(blend) ** 2 * summed / own + variance)
        return np.cos(blend) / np.sqrt(own) / total, np.sin(blend) / total


def interpolation(at: Floats, node: Floats) -> Floats:
    """Weights (nodes, N) of linear interpolation between evenly spaced nodes at N positions."""
    place = (at - node[0]) / (node[1] - node[0]) if node[1] > node[0] else np.zeros_like(at)
    return np.asarray(np.maximum(1.0 - np.abs(place - np.arange(len(node))[:, None]), 0.0))


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

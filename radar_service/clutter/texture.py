"""Random fields of clutter: speckle with the correlation of the pulse, and the slow texture of the sea that modulates it.

Both are azimuth rows (`azimuth_rows`), which the beam then weights. Speckle rows are independent of each other and of the scan
before. Texture rows last from scan to scan and move with the waves. Each row depends on its own number alone, not on the order
of requests.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.fft
from scipy.special import gammainccinv, gammaincinv, ndtr

from radar_service.block_cache import BlockCache
from radar_service.clutter.azimuth_rows import BLOCK
from radar_service.random import SPECKLE, TEXTURE, generator, normals
from radar_service.receive.noise import GaussianSpectrum
from radar_service.types import Floats, Indices, Profiles, Singles

MAX_SIGMA = 6.5  # end of the table of texture; one sample in 10^10 lies beyond
STEPS = 128  # table entries per sigma: errors of at most 0.4 % of a sigma
SHAPE_RATIO = 1.05  # between shapes of the table: errors of at most 2.5 %
HERMITE_TERMS = 40  # at a shape of 0.1 further terms change the 1/e correlation by less than 1e-3


class SpeckleRows:
    """Complex Gaussian rows of unit mean power with the correlation of the compressed pulse along range."""

    def __init__(self, pulse_power: Floats, columns: int, seed: int) -> None:
        """pulse_power: (S,) |spectrum|^2 of the compressed pulse in FFT order at the sampling rate of the `columns`."""
        size = int(scipy.fft.next_fast_len(columns + 64))  # 64 bins: many main lobes, so that the ends do not correlate
        grid = np.fft.fftshift(np.fft.fftfreq(len(pulse_power)))
        power = np.interp(np.fft.fftfreq(size), grid, np.fft.fftshift(pulse_power))
        self._spectrum = GaussianSpectrum(power, 1.0)
        self._columns, self._seed = columns, seed

    def make(self, scan: int, start: int, stop: int) -> Profiles:
        """Rows start to stop (exclusive) of a scan from -1 on, (stop - start, columns)."""
        rng = generator(self._seed, SPECKLE, scan + 1, start)
        spectrum = self._spectrum.draw(stop - start, rng)
        return np.ascontiguousarray(scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)[:, : self._columns])


@dataclass(frozen=True)
class TextureMotion:
    """How texture changes.

    rows_per_scan: rows of a full circle.
    rotation_period: of the antenna [s].
    lifetime: of the texture [s].
    range_step: length of a bin [m].
    length: (rows_per_scan,) range over which each row's Gaussian decorrelates to 1/e [m].
    drift: outward motion of the waves along rows (J,) relative to the antenna, between two times (J,) [s]:
        (rows, from, to) -> (J,) [m].
    """

    rows_per_scan: int
    rotation_period: float
    lifetime: float
    range_step: float
    length: Floats
    drift: Callable[[Indices, Floats, Floats], Floats]


class TextureRows:
    """Real Gaussian rows of unit power from which the texture is made.

    Each multiple k of `lifetime` has a field of its own. At a time in between, the two neighbours are blended by cosine and
    sine, each shifted with the waves since its own time. So a row's correlation falls to 0 within two lifetimes, and any time
    can be computed without the times before.
    """

    def __init__(self, motion: TextureMotion, columns: int, seed: int) -> None:
        self.motion, self._columns, self._seed = motion, columns, seed
        self._size = int(scipy.fft.next_fast_len(columns, real=True))
        blocks = -(-motion.rows_per_scan // BLOCK)
        self._fields: BlockCache[tuple[int, int], Singles] = BlockCache(3 * blocks)  # fields k - 1, k and k + 1

    def make(self, scan: int, start: int, stop: int) -> Singles:
        """Rows start to stop (exclusive) of a scan from -1 on, (stop - start, columns), as the beam passes over them."""
        motion = self.motion
        row = np.arange(start, stop)
        time: Floats = np.maximum((scan + row / motion.rows_per_scan) * motion.rotation_period, 0.0)
        k = np.floor(time / motion.lifetime).astype(np.int64)
        total = np.empty((stop - start, self._columns), dtype=np.float32)
        blend = 0.5 * np.pi * (time / motion.lifetime - k)
        parts = []
        for later, weight in ((0, np.cos(blend)), (1, np.sin(blend))):
            since = np.asarray((k + later) * motion.lifetime, dtype=np.float64)
            moved = motion.drift(row, since, time)
            begin = np.rint(-moved / motion.range_step).astype(np.int64) % self._size
            fields = {int(each): self._field(int(each) + later, start, stop) for each in np.unique(k)}
            rows = [fields[each][j] for j, each in enumerate(k.tolist())]
            parts.append(zip(rows, begin.tolist(), weight.astype(np.float32), strict=True))
        for into, (field, first, weight), (later, after, more) in zip(total, *parts, strict=True):
            np.multiply(field[first : first + self._columns], weight, out=into)
            into += later[after : after + self._columns] * more
        return total

    def _field(self, k: int, start: int, stop: int) -> Singles:
        """Field k on rows start to stop, circular along range and repeated once, (stop - start, 2 size)."""
        return self._fields.get((k, start), lambda: self._draw(k, start, stop))

    def _draw(self, k: int, start: int, stop: int) -> Singles:
        rng = generator(self._seed, TEXTURE, k, start)
        a = np.exp(-self.motion.range_step / self.motion.length[start:stop, None])
        angle = np.asarray(2.0 * np.pi * scipy.fft.rfftfreq(self._size))
        power = (1.0 - a**2) / (1.0 - 2.0 * a * np.cos(angle) + a**2)  # of the autocorrelation a^|n|
        draws = normals(rng, stop - start, 2 * len(angle)).view(np.complex64)
        spectrum = draws * np.sqrt(self._size / 2.0 * power).astype(np.float32)
        spectrum[:, 0] *= np.float32(np.sqrt(2.0))  # here the imaginary half of the draw is unused
        if self._size % 2 == 0:
            spectrum[:, -1] *= np.float32(np.sqrt(2.0))
        return np.tile(scipy.fft.irfft(spectrum, n=self._size, axis=1), 2)


class TextureTable:
    """The root of gamma texture of unit mean from a standard Gaussian, for the shape nu of each range bin (N,)."""

    def __init__(self, shape: Floats) -> None:
        levels = max(1, int(np.ceil(np.log(shape.max() / shape.min()) / np.log(SHAPE_RATIO))) + 1)
        shapes = np.geomspace(shape.min(), shape.max(), levels)
        nearest = np.searchsorted(np.sqrt(shapes[1:] * shapes[:-1]), shape)
        gaussian = np.arange(-MAX_SIGMA, MAX_SIGMA + 0.5 / STEPS, 1.0 / STEPS)
        self._roots = np.sqrt(gamma_from_gaussian(gaussian, shapes[:, None])).astype(np.float32).ravel()
        middle = nearest * len(gaussian) + MAX_SIGMA * STEPS + 0.5  # truncation then rounds
        self._middle = middle.astype(np.float32)

    def roots(self, gaussian: Singles) -> Singles:
        """Amplitude factors (K, n) of Gaussians (K, n) of the first n range bins."""
        entry = gaussian * np.float32(STEPS)
        entry += self._middle[: gaussian.shape[1]]
        return self._roots.take(entry.astype(np.intp), mode="clip")


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

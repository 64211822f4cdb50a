"""The power of sources that stand in few cells of a row, as far as their range sidelobes stand out of the noise.

A profile is the product of the few gridded samples with shifted copies of the compressed pulse. That takes a tenth of the time of
two transforms of whole rows, and only the bins are computed in which the source may be the strongest.
"""

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import sliding_window_view

from radar_service.receive.compression import Compression
from radar_service.receive.detection import square_law
from radar_service.types import Profiles, Singles

SINGLE_PRECISION = 1e-7  # of the peak: beyond, profiles of the engine are rounding
MAX_COLUMNS = 160  # of gridded samples: wider windows are faster by transforms of whole rows


class RangeSidelobes:
    """Powers of windows of gridded rows."""

    def __init__(self, compression: Compression, noise: float) -> None:
        """noise: mean power of a sample [W]; 0 without noise."""
        pulse = scipy.fft.ifft(compression.echo_filter.astype(np.complex128))
        self._compression, self._level, size = compression, float(np.sqrt(noise)), compression.size
        each_side = np.arange(size // 2 + 1)
        magnitude = np.maximum(np.abs(pulse[each_side]), np.abs(pulse[-each_side]))
        self._envelope = np.maximum.accumulate(magnitude[::-1])[::-1]  # the maximum so many samples away, or farther
        self._least = SINGLE_PRECISION * self._envelope[0]
        circle = pulse[np.arange(-size - MAX_COLUMNS + 1, compression.bins) % size]
        self._real, self._imaginary = (_shifted(part.astype(np.float32)) for part in (circle.real, -circle.imag))

    def reach(self, total: float) -> int:
        """Samples from the source beyond which its profile stays below the noise.

        total: sum of the magnitudes of a gridded row [sqrt(W)].
        """
        above = self._envelope >= max(self._least, self._level / total)
        return int(np.count_nonzero(above))

    def power(self, window: Profiles, begin: int, first: int, stop: int) -> Singles:
        """Powers (R, stop - first) [W] of the bins from `first` to `stop` of gridded windows (R, columns).

        begin: grid column of the first sample; all samples lie within a row.
        """
        rows, columns = window.shape
        if columns > MAX_COLUMNS:
            whole = np.zeros((rows, self._compression.size), dtype=np.complex64)
            whole[:, begin : begin + columns] = window
            return square_law(self._compression.profiles(whole)[:, first:stop])
        part = slice(first - begin + self._compression.size, stop - begin + self._compression.size)
        pulses = np.concatenate([self._real[:columns, part], self._imaginary[:columns, part]])
        samples = np.empty((2 * rows, 2 * columns), dtype=np.float32)  # the real parts of profiles, then the imaginary parts
        samples[:rows, :columns], samples[:rows, columns:] = window.real, window.imag
        samples[rows:, :columns], samples[rows:, columns:] = window.imag, -window.real
        parts = samples @ pulses
        parts *= parts
        return np.asarray(np.add(parts[:rows], parts[rows:], out=parts[:rows]))


def _shifted(samples: Singles) -> Singles:
    """Row k, of MAX_COLUMNS, is shifted k samples to the right; a view."""
    return sliding_window_view(samples, len(samples) - MAX_COLUMNS + 1)[::-1]

"""The profile of one source that stands in few cells of a row, as far as its range sidelobes stand out of the noise.

The compressed pulse is long, but its sidelobes fall: a weak source is below the noise some samples away, so a short transform
is enough. Within its reach a profile is exact; beyond, each sample is below the noise.
"""

from functools import lru_cache

import numpy as np
import scipy.fft

from radar_service.receive.compression import Compression
from radar_service.types import Indices, Profiles, Singles

REACHES = (16, 64, 256)  # samples: of a chirp of 500 under Hamming, sidelobes are 40, 50 and 58 dB down there
NEGLIGIBLE = 1e-5  # of the peak: what is left of the compressed pulse beyond its length


class RangeSidelobes:
    """Cut profiles of rows that are cut too."""

    def __init__(self, compression: Compression, noise: float) -> None:
        """noise: mean power of a sample [W], above 0."""
        pulse = scipy.fft.ifft(compression.echo_filter.astype(np.complex128))
        size = len(pulse)
        self._pulse, self._middle, self._level = np.roll(pulse, size // 2), size // 2, float(np.sqrt(noise))
        magnitude, offset = np.abs(self._pulse), np.abs(np.arange(size) - size // 2)
        length = int(offset[magnitude > NEGLIGIBLE * magnitude.max()].max())
        self._reaches = np.array([*(reach for reach in REACHES if reach < length), length], dtype=np.int64)
        self._beyond = np.array([magnitude[offset > reach].max(initial=0.0) for reach in self._reaches])
        self._filter = lru_cache(maxsize=64)(self._made_filter)

    @property
    def max_reach(self) -> int:
        """The length of the compressed pulse, each side [samples]."""
        return int(self._reaches[-1])

    def reach(self, total: Singles) -> Indices:
        """Samples from the source, for rows of any shape, beyond which profiles stay below the noise.

        total: the sum of the magnitudes of each gridded row.
        """
        short = total[..., None] * self._beyond[:-1] >= self._level
        return np.asarray(self._reaches[np.count_nonzero(short, axis=-1)])

    def profiles(self, rows: Profiles, reach: int) -> Profiles:
        """Profiles (R, columns + 2 reach) of gridded rows (R, columns), from `reach` columns before the first one on."""
        columns = rows.shape[1]
        kept = min(reach + columns, self.max_reach)  # samples of the pulse each side, that any kept sample may need
        size = int(scipy.fft.next_fast_len(columns + 2 * kept))
        spectrum = scipy.fft.fft(rows, size, axis=1)
        spectrum *= self._filter(kept, size)
        profiles = scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)
        return np.asarray(profiles[:, kept - reach : kept + columns + reach])

    def _made_filter(self, kept: int, size: int) -> Profiles:
        pulse = self._pulse[self._middle - kept : self._middle + kept + 1]
        return np.asarray(scipy.fft.fft(pulse, size).astype(np.complex64))

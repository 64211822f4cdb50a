"""The profile of one weak source: its echoes, and its range sidelobes as far as they stand out of the noise.

Most sources stand in few cells of a row, and their sidelobes are below the noise some samples away. A short transform is then
enough. The compressed pulse is cut where the sum of all that is beyond stays below MAX_ERROR of the noise.
"""

from functools import lru_cache

import numpy as np
import scipy.fft

from radar_service.receive.compression import Compression
from radar_service.types import Floats, Indices, Profiles

REACHES = (8, 32, 128, 512)  # samples each side of a cell within which the compressed pulse is kept
MAX_ERROR = 0.1  # of the noise's amplitude: it changes a power of twice the noise by at most 15 %
COLUMNS = 64  # windows are widened to a multiple of so many columns, so that few filters are made


class RangeSidelobes:
    """The compressed pulse of a radar, cut at the reaches."""

    def __init__(self, compression: Compression, noise: float) -> None:
        """noise: mean power of a sample [W]; 0: no row has a reach."""
        pulse = scipy.fft.ifft(compression.echo_filter.astype(np.complex128))
        self._pulse = np.roll(pulse, len(pulse) // 2)
        self._middle, self._noise = len(pulse) // 2, noise
        beyond = np.abs(self._pulse)
        offset = np.abs(np.arange(len(pulse)) - self._middle)
        self._reaches = np.array([reach for reach in REACHES if 4 * reach < len(pulse)], dtype=np.int64)
        self._beyond = np.array([beyond[offset > reach].max(initial=0.0) for reach in self._reaches])
        self._filter = lru_cache(maxsize=64)(self._made_filter)

    def reach(self, rows: Profiles) -> Indices:
        """The samples (K,) that the sidelobes of gridded rows (K, columns) reach; -1 where they reach beyond all of REACHES."""
        total = np.abs(rows).sum(axis=1)
        enough = total[:, None] * self._beyond < MAX_ERROR * np.sqrt(self._noise)
        which = enough.argmax(axis=1)
        return np.where(enough.any(axis=1), self._reaches[which], -1)

    def profiles(self, rows: Profiles, reach: int) -> Profiles:
        """Profiles (K, columns + 2 reach or more) of gridded rows (K, columns), from `reach` columns before the first one."""
        size = int(scipy.fft.next_fast_len(rows.shape[1] + 2 * reach))
        spectrum = scipy.fft.fft(rows, size, axis=1)
        spectrum *= self._filter(reach, size)
        return np.asarray(scipy.fft.ifft(spectrum, axis=1, overwrite_x=True))

    def _made_filter(self, reach: int, size: int) -> Profiles:
        kept = self._pulse[self._middle - reach : self._middle + reach + 1]
        return np.asarray(scipy.fft.fft(kept, size).astype(np.complex64))


def energy(rows: Profiles) -> Floats:
    """The sum (K,) of the squared magnitudes of rows (K, columns)."""
    parts = np.ascontiguousarray(rows).view(np.float32)
    return np.asarray(np.einsum("ij,ij->i", parts, parts), dtype=np.float64)

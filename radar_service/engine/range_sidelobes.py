"""The power of sources that stand in few cells of a row, as far as their range sidelobes stand out of the noise.

A profile is the product of the few gridded samples with shifted copies of the compressed pulse. That takes a tenth of the time of
two transforms of whole rows, and only the bins are computed in which the source may be the strongest.
"""

from functools import cached_property

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import sliding_window_view

from radar_service.numerics import Profiles, Singles
from radar_service.receive import Compression
from radar_service.records import square_law

SINGLE_PRECISION = 1e-7  # of the peak: beyond, profiles of the engine are rounding
MAX_LOST = 2**22  # products of eclipsed columns and bins: 32 MB; with more, eclipsed sources are transformed
MAX_COLUMNS = 160  # of gridded samples: wider windows are faster by transforms of whole rows


class RangeSidelobes:
    """Powers of windows of gridded rows."""

    def __init__(self, compression: Compression, noise: float) -> None:
        """noise: mean power of a sample [W]; 0 without noise."""
        pulse = scipy.fft.ifft(compression.echo_filter.astype(np.complex128))
        self._compression, self._level, size = compression, float(np.sqrt(noise)), compression.size
        eclipsing = compression.eclipsing_filter
        self._eclipsed = 0 if eclipsing is None else eclipsing.near - eclipsing.before  # columns
        self._eclipsing_bins = 0 if eclipsing is None else min(eclipsing.bins, compression.bins)
        each_side = np.arange(size // 2 + 1)
        magnitude = np.maximum(np.abs(pulse[each_side]), np.abs(pulse[-each_side]))
        self._envelope = np.maximum.accumulate(magnitude[::-1])[::-1]  # the maximum so many samples away, or farther
        self._least = SINGLE_PRECISION * self._envelope[0]
        circle = pulse[np.arange(-size - MAX_COLUMNS + 1, compression.bins) % size].astype(np.complex64)
        self._pulse = [_shifted(plane) for plane in _planes(circle)]

    def bins(self, total: float, begin: int, columns: int) -> tuple[int, int]:
        """First bin and the one after the last, outside of which a source stays below the noise.

        total: sum of the magnitudes of its gridded row [sqrt(W)], in `columns` from `begin` on.
        """
        reach = int(np.count_nonzero(self._envelope >= max(self._least, self._level / total)))
        first, stop = max(0, begin - reach), min(self._compression.bins, begin + columns + reach)
        return (0, max(stop, self._eclipsing_bins)) if begin < self._eclipsed else (first, stop)

    def power(self, window: Profiles, begin: int, first: int, stop: int) -> Singles:
        """Powers (R, stop - first) [W] of the bins from `first` to `stop` of gridded windows (R, columns).

        begin: grid column of the first sample; all samples lie within a row.
        """
        rows, columns = window.shape
        eclipsed = max(0, min(columns, self._eclipsed - begin))
        if columns > MAX_COLUMNS or (eclipsed and self._eclipsed * self._eclipsing_bins > MAX_LOST):
            row = np.zeros((rows, self._compression.size), dtype=np.complex64)
            row[:, begin : begin + columns] = window
            return square_law(self._compression.profiles(row)[:, first:stop])
        part = slice(first - begin + self._compression.size, stop - begin + self._compression.size)
        parts = _products(window, [plane[:columns, part] for plane in self._pulse])
        end = min(stop, self._eclipsing_bins)
        if eclipsed and first < end:
            lost = [plane[begin : begin + eclipsed, first:end] for plane in self._lost]
            parts[:, : end - first] -= _products(window[:, :eclipsed], lost)
        parts *= parts
        return np.asarray(np.add(parts[:rows], parts[rows:], out=parts[:rows]))

    @cached_property
    def _lost(self) -> list[Singles]:
        """What eclipsing takes from the profile of a unit sample in each eclipsed column (columns, bins), as `_planes`."""
        eclipsing = self._compression.eclipsing_filter
        assert eclipsing is not None
        lost = np.zeros((self._eclipsed, self._eclipsing_bins), dtype=np.complex64)
        for start in range(0, self._eclipsed, MAX_COLUMNS):
            part = lost[start : start + MAX_COLUMNS]
            samples = np.eye(len(part), self._compression.size, start, dtype=np.complex64)
            part[:] = eclipsing.lost(samples)[:, : self._eclipsing_bins]
        return _planes(lost)


def _planes(profiles: Profiles) -> list[Singles]:
    """The real parts, and the imaginary parts with the other sign."""
    return [np.ascontiguousarray(profiles.real), np.negative(profiles.imag)]


def _products(window: Profiles, planes: list[Singles]) -> Singles:
    """Products of samples (R, columns) with profiles (columns, bins), given as `_planes`: real parts (R, bins), and below them
    the imaginary parts."""
    rows, columns = window.shape
    samples = np.empty((2 * rows, 2 * columns), dtype=np.float32)
    samples[:rows, :columns], samples[:rows, columns:] = window.real, window.imag
    samples[rows:, :columns], samples[rows:, columns:] = window.imag, -window.real
    return np.asarray(samples @ np.concatenate(planes))


def _shifted(samples: Singles) -> Singles:
    """Row k, of MAX_COLUMNS, is shifted k samples to the right; a view."""
    return sliding_window_view(samples, len(samples) - MAX_COLUMNS + 1)[::-1]

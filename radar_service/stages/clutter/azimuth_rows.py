"""Azimuth rows: fields over bearing and range, computed in blocks and kept while the beam passes over them."""

from collections.abc import Callable
from functools import partial
from threading import Lock
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from radar_service.numerics import STEADY, Flags, Floats, Gain, Indices, ResultCache, Revision, Singles

Rows = NDArray[Any]
MakeRows = Callable[[int, int, int], Rows]

BLOCK = 32  # rows computed together, so that a random generator is set up for many thousands of draws
CHUNK = 128  # rows of one array, so that few spans need two; whole blocks
ANGLES = 2**16  # on a circle, at which beams are compared
WEAKEST, ALIAS = 1e-3, 1e-2  # of a beam: where its weights end; by how much rows too few make the correlation vary
SPARE = 1  # chunks kept beyond those of a span, for slower threads


class BlockRows:
    """Rows in one array, computed block by block when they are asked for. Threads wait for each other."""

    def __init__(self, count: int, make: Callable[[int, int], Rows], block: int = BLOCK) -> None:
        """make: computes rows start to stop (exclusive), (stop - start, N); block: rows computed together."""
        self._count, self._make, self._block = count, make, block
        self._rows: Rows | None = None
        self._ready: Flags = np.zeros(-(-count // block), dtype=np.bool_)
        self._lock = Lock()

    def known(self, low: int, high: int) -> Rows:
        """All rows (count, N), of which low to high (exclusive), at least one, are computed."""
        with self._lock:
            for block in range(low // self._block, -(-high // self._block)):
                if not self._ready[block]:
                    self._compute(block)
            assert self._rows is not None
            return self._rows

    def _compute(self, block: int) -> None:
        start, stop = block * self._block, min((block + 1) * self._block, self._count)
        rows = self._make(start, stop)
        if self._rows is None:
            self._rows = np.empty((self._count, *rows.shape[1:]), rows.dtype)
        self._rows[start:stop] = rows
        self._ready[block] = True


class AzimuthRowCache:
    """Cache of azimuth rows. Row 0 of each scan points north; numbering continues across scans.

    make(scan, start, stop) returns rows start to stop (exclusive) of a scan as (stop - start, N), and depends on its arguments
    alone. Scan -1 occurs too: at the start the beam covers rows before north. Safe to call from several threads.
    """

    def __init__(self, rows_per_scan: int, make: MakeRows, block: int = BLOCK, revision: Revision = STEADY) -> None:
        """block: rows computed together, a divisor of CHUNK; revision: of what `make` depends on besides its arguments."""
        self.rows_per_scan, self._make, self._block = rows_per_scan, make, block
        self._per_scan = -(-rows_per_scan // CHUNK)  # chunks
        self._chunks: ResultCache[int, BlockRows] = ResultCache(1 + SPARE, revision)

    def span(self, first: int, stop: int) -> Rows:
        """Rows first to stop (exclusive), (stop - first, N), read only."""
        numbers = range(self._chunk_of(first), self._chunk_of(stop - 1) + 1)
        self._chunks.grow(len(numbers) + SPARE)
        parts = [self._part(number, first, stop) for number in numbers]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _part(self, number: int, first: int, stop: int) -> Rows:
        """Rows first to stop, as far as they lie in the chunk of this number."""
        scan, start = divmod(number, self._per_scan)
        start *= CHUNK
        before = scan * self.rows_per_scan + start  # rows from the start of the simulation to this chunk
        length = min(CHUNK, self.rows_per_scan - start)
        low, high = max(first - before, 0), min(stop - before, length)
        make = partial(self._made, scan, start)
        return self._chunks.get(number, lambda: BlockRows(length, make, self._block)).known(low, high)[low:high]

    def _made(self, scan: int, chunk: int, start: int, stop: int) -> Rows:
        """Rows start to stop (exclusive) of the chunk that begins at row `chunk` of a scan."""
        return self._make(scan, chunk + start, chunk + stop)

    def _chunk_of(self, row: int) -> int:
        return row // self.rows_per_scan * self._per_scan + row % self.rows_per_scan // CHUNK


class BeamWeights:
    """Weights of the beam on azimuth rows, for each azimuth of a scan; computed once per index."""

    def __init__(self, azimuths: int, rows_per_scan: int, gain: Gain, extent: float, order: int) -> None:
        """gain: weight at an offset from boresight [rad], 0 beyond `extent` [rad]; order: 1 normalizes the sum of each
        azimuth's weights to 1, 2 the sum of their squares."""
        self._azimuths, self._rows_per_scan = azimuths, rows_per_scan
        self._gain, self._extent, self._order = gain, extent, order
        self._weights: ResultCache[tuple[int, int], tuple[int, int, Singles]] = ResultCache(azimuths)

    def at(self, number: Indices) -> tuple[int, int, Singles]:
        """First row, row after the last, and weights (K, J) for consecutive azimuths (K,) numbered from the start."""
        scan, index = divmod(int(number[0]), self._azimuths)
        first, stop, weights = self._weights.get((index, len(number)), lambda: self._computed(index, len(number)))
        return first + scan * self._rows_per_scan, stop + scan * self._rows_per_scan, weights

    def _computed(self, index: int, count: int) -> tuple[int, int, Singles]:
        azimuth = np.arange(index, index + count, dtype=np.float64) * (2.0 * np.pi / self._azimuths)
        first, stop, weight = beam_weights(azimuth, self._rows_per_scan, self._gain, self._extent)
        weight /= np.sum(weight**self._order, axis=1)[:, None] ** (1.0 / self._order)
        return first, stop, weight.astype(np.float32)


def weight_rows(weights: Singles, rows: Rows) -> Singles:
    """Rows (J, N), real or complex, summed with weights (K, J): (K, N), or (K, 2 N) with interleaved real and imaginary parts."""
    return weights @ rows.view(np.float32)


def changing_beam(gain: Gain, extent: float, rotation_period: float, life: float) -> tuple[Gain, float, int]:
    """Returns a gain, its extent [rad] and the rows per scan with which rows at rest stand for rows that change.

    Over azimuth their weighted sum has the correlation of rows weighted by `gain` [offset in rad] within `extent` [rad], times
    exp(-(t / life)^2) for the time t in which the antenna turns so far. rotation_period, life: [s].
    """
    offset: Floats = np.arange(-0.5, 0.5, 1.0 / ANGLES) * (2.0 * np.pi)
    seen = scipy.fft.rfft(np.where(np.abs(offset) <= extent, gain(offset), 0.0))
    correlation: Floats = scipy.fft.irfft(np.abs(seen) ** 2)
    correlation *= np.exp(-((np.fft.ifftshift(offset) * (rotation_period / (2.0 * np.pi * life))) ** 2))
    root: Floats = np.fft.fftshift(scipy.fft.irfft(np.sqrt(np.maximum(scipy.fft.rfft(correlation).real, 0.0))))
    alias = np.abs(scipy.fft.rfft(root**2))  # of rows so many per scan
    reach = np.abs(offset[np.abs(root) > WEAKEST * root.max()]).max()
    rows = int(np.flatnonzero(alias > ALIAS * alias[0])[-1]) + 1
    return partial(_interpolated, offset, root), float(reach), rows


def _interpolated(known: Floats, values: Floats, offset: Floats) -> Floats:
    return np.asarray(np.interp(offset, known, values))


def beam_weights(azimuth: Floats, rows_per_scan: int, gain: Gain, extent: float) -> tuple[int, int, Floats]:
    """First row, row after the last, and weights (K, J) of a beam at each azimuth (K,) on the rows of a scan.

    azimuth: rising, continuing across scans [rad]; gain: weight at an offset [rad]; extent: beyond it weights are 0, at most
    half a turn [rad]. The weights are not normalized.
    """
    step = 2.0 * np.pi / rows_per_scan
    extent = min(extent, np.pi)
    first = int(np.ceil((azimuth[0] - extent) / step - 1e-9))
    stop = int(np.floor((azimuth[-1] + extent) / step + 1e-9)) + 1
    offset = azimuth[:, None] - np.arange(first, stop) * step
    weight = np.where(np.abs(offset) <= extent + 1e-9, gain(offset), 0.0)
    return first, stop, weight

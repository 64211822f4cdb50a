"""Rows of a turn: what depends on the bearing, made once in blocks and kept while the beam sweeps over it."""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pattern = Callable[[Floats], Floats]  # offset from boresight [rad] to gain relative to it
Weights = NDArray[np.float32]
Rows = NDArray[np.generic]
Make = Callable[[int, int, int], Rows]

BLOCK = 32  # rows made together, so that a random generator is set up for many thousands of draws
CHUNK = 128  # rows that lie in one array, so that few spans need rows of two; whole blocks
SPARE = 1  # chunks kept beyond those of a span, for threads that lag behind


@dataclass(frozen=True)
class Chunk:
    """Rows (CHUNK, N), fewer at the end of a turn, and which of them begin blocks that are made already."""

    rows: Rows
    made: set[int]


class AzimuthRowCache:
    """Rows that divide every revolution evenly, row 0 looking north, numbered on and on from revolution to revolution.

    make(scan, start, stop) gives rows start to stop (exclusive) of a scan, as (stop - start, N); the scan before the first,
    -1, is asked for too, as the beam reaches back over north. What it gives must depend on its arguments alone. Threads
    may ask for rows; each block is made by one of them while the others wait.
    """

    def __init__(self, turn: int, make: Make) -> None:
        self.turn, self._make, self._lock = turn, make, Lock()
        self._chunks = -(-turn // CHUNK)  # per turn
        self._kept: dict[int, Chunk] = {}  # by number, the one used last at the end

    def span(self, first: int, stop: int) -> Rows:
        """Rows first to stop (exclusive), (stop - first, N); whoever asks must not change them."""
        numbers = range(self._chunk_of(first), self._chunk_of(stop - 1) + 1)
        with self._lock:
            parts = [self._part(number, first, stop) for number in numbers]
            while len(self._kept) > len(numbers) + SPARE:
                del self._kept[next(iter(self._kept))]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def _part(self, number: int, first: int, stop: int) -> Rows:
        """Rows first to stop, as far as they lie in the chunk of this number."""
        scan, start = divmod(number, self._chunks)
        start *= CHUNK
        before = scan * self.turn + start  # rows before the chunk since the start
        length = min(CHUNK, self.turn - start)
        low, high = max(first - before, 0), min(stop - before, length)
        chunk = self._kept.pop(number, None)
        for block in range(low // BLOCK * BLOCK, high, BLOCK):
            if chunk is None or block not in chunk.made:
                rows = self._make(scan, start + block, start + min(block + BLOCK, length))
                chunk = chunk or Chunk(np.empty((length, *rows.shape[1:]), rows.dtype), set())
                chunk.rows[block : block + len(rows)] = rows
                chunk.made.add(block)
        assert chunk is not None  # no part is empty
        self._kept[number] = chunk
        return chunk.rows[low:high]

    def _chunk_of(self, row: int) -> int:
        return row // self.turn * self._chunks + row % self.turn // CHUNK


class StaticAzimuthRows:
    """Rows that are the same in every revolution, all known: what `AzimuthRowCache` is to those that are not."""

    def __init__(self, rows: Rows) -> None:
        """rows: (turn, N), row 0 looking north."""
        self.turn, self._twice = len(rows), np.concatenate([rows, rows])

    def span(self, first: int, stop: int) -> Rows:
        """Rows first to stop (exclusive), (stop - first, N); whoever asks must not change them."""
        begin = first % self.turn
        end = begin + stop - first
        return self._twice[begin:end] if end <= len(self._twice) else self._twice.take(range(begin, end), 0, mode="wrap")


class BeamWeights:
    """Which rows of the turn the beam sees from each azimuth of the scan, and how strongly; worked out once per index."""

    def __init__(self, azimuths: int, turn: int, pattern: Pattern, reach: float, order: int) -> None:
        """pattern: weight at an offset from boresight [rad], 0 beyond `reach` [rad]; order: 1 makes the weights of each
        azimuth sum to 1, 2 their squares."""
        self._azimuths, self._turn, self._pattern, self._reach, self._order = azimuths, turn, pattern, reach, order
        self._known: dict[tuple[int, int], tuple[int, int, Weights]] = {}

    def seen(self, number: NDArray[np.int64]) -> tuple[int, int, Weights]:
        """First row, row after the last, weights (K, J) for consecutive azimuths (K,) of a scan, counted from the start."""
        scan, index = divmod(int(number[0]), self._azimuths)
        key = (index, len(number))
        if key not in self._known:
            azimuth = np.arange(index, index + len(number), dtype=np.float64) * (2.0 * np.pi / self._azimuths)
            first, stop, weight = beam_weights(azimuth, self._turn, self._pattern, self._reach)
            weight /= np.sum(weight**self._order, axis=1)[:, None] ** (1.0 / self._order)
            self._known[key] = first, stop, weight.astype(np.float32)
        first, stop, weights = self._known[key]
        return first + scan * self._turn, stop + scan * self._turn, weights


def weight_rows(weights: Weights, rows: NDArray[np.generic]) -> Weights:
    """Rows (J, N), real or complex, summed with weights (K, J): (K, N), or (K, 2 N) with real and imaginary parts by turns."""
    summed: Weights = weights @ rows.view(np.float32)
    return summed


def beam_weights(azimuth: Floats, turn: int, pattern: Pattern, reach: float) -> tuple[int, int, Floats]:
    """First row, row after the last, and weights (K, J) with which a beam at each azimuth (K,) sees the rows of a turn.

    azimuth: rising, counted on from revolution to revolution [rad]; pattern: weight at an offset; nothing beyond `reach`
    [rad], at most half a turn. The weights are the pattern's own: whoever needs a sum of 1, or of squares, divides.
    """
    step = 2.0 * np.pi / turn
    reach = min(reach, np.pi)
    first = int(np.ceil((azimuth[0] - reach) / step - 1e-9))
    stop = int(np.floor((azimuth[-1] + reach) / step + 1e-9)) + 1
    offset = azimuth[:, None] - np.arange(first, stop) * step
    weight = np.where(np.abs(offset) <= reach + 1e-9, pattern(offset), 0.0)
    return first, stop, weight

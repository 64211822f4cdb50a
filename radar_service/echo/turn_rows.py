"""Rows of a turn: what depends on the bearing, made once in blocks and kept while the beam sweeps over it."""

from collections.abc import Callable
from threading import Lock

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Pattern = Callable[[Floats], Floats]  # offset from boresight [rad] to gain relative to it
Weights = NDArray[np.float32]
Make = Callable[[int, int, int], NDArray[np.generic]]

BLOCK = 32  # rows made together, so that a random generator is set up for many thousands of draws
TOGETHER = 2  # blocks that are joined to windows together, so that rows are not joined anew for every call
WINDOWS = 2  # kept, for threads that lag behind


class TurnRows:
    """Rows that divide every revolution evenly, row 0 looking north, numbered on and on from revolution to revolution.

    make(scan, start, stop) gives rows start to stop (exclusive) of a scan, as (stop - start, N); the scan before the first,
    -1, is asked for too, as the beam reaches back over north. What it gives must depend on its arguments alone. Threads
    may ask for rows; each block is made by one of them while the others wait.
    """

    def __init__(self, turn: int, make: Make) -> None:
        self.turn, self._make, self._lock = turn, make, Lock()
        self._blocks = -(-turn // BLOCK)  # per turn
        self._kept: dict[int, NDArray[np.generic]] = {}
        self._windows: dict[tuple[int, int], NDArray[np.generic]] = {}

    def span(self, first: int, stop: int) -> NDArray[np.generic]:
        """Rows first to stop (exclusive), (stop - first, N)."""
        begin, end = self._block_of(first), self._block_of(stop - 1) + 1
        begin, end = max(begin // TOGETHER * TOGETHER, -self._blocks), -(-end // TOGETHER) * TOGETHER
        with self._lock:
            window = self._window(begin, end)
        skipped = first - (begin // self._blocks * self.turn + begin % self._blocks * BLOCK)
        return window[skipped : skipped + stop - first]

    def _window(self, begin: int, end: int) -> NDArray[np.generic]:
        """Blocks begin to end (exclusive) as one array."""
        if (begin, end) not in self._windows:
            while len(self._windows) >= WINDOWS:
                del self._windows[next(iter(self._windows))]
            blocks = [self._block(b, end - begin + TOGETHER) for b in range(begin, end)]
            self._windows[begin, end] = np.concatenate(blocks)
        return self._windows[begin, end]

    def _block(self, b: int, room: int) -> NDArray[np.generic]:
        """Block b, kept among at most `room`, the oldest of which goes first."""
        if b not in self._kept:
            while len(self._kept) >= room:
                del self._kept[next(iter(self._kept))]
            scan, start = b // self._blocks, b % self._blocks * BLOCK
            self._kept[b] = self._make(scan, start, min(start + BLOCK, self.turn))
        return self._kept[b]

    def _block_of(self, row: int) -> int:
        return row // self.turn * self._blocks + row % self.turn // BLOCK


class BeamRows:
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


def under_beam(weights: Weights, rows: NDArray[np.generic]) -> Weights:
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

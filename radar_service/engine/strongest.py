"""The strongest source of each cell, found source by source.

Floats that are not negative are ordered as their bits are. So a cell is one integer: the bits of the power, with the number of
the source in place of the last ones. The maximum of two such integers is that of the stronger source.
"""

import numpy as np
from numpy.typing import NDArray

from radar_service.clutter.clutter import ClutterRows
from radar_service.engine.source_numbers import RAIN, SEA
from radar_service.receive.detection import square_law
from radar_service.types import Indices, Singles

Labels = NDArray[np.uint32]
Cells = NDArray[np.int32]
EVERY = slice(None)


class Strongest:
    """The strongest source so far in the cells (K, bins) of some azimuths.

    Powers are compared to a part in 2**(23 - n), n being the bits of the highest source number: 0.001 dB with 4000 bodies.
    """

    def __init__(self, azimuths: int, bins: int, noise: float, highest: int) -> None:
        """noise: its mean power [W]; highest: source number."""
        self._mask = np.int32((1 << highest.bit_length()) - 1)
        self._noise = self._marked(0, np.full(1, noise, dtype=np.float32))[0]
        self._cells: Cells = np.full((azimuths, bins), self._noise, dtype=np.int32)

    def part(self, start: int, count: int) -> "Strongest":
        """A copy of the azimuths from `start` on, as many as `count`."""
        part = Strongest.__new__(Strongest)
        part._mask, part._noise = self._mask, self._noise
        part._cells = self._cells[start : start + count].copy()
        return part

    @property
    def labels(self) -> Labels:
        """The number (K, bins) of the strongest source; 0 also where there is no power."""
        numbers = self._cells & self._mask
        if not self._noise:
            numbers *= self._cells > self._mask
        return numbers.view(np.uint32)

    def clear(self, rows: Indices) -> None:
        """Leaves noise alone in rows (R,)."""
        self._cells[rows] = self._noise

    def offer(self, number: int, power: Singles, rows: Indices | slice = EVERY, first: int = 0) -> None:
        """A source's power (R, columns) [W] in rows (R,), from bin `first` on. The array of powers is used up."""
        columns, offered = slice(first, first + power.shape[1]), self._marked(number, power)
        if isinstance(rows, slice):
            cells = self._cells[rows, columns]
            np.maximum(cells, offered, out=cells)
        else:
            self._cells[rows, columns] = np.maximum(self._cells[rows, columns], offered)

    def offer_clutter(self, clutter: ClutterRows) -> None:
        """The sea and the rain of the same azimuths."""
        power = square_law(clutter.field)
        if len(clutter.rain):
            share = clutter.rain_share
            self.offer(RAIN, power * share)
            power *= np.float32(1.0) - share
        self.offer(SEA, power)

    def _marked(self, number: int, power: Singles) -> Cells:
        """Powers with the number of their source in their last bits, in place."""
        cells = power.view(np.int32)
        cells &= ~self._mask
        cells |= np.int32(number)
        return cells

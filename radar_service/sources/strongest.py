"""The strongest source of each cell, found source by source.

Floats that are not negative are ordered as their bits are. So a cell is one integer: the bits of the power, with the number of
the source in place of the last ones. The maximum of two such integers is that of the stronger source.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from radar_service.clutter.clutter import ClutterRows
from radar_service.numerics.types import Indices, Singles
from radar_service.receive.detection import square_law
from radar_service.records.cell_sources import Labels
from radar_service.sources.numbers import RAIN, SEA

Cells = NDArray[np.int32]
EVERY = slice(None)


@dataclass
class Strongest:
    """The strongest source so far in the cells of some azimuths.

    Powers are compared to a part in 2**(23 - n), n being the bits of the highest source number: 0.002 dB with 3800 bodies.

    cells: (K, bins) powers, each with the number of its source in its last bits.
    mask: these bits.
    noise: what a cell with noise alone is.
    """

    cells: Cells
    mask: np.int32
    noise: np.int32

    def part(self, start: int, count: int) -> "Strongest":
        """A copy of the azimuths from `start` on, as many as `count`."""
        return replace(self, cells=self.cells[start : start + count].copy())

    @property
    def labels(self) -> Labels:
        """The number (K, bins) of the strongest source; 0 also where there is no power."""
        numbers = self.cells & self.mask
        if not self.noise:
            numbers *= self.cells > self.mask
        return numbers.view(np.uint32)

    def clear(self, rows: Indices) -> None:
        """Leaves noise alone in rows (R,)."""
        self.cells[rows] = self.noise

    def offer(self, number: int, power: Singles, rows: Indices | slice = EVERY, first: int = 0) -> None:
        """A source's power (R, columns) [W] in rows (R,), from bin `first` on. The array of powers is used up."""
        columns, offered = slice(first, first + power.shape[1]), self._marked(number, power)
        if isinstance(rows, slice):
            cells = self.cells[rows, columns]
            np.maximum(cells, offered, out=cells)
        else:
            self.cells[rows, columns] = np.maximum(self.cells[rows, columns], offered)

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
        cells &= ~self.mask
        cells |= np.int32(number)
        return cells


def unlabelled(azimuths: int, bins: int, noise: float, highest: int) -> Strongest:
    """Cells with noise of this mean power [W] alone, for source numbers up to `highest`."""
    mask = np.int32((1 << highest.bit_length()) - 1)
    alone = np.float32(noise).view(np.int32) & ~mask
    return Strongest(np.full((azimuths, bins), alone, dtype=np.int32), mask, alone)

"""The strongest source of each cell, found source by source."""

import numpy as np
from numpy.typing import NDArray

from radar_service.clutter.clutter import ClutterRows
from radar_service.engine.source_numbers import RAIN, SEA
from radar_service.receive.detection import square_law
from radar_service.types import Indices, Singles

Labels = NDArray[np.uint32]
EVERY = slice(None)


class Strongest:
    """The strongest source so far in the cells of some azimuths. label: (K, bins) source numbers; power: (K, bins) [W]."""

    def __init__(self, azimuths: int, bins: int, noise: float) -> None:
        """noise: its mean power [W]."""
        self._noise = noise
        self.label: Labels = np.zeros((azimuths, bins), dtype=np.uint32)
        self.power: Singles = np.full((azimuths, bins), noise, dtype=np.float32)

    def part(self, start: int, count: int) -> "Strongest":
        """A copy of the azimuths from `start` on, as many as `count`."""
        part = Strongest(0, 0, self._noise)
        part.label, part.power = self.label[start : start + count].copy(), self.power[start : start + count].copy()
        return part

    def clear(self, rows: Indices) -> None:
        """Leaves noise alone in rows (R,)."""
        self.label[rows], self.power[rows] = 0, self._noise

    def offer(self, number: int, power: Singles, rows: Indices | slice = EVERY, first: int = 0) -> None:
        """A source's power (R, columns) [W] in rows (R,), from bin `first` on; bins outside of the profile are ignored."""
        begin, end = max(0, -first), min(power.shape[1], self.label.shape[1] - first)
        if end <= begin:
            return
        columns = slice(first + begin, first + end)
        if isinstance(rows, np.ndarray) and len(rows) and rows[-1] - rows[0] == len(rows) - 1:
            rows = slice(int(rows[0]), int(rows[-1]) + 1)
        offered, power_so_far = power[:, begin:end], self.power[rows, columns]
        above = offered > power_so_far
        if not above.any():
            return
        label = self.label[rows, columns]
        label[above] = number
        self.label[rows, columns], self.power[rows, columns] = label, np.maximum(offered, power_so_far)

    def offer_clutter(self, clutter: ClutterRows) -> None:
        """The sea and the rain of the same azimuths."""
        power = square_law(clutter.field)
        if len(clutter.rain):
            share = clutter.rain_share
            self.offer(RAIN, power * share)
            power *= np.float32(1.0) - share
        self.offer(SEA, power)

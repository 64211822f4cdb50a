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
        self.label: Labels = np.zeros((azimuths, bins), dtype=np.uint32)
        self.power: Singles = np.full((azimuths, bins), noise, dtype=np.float32)

    def take(self, rows: Indices, other: "Strongest", its: Indices) -> None:
        """Puts rows `its` (R,) of another in place of rows (R,) of this one."""
        self.label[rows], self.power[rows] = other.label[its], other.power[its]

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

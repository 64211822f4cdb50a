"""Spokes of another radar as an xHD has them: 1440 a revolution from the bow, each once and rising, at most 705 samples.

No peak is lost. An echo moves by half of our spoke at most, rounded to a spoke of the xHD, and by half of its sample.
"""

import math

import numpy as np

from radar_service.display.video import Bytes
from radar_service.numerics.types import Floats
from radar_service.ports.garmin_xhd.datagrams import MAX_SAMPLES, SPOKES
from radar_service.service.spokes import Epoch, SpokeBatch

WEAKEST, STRONGEST = 39, 254  # of what shows: less are colours of trails for readers, more is an approaching target
LEVELS = np.append(0, np.rint(WEAKEST + np.arange(255) * ((STRONGEST - WEAKEST) / 254))).astype(np.uint8)  # by byte of video


class Samples:
    """How the cells of an epoch become samples that end at the range shown, in whole metres: a cell counts where its middle is.

    metres: that range.
    """

    def __init__(self, epoch: Epoch) -> None:
        to, range_max = epoch.layout(None), epoch.info.radar.range_max
        self.metres = round(min(epoch.range or range_max, range_max, to.range))
        count = min(MAX_SAMPLES, max(1, math.floor(self.metres / to.step + 1e-9)))
        edges = np.arange(count + 1) * (self.metres / count)
        cells = np.ceil((edges - to.first) / to.step - 1e-9).astype(np.intp)
        self._layout, self._starts, self._end = to, np.clip(cells[:-1], 0, to.bins - 1), max(1, int(cells[-1]))

    def of(self, batch: SpokeBatch) -> Bytes:
        """Returns the samples of a batch (K, samples), as readers take them."""
        cells = batch.video_bytes(self._layout)[:, : self._end]
        levels: Bytes = LEVELS[np.maximum.reduceat(cells, self._starts, axis=1)]
        return levels


class BowSpokes:
    """Joins or repeats spokes so that 1440 come in a revolution. lost: those left out, as their number or angle does not rise."""

    def __init__(self, azimuths: int) -> None:
        """azimuths: of the radar in a revolution."""
        self.lost, self._azimuths, self._number = 0, azimuths, -1
        self._width = SPOKES / azimuths  # of a spoke of the radar
        self._half = 0.5 * max(self._width, 1.0)
        self._restart()

    def _restart(self) -> None:
        self._angle = math.nan  # of the last spoke, in spokes of the xHD, counted on from turn to turn
        self._next, self._open = 0, dict[int, Bytes]()  # the next one to be ended, and what is known of those from it on
        self._last: Bytes | None = None

    def ended(self, batch: SpokeBatch, rows: Bytes) -> list[tuple[int, Bytes]]:
        """Returns the spokes that are complete with a batch: their numbers from the bow, and samples. rows: of the batch."""
        if batch.block.first <= self._number:
            self.lost += len(rows)
            return []
        if batch.block.first - self._number > self._azimuths // 2:  # after standby: which way round is not known
            self._restart()
        self._number = batch.block.first + len(rows) - 1
        return [spoke for angle, row in zip(_from_bow(batch), rows, strict=True) for spoke in self._taken(float(angle), row)]

    def _taken(self, angle: float, row: Bytes) -> list[tuple[int, Bytes]]:
        step = 0.0
        if not math.isnan(self._angle):
            step = (angle - self._angle + SPOKES / 2) % SPOKES - SPOKES / 2
            if step <= 0.0:
                self.lost += 1
                return []
            angle = self._angle + step
        low, high = math.ceil(angle - self._half), math.ceil(angle + self._half)
        result = self._ended_before(low, step <= 2.0 * self._half + 1.0) if step else []
        self._angle, self._next, self._last = angle, low, row
        for number in range(low, high):
            self._open[number] = np.maximum(self._open[number], row) if number in self._open else row
        return result

    def _ended_before(self, low: int, fills: bool) -> list[tuple[int, Bytes]]:
        """Ends the spokes before a number. fills: whether those that nothing fell into repeat the last one: own ship turns."""
        result = list[tuple[int, Bytes]]()
        for number in range(self._next, low) if fills else sorted(self._open):
            row = self._open.pop(number, self._last)
            if row is not None:
                result.append((number % SPOKES, row))
        self._open = {number: row for number, row in self._open.items() if number >= low}
        return result


def _from_bow(batch: SpokeBatch) -> Floats:
    """Angles from the bow (K,) in spokes of the xHD; while the heading is lost the azimuth counts from the bow."""
    heading = np.where(np.isnan(batch.block.heading), 0.0, batch.block.heading)
    return np.mod((batch.block.azimuth - heading) * (SPOKES / (2.0 * math.pi)), SPOKES)

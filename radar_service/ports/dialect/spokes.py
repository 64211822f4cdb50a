"""Spokes as another radar has them: a number a revolution from the bow, each once and rising.

No peak is lost. An echo moves by half of our spoke at most, rounded to one of theirs, and by half of their sample or, where that
is the longer one, of our cell.
"""

import math
from collections.abc import Callable

import numpy as np

from radar_service.display.video import Bytes
from radar_service.numerics.types import Floats
from radar_service.ports.dialect.dialect import SampleForm, Spoke
from radar_service.service.spokes import Epoch, SpokeBatch
from radar_service.world.geo import true_bearing


class Samples:
    """How the cells of an epoch become samples that end at the range shown, in whole metres: a cell counts where its middle is.
    Samples shorter than a cell have the one that their middle is in.

    metres: that range.
    """

    def __init__(self, epoch: Epoch, form: SampleForm) -> None:
        to, range_max = epoch.layout(None), epoch.info.radar.range_max
        self.metres = round(min(epoch.range or range_max, range_max, to.range))
        count = form.most if form.fills else min(form.most, max(1, math.floor(self.metres / to.step + 1e-9)))
        width = self.metres / count
        edges = np.arange(count + 1) * width
        if width < to.step:
            edges += 0.5 * (width - to.step)
        cells = np.ceil((edges - to.first) / to.step - 1e-9).astype(np.intp)
        self._layout, self._levels = to, form.levels
        self._starts = np.clip(cells[:-1], 0, to.bins - 1)
        self._end = max(int(self._starts[-1]) + 1, int(cells[-1]))

    def of(self, batch: SpokeBatch) -> Bytes:
        """Returns the samples of a batch (K, samples), as readers take them."""
        cells = batch.video_bytes(self._layout)[:, : self._end]
        samples: Bytes = self._levels[np.maximum.reduceat(cells, self._starts, axis=1)]
        return samples


class BowSpokes:
    """Joins or repeats spokes, as theirs are. lost: those that are left out, as their number or angle does not rise."""

    def __init__(self, azimuths: int, spokes: int, note_break: Callable[[], None] = lambda: None) -> None:
        """azimuths, spokes: in a revolution of ours and of theirs; note_break: is told that what comes does not follow."""
        self.lost, self._azimuths, self._spokes, self._number = 0, azimuths, spokes, -1
        self._note_break = note_break
        self._width = spokes / azimuths  # of a spoke of the radar
        self._half = 0.5 * max(self._width, 1.0)
        self._restart()

    def _restart(self) -> None:
        self._note_break()
        self._angle = math.nan  # of the last spoke, in spokes of theirs, counted on from turn to turn
        self._next, self._open = 0, dict[int, Bytes]()  # the next one to be ended, and what is known of those from it on
        self._last: Bytes | None = None

    def ended(self, batch: SpokeBatch, rows: Bytes, metres: int, headings: Floats) -> list[Spoke]:
        """Returns the spokes that are complete with a batch. rows: its samples; metres: where these end; headings: true."""
        if batch.block.first <= self._number:
            self.lost += len(rows)
            return []
        if batch.block.first - self._number > self._azimuths // 2:  # after standby: which way round is not known
            self._restart()
        self._number = batch.block.first + len(rows) - 1
        bow = np.where(np.isnan(batch.block.heading), 0.0, batch.block.heading)  # lost: the azimuth counts from the bow
        angles = np.mod((batch.block.azimuth - bow) * (self._spokes / (2.0 * math.pi)), self._spokes)
        return [
            Spoke(number, metres, heading, samples)
            for angle, row, heading in zip(angles.tolist(), rows, headings.tolist(), strict=True)
            for number, samples in self._taken(angle, row)
        ]

    def _taken(self, angle: float, row: Bytes) -> list[tuple[int, Bytes]]:
        step = 0.0
        if not math.isnan(self._angle):
            step = math.remainder(angle - self._angle, self._spokes)
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
                result.append((number % self._spokes, row))
        self._open = {number: row for number, row in self._open.items() if number >= low}
        return result


def true_headings(batch: SpokeBatch) -> Floats:
    """Returns headings (K,) [rad] from true north, or from the map's where a scene has no origin; NaN while they are lost."""
    block, origin = batch.block, batch.epoch.info.scene.origin
    north = true_bearing(0.0, block.position, origin) if origin else 0.0
    headings: Floats = block.heading + north
    return headings

"""Labels: the strongest source of each cell, by its power alone; speckle as drawn, noise as its mean.

What rests keeps its label from scan to scan, so it is found once. The echoes of each other source are spread on rows of their
own. Most of these rows cannot exceed the noise (`Compression.peak_gain`), and are not compressed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from radar_service.echo import SECOND_TIME, AzimuthTimes
from radar_service.engine.pipeline import Contributions, Engine, profiles, resting_loss, tile_azimuths
from radar_service.engine.preparation import Prepared
from radar_service.engine.range_sidelobes import RangeSidelobes
from radar_service.engine.stitched import StitchedEngine
from radar_service.numerics import BLAS_LIMIT, Flags, Indices, Profiles, Singles
from radar_service.receive import receiver_noise_power
from radar_service.records import Labels, square_law
from radar_service.sources.numbers import BODY, FAINT, source_numbers
from radar_service.sources.rows import RestingField, WindowedSources, resting_fields, resting_numbers, source_rows

Cells = NDArray[np.int32]
EVERY = slice(None)


@dataclass
class Strongest:
    """The strongest source so far in the cells of some azimuths.

    Floats that are not negative are ordered as their bits are. So a cell is one integer: the bits of the power, with the number
    of the source in place of the last ones. The maximum of two such integers is that of the stronger source.

    Powers are compared to a part in 2**(23 - n), n being the bits of the highest source number: 0.002 dB with 3800 bodies.

    cells: (K, bins) powers, each with the number of its source in its last bits.
    mask: these bits.
    noise: what a cell with noise alone is.
    floor: lowest power of a body that keeps its number, over the body's peak in the row; below it, the number is FAINT.
    """

    cells: Cells
    mask: np.int32
    noise: np.int32
    floor: float = 0.0

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

    def weaken(self, factor: Singles) -> None:
        """Multiplies powers (K, bins) by factors of 1 at most; noise remains."""
        number, power = self.cells & self.mask, (self.cells & ~self.mask).view(np.float32) * factor
        np.maximum((power.view(np.int32) & ~self.mask) | number, self.noise, out=self.cells)

    def clear(self, rows: Indices) -> None:
        """Leaves noise alone in rows (R,)."""
        self.cells[rows] = self.noise

    def offer(self, number: int, power: Singles, rows: Indices | slice = EVERY, first: int = 0) -> None:
        """A source's power (R, columns) [W] in rows (R,), from bin `first` on, its peaks included. The array is used up."""
        columns, offered = slice(first, first + power.shape[1]), self._marked(number, power)
        if isinstance(rows, slice):
            cells = self.cells[rows, columns]
            np.maximum(cells, offered, out=cells)
        else:
            self.cells[rows, columns] = np.maximum(self.cells[rows, columns], offered)

    def _marked(self, number: int, power: Singles) -> Cells:
        """Powers with the number of their source in their last bits, in place."""
        cells, floor = power.view(np.int32), np.float32(self.floor if number >= BODY else 0.0)
        faint = power < floor * power.max(axis=1, keepdims=True, initial=0.0) if floor else None
        cells &= ~self.mask
        cells |= np.int32(number)
        if faint is not None:
            np.bitwise_xor(cells, np.int32(number ^ FAINT), out=cells, where=faint)  # half the time of np.where
        return cells


def unlabelled(azimuths: int, bins: int, noise: float, highest: int, floor: float = 0.0) -> Strongest:
    """Cells with noise of this mean power [W] alone, for source numbers up to `highest`; floor: as of Strongest."""
    mask = np.int32((1 << highest.bit_length()) - 1)
    alone = np.float32(noise).view(np.int32) & ~mask
    return Strongest(np.full((azimuths, bins), alone, dtype=np.int32), mask, alone, floor)


UNCHANGED = 0.01  # of the noise: a source that moves changes the field of the same source at rest by no less


class Labeller:
    """Labels tiles of azimuths of a prepared scene. Safe to call from several threads."""

    @BLAS_LIMIT.held()
    def __init__(self, prepared: Prepared) -> None:
        self._prepared, self._numbers = prepared, source_numbers(prepared.scene)
        self._azimuths, self._bins = prepared.scene.radar.azimuths, prepared.scene.radar.bins
        self._noise = receiver_noise_power(prepared.scene.radar) if prepared.scene.environment.noise else 0.0
        self._gain = np.float32(prepared.compression.peak_gain**2)
        self._sidelobes = RangeSidelobes(prepared.compression, self._noise)
        moving = self._numbers[[*prepared.moving.visibility.scatterers.key, SECOND_TIME]]
        resting = set(resting_numbers(prepared, self._numbers).tolist())
        may_change = prepared.shadows.possible or bool(resting & set(moving.tolist()))
        self._at_rest = self._unlabelled(self._azimuths)
        self._resting: dict[int, RestingField] = {}  # where a source at rest may change
        for number, field in resting_fields(prepared, self._numbers, self._noise * (UNCHANGED if may_change else 1.0)):
            self._at_rest.offer(number, square_law(field.field), field.rows)
            if may_change:
                self._resting[number] = field

    @BLAS_LIMIT.held()
    def labels(self, azimuths: AzimuthTimes, record: Contributions) -> Labels:
        """Labels (K, bins) of the azimuths (K,) of a tile, from what its stages added."""
        transmitting, start = record.transmitting, int(azimuths.number[0]) % self._azimuths
        if record.rows is None and not record.added and resting_loss(self._prepared, azimuths) is None:
            return self._labels_at_rest[start : start + len(transmitting)] * transmitting[:, None]
        rows = source_rows(self._prepared, record, self._numbers, self._resting.keys())
        strongest = self._resting_part(azimuths, transmitting, rows.full_rows)
        for windows in rows.windows:
            self._offer_windows(strongest, windows)
        for number in rows.full_rows.keys() - self._resting.keys():
            gridded = rows.full_rows[number]
            strong = np.flatnonzero(self._exceeds(gridded, self._noise))
            strongest.offer(number, square_law(self._prepared.compression.profiles(gridded[strong])), strong)
        for field in record.added.fields:
            for number, power in field.powers().items():
                strongest.offer(number, power)
        for number, added in record.added.profiles.items():
            for row, received in added.items():
                strongest.offer(number, square_law(received.astype(np.complex64)[None]), slice(row, row + 1))
        return strongest.labels

    @cached_property
    def _labels_at_rest(self) -> Labels:
        """Labels (A, bins) of a scan in which nothing moves."""
        return self._at_rest.labels

    def _unlabelled(self, azimuths: int) -> Strongest:
        radar = self._prepared.scene.radar
        return unlabelled(azimuths, radar.bins, self._noise, int(self._numbers.max()), radar.label_floor)

    def _offer_windows(self, strongest: Strongest, windows: WindowedSources) -> None:
        """Offers sources that stand in few columns, as far as they may exceed the noise."""
        if not len(windows.number):
            return
        first = np.cumsum(windows.width) - windows.width  # of the columns of all windows in a row
        columns = np.repeat(windows.at - first, windows.width) + np.arange(int(windows.width.sum()))
        parts = windows.grid.take(columns, axis=1).view(np.float32)
        peak = square_law(np.maximum(parts.max(axis=0), -parts.min(axis=0)).view(np.complex64))  # of each column, at least
        may_exceed = np.add.reduceat(peak, first) * self._gain > self._noise
        total = np.add.reduceat(np.sqrt(peak), first)
        for s in np.flatnonzero(may_exceed).tolist():
            begin, at, width = int(windows.begin[s]), int(windows.at[s]), int(windows.width[s])
            window = windows.grid[:, at : at + width]
            strong = np.flatnonzero(self._exceeds(window, self._noise))
            if len(strong):
                rows = slice(int(strong[0]), int(strong[-1]) + 1)
                low, high = self._sidelobes.bins(float(total[s]), begin, width)
                strongest.offer(int(windows.number[s]), self._sidelobes.power(window[rows], begin, low, high), rows, low)

    def _exceeds(self, rows: Profiles, floor: float) -> Flags:
        """Whether the profiles of gridded rows (..., columns) may exceed a floor [W] anywhere."""
        parts = rows.view(np.float32)
        energy = np.einsum("...i,...i->...", parts, parts)
        return np.asarray(energy * self._gain > floor)

    def _resting_part(self, azimuths: AzimuthTimes, transmitting: Flags, rows: dict[int, Profiles]) -> Strongest:
        """The strongest source at rest in a tile (K,); rows: what changes such sources (K, size)."""
        start, loss = int(azimuths.number[0]) % self._azimuths, resting_loss(self._prepared, azimuths)
        changed = {
            number: transmitting & self._exceeds(gridded, UNCHANGED * self._noise)
            for number, gridded in rows.items()
            if number in self._resting
        }
        anew = np.any([np.zeros_like(transmitting), *changed.values()], axis=0)
        strongest = self._at_rest.part(start, len(transmitting))
        if loss is not None:
            strongest.weaken(loss * loss)
        if anew.any() or not transmitting.all():
            strongest.clear(np.flatnonzero(anew | ~transmitting))
        for number, field in self._resting.items() if anew.any() else ():
            profile = np.zeros((len(transmitting), self._bins), dtype=np.complex64)
            field.add_to(profile, start)
            if loss is not None:
                profile *= loss
            if number in changed:
                profile[changed[number]] += self._prepared.compression.profiles(rows[number][changed[number]])
            strongest.offer(number, square_law(profile[anew]), np.flatnonzero(anew))
        return strongest


class LabellingEngine(Engine):
    """An engine whose tiles have labels too; field and power keep their bytes."""

    @cached_property
    def _labeller(self) -> Labeller:
        return Labeller(self.prepared)

    def labelled_tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles, Labels]]:
        """Yields the tiles of a scan, each with its labels (K, bins); requested: flags of azimuths (A,), None for all."""
        labeller = self._labeller
        for start in self.starts(requested):
            azimuths, record = tile_azimuths(self.prepared, scan, start), Contributions()
            field = profiles(self.prepared, azimuths, record)
            yield start, field, square_law(field), labeller.labels(azimuths, record)


class LabellingStitchedEngine(StitchedEngine):
    """An engine for several pulses whose tiles have labels too: in each part those of its pulse."""

    def __init__(self, engines: Sequence[LabellingEngine]) -> None:
        super().__init__(engines)
        self._labelling = engines

    def labelled_tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles, Labels]]:
        """Yields the tiles of a scan, each with its labels (K, bins); requested: flags of azimuths (A,), None for all."""
        return self._stitched([engine.labelled_tiles for engine in self._labelling], scan, requested)

"""Labels: the strongest source of each cell, by its power alone; speckle as drawn, noise as its mean.

What rests keeps its label from scan to scan, so it is found once. The echoes of each other source are spread on rows of their
own. Most of these rows cannot exceed the noise (`Compression.peak_gain`), and are not compressed.
"""

from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from radar_service.clutter.clutter import ClutterRows
from radar_service.echo.echoes import SECOND_TIME, AzimuthTimes, BeamWeightedEchoes
from radar_service.engine.pipeline import Contributions, Engine, profiles, tile_azimuths
from radar_service.engine.preparation import Prepared, column
from radar_service.engine.range_sidelobes import COLUMNS, RangeSidelobes, energy
from radar_service.engine.resting_sources import RestingField, resting_fields, resting_numbers
from radar_service.engine.source_numbers import INTERFERENCE, RAIN, SEA, source_numbers
from radar_service.parallel import in_order
from radar_service.receive.compression import receiver_noise_power
from radar_service.receive.detection import square_law
from radar_service.types import Flags, Indices, Profiles, Singles

Labels = NDArray[np.uint32]
FAINT = 0.01  # of the noise: a source that moves changes the field of the same source at rest by no less


class Strongest:
    """The strongest source so far in the cells of some azimuths. label: (K, bins) source numbers; power: (K, bins) [W]."""

    def __init__(self, azimuths: int, bins: int, noise: float) -> None:
        """noise: its mean power [W]."""
        self.label: Labels = np.zeros((azimuths, bins), dtype=np.uint32)
        self.power: Singles = np.full((azimuths, bins), noise, dtype=np.float32)

    def take(self, rows: Indices, other: "Strongest", its: Indices) -> None:
        """Puts rows `its` (R,) of another in place of rows (R,) of this one."""
        self.label[rows], self.power[rows] = other.label[its], other.power[its]

    def offer(self, number: int, power: Singles, rows: Indices | slice, first: int = 0) -> None:
        """A source's power (R, columns) [W] in rows (R,), from bin `first` on; bins outside of the profile are ignored."""
        begin, end = max(0, -first), min(power.shape[1], self.label.shape[1] - first)
        if end <= begin:
            return
        columns = slice(first + begin, first + end)
        before, label, power = self.power[rows, columns], self.label[rows, columns], power[:, begin:end]
        above = power > before
        self.label[rows, columns] = np.where(above, np.uint32(number), label)
        self.power[rows, columns] = np.where(above, power, before)


class Labeller:
    """Labels tiles of azimuths of a prepared scene. Safe to call from several threads."""

    def __init__(self, prepared: Prepared) -> None:
        self._prepared, self._numbers = prepared, source_numbers(prepared.scene)
        self._azimuths, self._bins = prepared.scene.radar.azimuths, prepared.scene.radar.bins
        self._noise = receiver_noise_power(prepared.scene.radar) if prepared.scene.environment.noise else 0.0
        self._sidelobes = RangeSidelobes(prepared.compression, self._noise)
        moving = self._numbers[[*prepared.moving.visibility.scatterers.key, SECOND_TIME]]
        may_change = prepared.shadows.possible or bool(
            set(moving.tolist()) & set(resting_numbers(prepared, self._numbers).tolist())
        )
        self._at_rest = Strongest(self._azimuths, self._bins, self._noise)
        self._resting: dict[int, RestingField] = {}  # where a source at rest may change
        for number, field in resting_fields(prepared, self._numbers, self._noise * (FAINT if may_change else 1.0)):
            self._at_rest.offer(number, square_law(field.field), field.rows)
            if may_change:
                self._resting[number] = field

    def labels(self, azimuths: AzimuthTimes, record: Contributions) -> Labels:
        """Labels (K, bins) of the azimuths (K,) of a tile, from what its stages added."""
        transmitting = ~self._prepared.scene.blind(azimuths.time, azimuths.boresight)
        strongest = Strongest(len(transmitting), self._bins, self._noise)
        changes = self._offer_moving(strongest, record, transmitting)
        self._offer_resting(strongest, int(azimuths.number[0]) % self._azimuths, transmitting, changes)
        if record.clutter is not None:
            _offer_clutter(strongest, record.clutter)
        for row, received in record.interference.items():
            strongest.offer(INTERFERENCE, square_law(received.astype(np.complex64)[None]), np.array([row]))
        return strongest.label

    def _offer_moving(self, strongest: Strongest, record: Contributions, transmitting: Flags) -> dict[int, Profiles]:
        """Offers sources that are not at rest, and returns the gridded rows (K, size) that change sources at rest."""
        changes: dict[int, Profiles] = {}
        for first, stop, echoes in record.echoes:
            for number, part in by_source(echoes, self._numbers):
                if number in self._resting:
                    shape = len(transmitting), self._prepared.compression.size
                    rows = changes.setdefault(number, np.zeros(shape, dtype=np.complex64))
                    spread_echoes(self._prepared, rows[first:stop], part)
                elif np.square(np.abs(part.amplitude).sum(axis=0)).max(initial=0.0) > self._noise:
                    self._offer_source(strongest, number, part, first, transmitting[first:stop])
        return changes

    def _offer_source(
        self, strongest: Strongest, number: int, echoes: BeamWeightedEchoes, first: int, transmitting: Flags
    ) -> None:
        """Offers the echoes of one source over azimuths (K,), `first` is the first of them in the tile."""
        compression = self._prepared.compression
        begin, count = self._window(echoes)
        rows = np.zeros((len(transmitting), count), dtype=np.complex64)
        spread_echoes(self._prepared, rows, echoes, begin)
        strong = np.flatnonzero(transmitting & (energy(rows) * compression.peak_gain**2 > self._noise))
        reach = np.full(len(strong), -1) if count == compression.size else self._sidelobes.reach(rows[strong])
        for each in np.unique(reach).tolist():
            which = strong[reach == each]
            if each >= 0:
                strongest.offer(number, square_law(self._sidelobes.profiles(rows[which], each)), first + which, begin - each)
                continue
            whole = np.zeros((len(which), compression.size), dtype=np.complex64)
            whole[:, begin : begin + count] = rows[which]
            strongest.offer(number, square_law(compression.profiles(whole)), first + which)

    def _window(self, echoes: BeamWeightedEchoes) -> tuple[int, int]:
        """First and number of the grid columns that the echoes' kernels cover; all of them where a row cannot be cut."""
        compression, radar = self._prepared.compression, self._prepared.scene.radar
        position = column(echoes.range, radar.range_step)
        migration = float(np.abs(echoes.range_migration).max()) / radar.range_step
        margin = int(np.ceil(migration)) + compression.kernel.width
        begin = int(np.floor(position.min())) - margin
        count = COLUMNS * -(-(int(np.ceil(position.max())) + margin + 1 - begin) // COLUMNS)
        if self._noise == 0.0 or radar.eclipsing or begin < 0 or begin + count > compression.size:
            return 0, compression.size
        return begin, count

    def _offer_resting(self, strongest: Strongest, start: int, transmitting: Flags, changes: dict[int, Profiles]) -> None:
        """Offers sources at rest in the tile that begins at azimuth `start`; changes: gridded rows (K, size) by source."""
        compression = self._prepared.compression
        changed = {
            number: transmitting & (energy(rows) * compression.peak_gain**2 > FAINT * self._noise)
            for number, rows in changes.items()
        }
        anew = np.any([np.zeros_like(transmitting), *changed.values()], axis=0)
        same = np.flatnonzero(transmitting & ~anew)
        strongest.take(same, self._at_rest, start + same)
        for number, field in self._resting.items() if anew.any() else ():
            profile = np.zeros(strongest.label.shape, dtype=np.complex64)
            field.add_to(profile, start)
            if number in changed:
                profile[changed[number]] += compression.profiles(changes[number][changed[number]])
            strongest.offer(number, square_law(profile[anew]), np.flatnonzero(anew))


class LabellingEngine(Engine):
    """An engine whose tiles have labels too; field and power keep their bytes."""

    @cached_property
    def _labeller(self) -> Labeller:
        return Labeller(self.prepared)

    def labelled_tiles(self, scan: int, requested: Flags | None = None) -> Iterator[tuple[int, Profiles, Singles, Labels]]:
        """As `tiles`, each with its labels (K, bins)."""
        labeller = self._labeller
        starts = self.starts(requested)
        tiles = in_order(partial(_labelled_tile, labeller, self.prepared, scan), starts, self._threads)
        for start, (field, labels) in zip(starts, tiles, strict=True):
            yield start, field, square_law(field), labels


def _labelled_tile(labeller: Labeller, prepared: Prepared, scan: int, start: int) -> tuple[Profiles, Labels]:
    azimuths, record = tile_azimuths(prepared, scan, start), Contributions()
    field = profiles(prepared, azimuths, record)
    return field, labeller.labels(azimuths, record)


def by_source(echoes: BeamWeightedEchoes, numbers: Indices) -> Iterator[tuple[int, BeamWeightedEchoes]]:
    """The echoes of each source; numbers: as `source_numbers`."""
    each = numbers[echoes.body]
    present = np.unique(each).tolist()
    for number in present:
        yield number, echoes if len(present) == 1 else echoes.chosen(np.flatnonzero(each == number))


def spread_echoes(prepared: Prepared, rows: Profiles, echoes: BeamWeightedEchoes, begin: int = 0) -> None:
    """Spreads echoes on rows (K, columns), which are 0 before; their first column is `begin` of the whole row."""
    step = prepared.scene.radar.range_step
    migration = echoes.range_migration * np.float32(1.0 / step)
    prepared.compression.spread(rows, column(echoes.range, step) - begin, migration, echoes.amplitude)


def _offer_clutter(strongest: Strongest, clutter: ClutterRows) -> None:
    power, share = square_law(clutter.field), clutter.rain_share
    every = slice(None)
    if len(clutter.rain):
        strongest.offer(RAIN, power * share, every)
        power = power * (np.float32(1.0) - share)
    strongest.offer(SEA, power, every)

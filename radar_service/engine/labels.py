"""Labels: the strongest source of each cell, by its power alone; speckle as drawn, noise as its mean.

What rests keeps its label from scan to scan, so it is found once. The echoes of each other source are spread on rows of their
own. Most of these rows cannot exceed the noise (`Compression.peak_gain`), and are not compressed.
"""

from collections.abc import Iterator
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from radar_service.echo.echoes import SECOND_TIME, AzimuthTimes
from radar_service.engine.pipeline import Contributions, Engine, profiles, tile_azimuths
from radar_service.engine.preparation import Prepared
from radar_service.engine.range_sidelobes import RangeSidelobes
from radar_service.engine.resting_sources import RestingField, resting_fields, resting_numbers
from radar_service.engine.source_numbers import INTERFERENCE, source_numbers
from radar_service.engine.source_rows import SourceRows, source_rows
from radar_service.engine.strongest import Labels, Strongest
from radar_service.parallel import in_order
from radar_service.receive.compression import receiver_noise_power
from radar_service.receive.detection import square_law
from radar_service.types import Flags, Indices, Profiles, Singles

FAINT = 0.01  # of the noise: a source that moves changes the field of the same source at rest by no less


class Labeller:
    """Labels tiles of azimuths of a prepared scene. Safe to call from several threads."""

    def __init__(self, prepared: Prepared) -> None:
        self._prepared, self._numbers = prepared, source_numbers(prepared.scene)
        self._azimuths, self._bins = prepared.scene.radar.azimuths, prepared.scene.radar.bins
        self._noise = receiver_noise_power(prepared.scene.radar) if prepared.scene.environment.noise else 0.0
        self._sidelobes = RangeSidelobes(prepared.compression, self._noise) if self._noise else None
        moving = self._numbers[[*prepared.moving.visibility.scatterers.key, SECOND_TIME]]
        resting = set(resting_numbers(prepared, self._numbers).tolist())
        may_change = prepared.shadows.possible or bool(resting & set(moving.tolist()))
        self._at_rest = Strongest(self._azimuths, self._bins, self._noise) if resting else None
        self._resting: dict[int, RestingField] = {}  # where a source at rest may change
        for number, field in resting_fields(prepared, self._numbers, self._noise * (FAINT if may_change else 1.0)):
            assert self._at_rest is not None
            self._at_rest.offer(number, square_law(field.field), field.rows)
            if may_change:
                self._resting[number] = field

    def labels(self, azimuths: AzimuthTimes, record: Contributions) -> Labels:
        """Labels (K, bins) of the azimuths (K,) of a tile, from what its stages added."""
        transmitting = record.transmitting
        whole = None if self._sidelobes is None else self._resting.keys()
        rows = source_rows(self._prepared, record.echoes, self._numbers, len(transmitting), whole)
        strongest = self._resting_part(int(azimuths.number[0]) % self._azimuths, transmitting, rows.whole)
        self._offer_moving(strongest, rows, transmitting)
        if record.clutter is not None:
            strongest.offer_clutter(record.clutter)
        for row, received in record.interference.items():
            strongest.offer(INTERFERENCE, square_law(received.astype(np.complex64)[None]), np.array([row]))
        return strongest.label

    def _offer_moving(self, strongest: Strongest, rows: SourceRows, transmitting: Flags) -> None:
        """Offers all sources without a part that rests."""
        for numbers, begin, windows in rows.windows():
            self._offer_windows(strongest, numbers, begin, windows, transmitting)
        for number in rows.whole.keys() - self._resting.keys():
            gridded = rows.whole[number]
            strong = np.flatnonzero(transmitting & self._exceeds(gridded, self._noise))
            strongest.offer(number, square_law(self._prepared.compression.profiles(gridded[strong])), strong)

    def _offer_windows(
        self, strongest: Strongest, numbers: Indices, begin: Indices, windows: Profiles, transmitting: Flags
    ) -> None:
        """Offers sources (S,) with gridded windows (K, S, columns) that begin at grid columns (S,)."""
        assert self._sidelobes is not None
        source, row = np.nonzero((transmitting[:, None] & self._exceeds(windows, self._noise)).T)
        gridded = windows[row, source]
        reaches = self._sidelobes.reach(np.abs(gridded).sum(axis=1))
        for reach in np.unique(reaches).tolist():
            which = np.flatnonzero(reaches == reach)
            power = square_law(self._sidelobes.profiles(gridded[which], reach))
            edges = np.flatnonzero(np.diff(source[which], prepend=-1, append=-1))
            for first, stop in pairwise(edges.tolist()):
                s = source[which[first]]
                strongest.offer(int(numbers[s]), power[first:stop], row[which[first:stop]], int(begin[s]) - reach)

    def _exceeds(self, rows: Profiles, floor: float) -> Flags:
        """Whether the profiles of gridded rows (..., columns) may exceed a floor [W] anywhere."""
        parts = rows.view(np.float32)
        energy = np.einsum("...i,...i->...", parts, parts)
        return np.asarray(energy * np.float32(self._prepared.compression.peak_gain**2) > floor)

    def _resting_part(self, start: int, transmitting: Flags, rows: dict[int, Profiles]) -> Strongest:
        """The strongest source at rest in the tile from azimuth `start` on; rows: what changes such sources (K, size)."""
        if self._at_rest is None:
            return Strongest(len(transmitting), self._bins, self._noise)
        changed = {
            number: transmitting & self._exceeds(gridded, FAINT * self._noise)
            for number, gridded in rows.items()
            if number in self._resting
        }
        anew = np.any([np.zeros_like(transmitting), *changed.values()], axis=0)
        strongest = self._at_rest.part(start, len(transmitting))
        if anew.any() or not transmitting.all():
            strongest.clear(np.flatnonzero(anew | ~transmitting))
        for number, field in self._resting.items() if anew.any() else ():
            profile = np.zeros(strongest.label.shape, dtype=np.complex64)
            field.add_to(profile, start)
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

"""The power of each source alone, exactly as the engine lays it: compressed, in the beam, without noise but its mean."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from radar_service.block_cache import BlockCache
from radar_service.engine.pipeline import Contributions, profiles, tile_azimuths
from radar_service.engine.preparation import Prepared
from radar_service.engine.resting_sources import RestingField, resting_field, resting_numbers
from radar_service.engine.source_numbers import INTERFERENCE, NOISE, RAIN, SEA
from radar_service.engine.source_rows import source_rows
from radar_service.receive.compression import receiver_noise_power
from radar_service.receive.detection import square_law
from radar_service.types import Flags, Indices, Profiles, Singles

RESTING_BYTES = 2**29  # of fields at rest that are kept
TILES = 6  # kept: those that neighbouring crossings share


@dataclass(frozen=True)
class TilePowers:
    """The sources of one tile of azimuths (K,).

    power: (K, bins) [W] by source number; a number without power is left out.
    clutter: mean power of sea and rain over speckle, with texture (K, bins) [W].
    transmitting: (K,) which azimuths are not blind.
    """

    power: dict[int, Singles]
    clutter: Singles
    transmitting: Flags


class SourcePowers:
    """The powers of the sources of a prepared scene, tile by tile. Safe to call from several threads."""

    def __init__(self, prepared: Prepared, numbers: Indices) -> None:
        """numbers: as `source_numbers`: bodies of one number are one source."""
        self.prepared, self._numbers = prepared, numbers
        self._at_rest = resting_numbers(prepared, numbers)
        size = prepared.scene.radar.azimuths * prepared.scene.radar.bins * np.dtype(np.complex64).itemsize
        self._fields: BlockCache[int, RestingField] = BlockCache(max(2, RESTING_BYTES // size))
        self._tiles: BlockCache[tuple[int, int], TilePowers] = BlockCache(TILES)

    def tile(self, scan: int, start: int) -> TilePowers:
        """The sources of the tile of a scan that begins at azimuth `start`, a multiple of `Prepared.tile`."""
        return self._tiles.get((scan, start), lambda: self._computed(scan, start))

    def scan(self, scan: int) -> dict[int, Singles]:
        """The power (A, bins) [W] of each source in one scan, by source number."""
        radar = self.prepared.scene.radar
        powers: dict[int, Singles] = {}
        for start in range(0, radar.azimuths, self.prepared.tile):
            for number, power in self._computed(scan, start).power.items():
                whole = powers.setdefault(number, np.zeros((radar.azimuths, radar.bins), dtype=np.float32))
                whole[start : start + len(power)] = power
        return dict(sorted(powers.items()))

    def _computed(self, scan: int, start: int) -> TilePowers:
        azimuths, record = tile_azimuths(self.prepared, scan, start), Contributions()
        profiles(self.prepared, azimuths, record)
        transmitting = ~self.prepared.scene.blind(azimuths.time, azimuths.boresight)
        shape = len(transmitting), self.prepared.scene.radar.bins
        power: dict[int, Singles] = {}
        if self.prepared.scene.environment.noise:
            power[NOISE] = np.full(shape, receiver_noise_power(self.prepared.scene.radar), dtype=np.float32)
        clutter = np.zeros(shape, dtype=np.float32)
        if record.clutter is not None:
            rows, share = record.clutter, record.clutter.rain_share
            columns = rows.field.shape[1]
            clutter[:, :columns] = np.square(rows.amplitude) * transmitting[:, None]
            power[SEA], power[RAIN] = np.zeros(shape, dtype=np.float32), np.zeros(shape, dtype=np.float32)
            power[RAIN][:, :columns] = square_law(rows.field) * share
            power[SEA][:, :columns] = square_law(rows.field) * (np.float32(1.0) - share)
        for row, received in record.interference.items():
            power.setdefault(INTERFERENCE, np.zeros(shape, dtype=np.float32))[row] = np.abs(received) ** 2
        for number, field in self._body_fields(start, transmitting, record):
            power[number] = square_law(field)
        return TilePowers(dict(sorted(power.items())), clutter, transmitting)

    def _body_fields(self, start: int, transmitting: Flags, record: Contributions) -> Iterator[tuple[int, Profiles]]:
        """Number and field (K, bins) [sqrt(W)] of each source made of bodies, where it has any."""
        gridded = dict(self._gridded(record, transmitting))
        for number in sorted(gridded.keys() | set(np.unique(self._at_rest).tolist())):
            field = np.zeros((len(transmitting), self.prepared.scene.radar.bins), dtype=np.complex64)
            if number in gridded:
                field += self.prepared.compression.profiles(gridded[number])
            if (self._at_rest == number).any():
                self._resting(number).add_to(field, start)
            field[~transmitting] = 0.0
            if field.any():
                yield number, field

    def _gridded(self, record: Contributions, transmitting: Flags) -> Iterator[tuple[int, Profiles]]:
        """Number and gridded rows (K, size) of each source that is not at rest, or that something shadows."""
        rows = source_rows(self.prepared, record.echoes, self._numbers, len(transmitting))
        for number, gridded in rows.whole.items():
            gridded[~transmitting] = 0.0
            yield number, gridded

    def _resting(self, number: int) -> RestingField:
        which = np.flatnonzero(self._at_rest == number)
        return self._fields.get(number, lambda: resting_field(self.prepared, which, 0.0))

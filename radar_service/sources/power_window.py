"""The power of each source alone, exactly as the engine lays it: compressed, in the beam, without noise but its mean.

A window is of consecutive azimuths, which may lie in several tiles and scans, and come from several pulses.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from radar_service.engine.pipeline import contributions, resting_loss, tile_azimuths
from radar_service.engine.preparation import Prepared
from radar_service.engine.range_sidelobes import RangeSidelobes
from radar_service.engine.stitched import pulse_gain
from radar_service.numerics import BLAS_LIMIT, Flags, Indices, Profiles, ResultCache, Singles
from radar_service.receive import receiver_noise_power
from radar_service.records import PowersOf, square_law
from radar_service.sources.numbers import NOISE
from radar_service.sources.rows import RestingField, resting_field, resting_numbers, source_rows

RESTING_BYTES = 2**29  # of fields at rest, and of their powers, that are kept
TILE_BYTES = 2**28  # of tiles that are kept, since neighbouring crossings share them

OTHER_ARRAYS = 5  # beside those of bodies: of noise, and some of effects


@dataclass(frozen=True)
class TilePowers:
    """The sources of one tile of azimuths (K,).

    power: (K, bins) [W] by source number; a number without power is left out.
    background: mean power of random fields over speckle (K, bins) [W].
    transmitting: (K,) which azimuths are not blind.
    """

    power: dict[int, Singles]
    background: Singles
    transmitting: Flags


class SourcePowers:
    """The powers of the sources of a prepared scene, tile by tile. Safe to call from several threads."""

    def __init__(self, prepared: Prepared, numbers: Indices) -> None:
        """numbers: as `source_numbers`: bodies of one number are one source."""
        self.prepared, self._numbers = prepared, numbers
        at_rest = resting_numbers(prepared, numbers)
        self._sidelobes = RangeSidelobes(prepared.compression, 0.0)
        self._at_rest = {number: np.flatnonzero(at_rest == number) for number in np.unique(at_rest).tolist()}
        cells = prepared.scene.radar.azimuths * prepared.scene.radar.bins
        self._fields: ResultCache[int, tuple[RestingField, Singles]] = ResultCache(max(2, RESTING_BYTES // (12 * cells)))
        tile_bytes = 4 * prepared.tile * prepared.scene.radar.bins * (len(prepared.moving) + OTHER_ARRAYS)
        per_scan = -(-prepared.scene.radar.azimuths // prepared.tile)
        kept = int(np.clip(TILE_BYTES // tile_bytes, 2, 2 * per_scan))
        self._tiles: ResultCache[tuple[int, int], TilePowers] = ResultCache(kept)

    def tile(self, scan: int, start: int) -> TilePowers:
        """The sources of the tile of a scan that begins at azimuth `start`, a multiple of `Prepared.tile`."""
        return self._tiles.get((scan, start), lambda: self.computed(scan, start))

    @BLAS_LIMIT.held()
    def computed(self, scan: int, start: int, of: PowersOf = "all") -> TilePowers:
        """Computes `tile` anew, for a scene that is steered. of: the sources that matter; others may be left out."""
        azimuths = tile_azimuths(self.prepared, scan, start)
        record, loss = contributions(self.prepared, azimuths), resting_loss(self.prepared, azimuths)
        shape = len(record.transmitting), self.prepared.scene.radar.bins
        power: dict[int, Singles] = {}
        if self.prepared.scene.environment.noise:
            power[NOISE] = np.full(shape, receiver_noise_power(self.prepared.scene.radar), dtype=np.float32)
        background = np.zeros(shape, dtype=np.float32)
        for field in record.added.fields:
            columns = field.field.shape[1]
            background[:, :columns] += np.square(field.amplitude) * record.transmitting[:, None]
            for number, drawn in field.powers().items():
                power[number] = np.zeros(shape, dtype=np.float32)
                power[number][:, :columns] = drawn
        for number, added in record.added.profiles.items():
            power[number] = np.zeros(shape, dtype=np.float32)
            for row, received in added.items():
                power[number][row] = np.abs(received) ** 2
        rows = source_rows(self.prepared, record, self._numbers, self._at_rest.keys())
        echoing = rows.full_rows.keys() | self._at_rest.keys()
        alone = {
            number: self._alone(number, rows.full_rows.get(number), start, record.transmitting, loss)
            for number in (echoing if of == "all" else echoing & set(of))
        }
        for w in rows.windows:
            for number, begin, at, width in zip(w.number.tolist(), w.begin, w.at, w.width, strict=True):
                if of == "all" or number in of:
                    alone[number] = self._sidelobes.power(w.grid[:, at : at + width], begin, 0, shape[1])
        power |= {number: profile for number, profile in alone.items() if profile.any()}
        power = {number: power[number] for number in sorted(power) if of == "all" or number in of}
        return TilePowers(power, background, record.transmitting)

    def _alone(
        self, number: int, gridded: Profiles | None, start: int, transmitting: Flags, loss: Singles | None
    ) -> Singles:
        """The power (K, bins) [W] of a source made of bodies; gridded: rows (K, size) of what is not at rest, or shadowed; loss:
        (K, bins) of what rests, as `resting_loss`."""
        if gridded is None:
            power = self._resting(number)[1][start : start + len(transmitting)]
            power = power if loss is None else power * (loss * loss)
            return power if transmitting.all() else power * transmitting[:, None]
        field = self.prepared.compression.profiles(gridded)
        if number in self._at_rest:
            resting = np.zeros_like(field)
            self._resting(number)[0].add_to(resting, start)
            field += resting if loss is None else resting * loss
            field[~transmitting] = 0.0
        return square_law(field)

    def _resting(self, number: int) -> tuple[RestingField, Singles]:
        """The field of a source at rest, and its power (A, bins) [W]."""
        return self._fields.get(number, lambda: self._resting_computed(number))

    def _resting_computed(self, number: int) -> tuple[RestingField, Singles]:
        field = resting_field(self.prepared, self._at_rest[number], 0.0)
        power = np.zeros((self.prepared.scene.radar.azimuths, self.prepared.scene.radar.bins), dtype=np.float32)
        power[field.rows] = square_law(field.field)
        return field, power


MakeTile = Callable[[SourcePowers, int, int], TilePowers]


class PulsePowers(NamedTuple):
    """The powers of sources as one pulse has them, in the bins `columns` that it serves; gain: their factor there."""

    powers: SourcePowers
    columns: slice
    gain: np.float32


def pulse_powers(pulses: Sequence[Prepared], numbers: Indices) -> list[PulsePowers]:
    """The powers of the sources of a scene; pulses: the scene prepared for each, by rising range; numbers: as SourcePowers."""
    powers, first, last = list[PulsePowers](), 0, pulses[-1].scene.radar
    for prepared in pulses:
        radar = prepared.scene.radar
        gain = np.float32(pulse_gain(radar, last) ** 2)
        powers.append(PulsePowers(SourcePowers(prepared, numbers), slice(first, radar.bins), gain))
        first = radar.bins
    return powers


class ScanPowers:
    """The powers of some sources in one scan, computed anew as far as they are asked for, azimuth after azimuth."""

    def __init__(self, pulses: Sequence[PulsePowers], scan: int, of: PowersOf) -> None:
        """of: the sources that matter; no other one is computed."""
        self._pulses, self._scan, self._of = pulses, scan, of
        self._newest: dict[SourcePowers, tuple[int, TilePowers]] = {}  # of each pulse: first azimuth of a tile, and the tile

    def between(self, first: int, stop: int) -> dict[int, Singles]:
        """The power (K, bins) [W] of each source from one azimuth to another; a source without power is left out."""
        window = PowerWindow(self._pulses, first, stop, self._tile)
        return {number: power for number in window.sources if (power := window.power(number)).any()}

    def _tile(self, powers: SourcePowers, _: int, start: int) -> TilePowers:
        """The tile of a pulse that begins at an azimuth. Tiles of other pulses end elsewhere, so one may serve twice."""
        if powers not in self._newest or self._newest[powers][0] != start:
            self._newest[powers] = start, powers.computed(self._scan, start, self._of)
        return self._newest[powers][1]


def scan_powers(pulses: Sequence[PulsePowers], scan: int) -> dict[int, Singles]:
    """The power (A, bins) [W] of each source in one scan, by source number."""
    return ScanPowers(pulses, scan, "all").between(0, pulses[-1].powers.prepared.scene.radar.azimuths)


class PowerWindow:
    """Azimuths (K,) from one number since the start to another. number: (K,) of each."""

    def __init__(
        self, pulses: Sequence[PulsePowers], first: int, stop: int, tile: MakeTile = SourcePowers.tile
    ) -> None:  # fmt: skip
        """first, stop: number of the first azimuth, 0 or more, and of the one after the last; tile: of a scan from an azimuth."""
        self.number: Indices = np.arange(first, stop)
        self._parts = [(pulse, _tiles(pulse.powers, first, stop, tile)) for pulse in pulses]

    @property
    def sources(self) -> list[int]:
        """The numbers of all sources that have any power here."""
        return sorted({number for _, tiles in self._parts for tile, _ in tiles for number in tile.power})

    @property
    def transmitting(self) -> Flags:
        """Which azimuths (K,) are not blind."""
        _, tiles = self._parts[-1]
        return np.concatenate([tile.transmitting[rows] for tile, rows in tiles])

    @cached_property
    def background(self) -> Singles:
        """Mean power of random fields over speckle (K, bins) [W]."""
        return self._joined(lambda tile: tile.background)

    def power(self, source: int) -> Singles:
        """The power (K, bins) [W] of a source."""
        return self._joined(lambda tile: tile.power.get(source))

    def _joined(self, array: Callable[[TilePowers], Singles | None]) -> Singles:
        """What each tile of each pulse has in the bins of that pulse; 0 for None."""
        joined = np.zeros((len(self.number), self._parts[-1][0].columns.stop), dtype=np.float32)
        for pulse, tiles in self._parts:
            start = 0
            for tile, rows in tiles:
                part, start = slice(start, start + rows.stop - rows.start), start + rows.stop - rows.start
                if (values := array(tile)) is not None:
                    joined[part, pulse.columns] = pulse.gain * values[rows, pulse.columns]
        return joined


def _tiles(powers: SourcePowers, first: int, stop: int, tile: MakeTile) -> list[tuple[TilePowers, slice]]:
    """The tiles that hold the azimuths from one number to another, and which rows of each."""
    return [(tile(powers, scan, start), rows) for scan, start, rows in _spans(powers.prepared, first, stop)]


def _spans(prepared: Prepared, first: int, stop: int) -> Iterator[tuple[int, int, slice]]:
    """Yields the scan, the first azimuth and the rows of each tile that holds azimuths from one number to another."""
    azimuths, length = prepared.scene.radar.azimuths, prepared.tile
    while first < stop:
        scan, index = divmod(first, azimuths)
        start = index // length * length
        end = min(start + length, azimuths) + scan * azimuths
        yield scan, start, slice(index - start, min(stop, end) - scan * azimuths - start)
        first = end

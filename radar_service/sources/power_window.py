"""The powers of all sources over consecutive azimuths, which may lie in several tiles and scans, and come from several pulses."""

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from radar_service.engine.preparation import Prepared
from radar_service.engine.stitched import pulse_gain
from radar_service.numerics.types import Flags, Indices, Singles
from radar_service.records.cell_sources import PowersOf
from radar_service.sources.powers import SourcePowers, TilePowers


class PulsePowers(NamedTuple):
    """The powers of sources as one pulse has them, in the bins `columns` that it serves; gain: their factor there."""

    powers: SourcePowers
    columns: slice
    gain: np.float32


def pulse_powers(pulses: Sequence[Prepared], numbers: Indices) -> list[PulsePowers]:
    """The powers of the sources of a scene; pulses: the scene prepared for each, by rising range; numbers: as SourcePowers."""
    ends = [0, *(prepared.scene.radar.bins for prepared in pulses)]
    return [
        PulsePowers(
            SourcePowers(prepared, numbers),
            slice(first, stop),
            np.float32(pulse_gain(prepared.scene.radar, pulses[-1].scene.radar) ** 2),
        )
        for prepared, first, stop in zip(pulses, ends[:-1], ends[1:], strict=True)
    ]


def scan_powers(pulses: Sequence[PulsePowers], scan: int) -> dict[int, Singles]:
    """The power (A, bins) [W] of each source in one scan, by source number."""
    radar = pulses[-1].powers.prepared.scene.radar
    powers: dict[int, Singles] = {}
    for pulse in pulses:
        for number, power in pulse.powers.scan(scan).items():
            part = pulse.gain * power[:, pulse.columns]
            if part.any():
                power_of_scan = powers.setdefault(number, np.zeros((radar.azimuths, radar.bins), dtype=np.float32))
                power_of_scan[:, pulse.columns] = part
    return dict(sorted(powers.items()))


class ScanPowers:
    """The powers of some sources in one scan, computed anew as far as they are asked for, azimuth after azimuth."""

    def __init__(self, pulses: Sequence[PulsePowers], scan: int, of: PowersOf) -> None:
        """of: the sources that matter; no other one is computed."""
        self._pulses, self._scan, self._of = pulses, scan, of
        self._newest: dict[int, tuple[int, TilePowers]] = {}  # of each pulse: first azimuth of a tile, and the tile

    def between(self, first: int, stop: int) -> dict[int, Singles]:
        """The power (K, bins) [W] of each source from one azimuth to another; a source without power is left out."""
        shape = stop - first, self._pulses[-1].columns.stop
        powers: dict[int, Singles] = {}
        for k, (of_pulse, columns, gain) in enumerate(self._pulses):
            at = 0
            for _, start, rows in _spans(of_pulse.prepared, first, stop):
                part, at = slice(at, at + rows.stop - rows.start), at + rows.stop - rows.start
                for number, power in self._tile(k, start).power.items():
                    served = gain * power[rows, columns]
                    if served.any():
                        powers.setdefault(number, np.zeros(shape, dtype=np.float32))[part, columns] = served
        return dict(sorted(powers.items()))

    def _tile(self, k: int, start: int) -> TilePowers:
        """The tile of a pulse that begins at an azimuth. Tiles of other pulses end elsewhere, so one may serve twice."""
        if k not in self._newest or self._newest[k][0] != start:
            self._newest[k] = start, self._pulses[k].powers.computed(self._scan, start, self._of)
        return self._newest[k][1]


class PowerWindow:
    """Azimuths (K,) from one number since the start to another. number: (K,) of each."""

    def __init__(self, pulses: Sequence[PulsePowers], first: int, stop: int) -> None:
        """first, stop: number of the first azimuth, 0 or more, and of the one after the last."""
        self.number: Indices = np.arange(first, stop)
        self._parts = [(pulse, _tiles(pulse.powers, first, stop)) for pulse in pulses]

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
    def clutter(self) -> Singles:
        """Mean power of sea and rain (K, bins) [W]."""
        return self._joined(lambda tile: tile.clutter)

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


def _tiles(powers: SourcePowers, first: int, stop: int) -> list[tuple[TilePowers, slice]]:
    """The tiles that hold the azimuths from one number to another, and which rows of each."""
    return [(powers.tile(scan, start), rows) for scan, start, rows in _spans(powers.prepared, first, stop)]


def _spans(prepared: Prepared, first: int, stop: int) -> Iterator[tuple[int, int, slice]]:
    """Yields the scan, the first azimuth and the rows of each tile that holds azimuths from one number to another."""
    azimuths, length = prepared.scene.radar.azimuths, prepared.tile
    while first < stop:
        scan, index = divmod(first, azimuths)
        start = index // length * length
        end = min(start + length, azimuths) + scan * azimuths
        yield scan, start, slice(index - start, min(stop, end) - scan * azimuths - start)
        first = end

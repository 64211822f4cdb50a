"""The powers of all sources over consecutive azimuths, which may lie in several tiles and scans."""

from functools import cached_property

import numpy as np

from radar_service.engine.source_powers import SourcePowers, TilePowers
from radar_service.types import Flags, Indices, Singles


class PowerWindow:
    """Azimuths (K,) from one number since the start to another. number: (K,) of each."""

    def __init__(self, powers: SourcePowers, first: int, stop: int) -> None:
        """first, stop: number of the first azimuth, 0 or more, and of the one after the last."""
        self.number: Indices = np.arange(first, stop)
        self._bins = powers.prepared.scene.radar.bins
        self._parts: list[tuple[TilePowers, slice]] = []
        azimuths, length = powers.prepared.scene.radar.azimuths, powers.prepared.tile
        while first < stop:
            scan, index = divmod(first, azimuths)
            start = index // length * length
            end = min(start + length, azimuths) + scan * azimuths
            self._parts.append((powers.tile(scan, start), slice(index - start, min(stop, end) - scan * azimuths - start)))
            first = end

    @property
    def sources(self) -> list[int]:
        """The numbers of all sources that have any power here."""
        return sorted({number for tile, _ in self._parts for number in tile.power})

    @property
    def transmitting(self) -> Flags:
        """Which azimuths (K,) are not blind."""
        return np.concatenate([tile.transmitting[rows] for tile, rows in self._parts])

    @cached_property
    def clutter(self) -> Singles:
        """Mean power of sea and rain (K, bins) [W]."""
        return np.concatenate([tile.clutter[rows] for tile, rows in self._parts])

    def power(self, source: int) -> Singles:
        """The power (K, bins) [W] of a source."""
        nothing = np.zeros((1, self._bins), dtype=np.float32)
        return np.concatenate(
            [
                tile.power.get(source, np.broadcast_to(nothing, (len(tile.transmitting), self._bins)))[rows]
                for tile, rows in self._parts
            ]
        )

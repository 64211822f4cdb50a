"""Several pulses by range: each pulse has an engine of its own, and profiles are stitched where one pulse hands over to the next.

Up to a pulse's end a profile is that of a radar with this pulse alone, times a constant: receiver noise has the level of the last
pulse everywhere, as sets normalize it. So an echo is fainter in the part of a pulse of less energy, by as much as it has less
signal to noise.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from radar_service.engine.pipeline import Engine
from radar_service.numerics import NEAR_PULSE, Flags, Floats, Profiles, Singles, generator
from radar_service.radar import Radar
from radar_service.receive import receiver_noise_power
from radar_service.records import Labels, square_law
from radar_service.world import Scene

Tiles = Iterator[tuple[int, Profiles, Singles]]


def pulse_scenes(scene: Scene) -> list[Scene]:
    """The scene as a radar with each of its near pulses alone has it, out to the end of the ranges of that pulse."""
    return [replace(scene, radar=radar) for radar in scene.radar.of_each_pulse[:-1]]


def near_seed(seed: int, index: int) -> int:
    """The seed of what near pulse `index` has of its own, as receiver noise."""
    return int(generator(seed, NEAR_PULSE, index).integers(2**63))


def pulse_gain(near: Radar, last: Radar) -> float:
    """Factor of the amplitudes of a near pulse, so that its receiver noise has the level of the last pulse."""
    return float(np.sqrt(receiver_noise_power(last) / receiver_noise_power(near)))


class StitchedEngine:
    """Computes scans of a radar with several pulses, from an engine for each."""

    def __init__(self, engines: Sequence[Engine]) -> None:
        """engines: of the scene prepared for each pulse, by rising range; near ones with a `near_seed`."""
        self._engines, last = engines, engines[-1].prepared
        self._ends = [len(engine.range) for engine in engines]
        self._gains = [pulse_gain(engine.prepared.scene.radar, last.scene.radar) for engine in engines]
        self._tile, self._azimuths = last.tile, last.scene.radar.azimuths
        self.range: Floats = engines[-1].range

    def tiles(self, scan: int, requested: Flags | None = None) -> Tiles:
        """Yields the tiles of a scan as `Engine.tiles`; they are those of the last pulse."""
        return self._stitched([engine.tiles for engine in self._engines], scan, requested)

    def _stitched(self, tiles: Sequence[Callable[..., Iterator[Any]]], scan: int, requested: Flags | None) -> Iterator[Any]:
        """Tiles of the last pulse, with the parts of all others. tiles: of each pulse, with labels or without."""
        needed = None if requested is None else self._whole_tiles(requested)
        near = [
            _Rows(make(scan, needed), self._azimuths, slice(first, stop), gain)
            for make, gain, first, stop in zip(tiles[:-1], self._gains, [0, *self._ends], self._ends, strict=False)
        ]
        for start, field, _, *labels in tiles[-1](scan, requested):
            part = slice(start, start + len(field))
            for rows in near:
                field[:, rows.columns] = rows.up_to(part.stop)[part]
                for each in labels:
                    each[:, rows.columns] = rows.labels[part]
            yield start, field, square_law(field), *labels

    def _whole_tiles(self, requested: Flags) -> Flags:
        """Flags (A,) of all azimuths in a tile of the last pulse that holds a requested one."""
        starts = np.arange(0, len(requested), self._tile)
        has_requested = np.add.reduceat(requested, starts, dtype=np.int64) > 0
        return np.repeat(has_requested, self._tile)[: len(requested)]


class _Rows:
    """The part of a scan that a near pulse serves, computed as far as it is asked for."""

    def __init__(self, tiles: Iterator[Any], azimuths: int, columns: slice, gain: float) -> None:
        self.columns, self._tiles, self._gain, self._done = columns, tiles, np.float32(gain), 0
        self._field = np.zeros((azimuths, columns.stop - columns.start), dtype=np.complex64)
        self.labels: Labels = np.zeros(self._field.shape, dtype=np.uint32)

    def up_to(self, stop: int) -> Profiles:
        """Rows (A, columns), of which those of requested azimuths below `stop` are computed; so are their labels, if any."""
        while self._done < stop:
            start, field, _, *labels = next(self._tiles)
            self._done = start + len(field)
            self._field[start : self._done] = self._gain * field[:, self.columns]
            for each in labels:
                self.labels[start : self._done] = each[:, self.columns]
        return self._field

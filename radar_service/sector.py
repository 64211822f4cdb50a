"""The sector of a scan that a simulator computes."""

from collections.abc import Iterable, Iterator
from itertools import groupby

import numpy as np

from radar_service.radar.parameters import Radar, in_sector
from radar_service.records import SpokeBlock
from radar_service.types import Flags


class Sector:
    """wanted: flags of the azimuths (A,) to compute; None for all."""

    def __init__(self, radar: Radar, ends: tuple[float, float] | None) -> None:
        """ends: from and to, clockwise from true north [rad]; None for a whole scan."""
        self.wanted: Flags | None = None
        if ends is not None:
            self.wanted = in_sector(np.arange(radar.azimuths, dtype=np.float64) * radar.azimuth_step, *ends)

    def stretches(self, blocks: Iterable[SpokeBlock]) -> Iterator[Iterator[SpokeBlock]]:
        """The wanted spokes of a scan's blocks, in stretches of consecutive ones; a sector across north has two."""
        if self.wanted is None:
            yield iter(blocks)
            return
        numbers = np.cumsum(~self.wanted)  # equal within a stretch
        for _, stretch in groupby(self._parts(blocks, self.wanted), lambda part: numbers[part.index]):
            yield stretch

    def _parts(self, blocks: Iterable[SpokeBlock], wanted: Flags) -> Iterator[SpokeBlock]:
        for block in blocks:
            inside = wanted[block.index : block.index + len(block)]
            edges = np.flatnonzero(np.diff(inside, prepend=False, append=False))
            for start, stop in edges.reshape(-1, 2).tolist():
                yield block.part(start, stop)

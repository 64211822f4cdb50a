"""The sector of a scan that a simulator computes."""

from collections.abc import Iterable, Iterator
from copy import copy
from itertools import groupby

import numpy as np

from radar_service.numerics import Flags
from radar_service.radar import Radar, in_sector
from radar_service.records import SpokeBlock


class Sector:
    """requested: flags of the azimuths (A,) to compute; None for all."""

    def __init__(self, radar: Radar, ends: tuple[float, float] | None) -> None:
        """ends: from and to, clockwise from true north [rad]; None for a whole scan."""
        self._azimuths = radar.azimuths
        self.requested: Flags | None = None
        if ends is not None:
            self.requested = in_sector(np.arange(radar.azimuths, dtype=np.float64) * radar.azimuth_step, *ends)

    def after(self, first: int) -> "Sector":
        """The part of the sector from azimuth index `first` on."""
        if first == 0:
            return self
        rest = copy(self)
        every = np.ones(self._azimuths, dtype=np.bool_) if self.requested is None else self.requested
        rest.requested = every & (np.arange(self._azimuths) >= first)
        return rest

    def stretches(self, blocks: Iterable[SpokeBlock]) -> Iterator[Iterator[SpokeBlock]]:
        """The requested spokes of a scan's blocks, in stretches of consecutive ones; a sector across north has two."""
        if self.requested is None:
            yield iter(blocks)
            return
        numbers = np.cumsum(~self.requested)  # equal within a stretch
        for _, stretch in groupby(self._parts(blocks, self.requested), lambda part: numbers[part.index]):
            yield stretch

    def _parts(self, blocks: Iterable[SpokeBlock], requested: Flags) -> Iterator[SpokeBlock]:
        for block in blocks:
            inside = requested[block.index : block.index + len(block)]
            edges = np.flatnonzero(np.diff(inside, prepend=False, append=False))
            for start, stop in edges.reshape(-1, 2).tolist():
                yield block.part(start, stop)

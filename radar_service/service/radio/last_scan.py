"""The memories of the last scan: one from which still pictures are drawn, and one for scan-to-scan correlation."""

import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from radar_service.display.scan_correlation import ScanMemory
from radar_service.display.video import Controls, Layout
from radar_service.numerics import Singles
from radar_service.service.spokes import Epoch, RadarInfo, SinkGroup, SpokeBatch, SpokeSink
from radar_service.spoke_source import SpokeSource, SpokeSourceInfo

Rows = tuple[NDArray[np.intp], Singles, Singles | None]


@dataclass(frozen=True)
class Revolution:
    """The last revolution of a source of spokes.

    of: what is known of that source;
    rows: row numbers (K,), power (K, N) [W] and that of the scan before, as batches have it, oldest first;
    next: number of the spoke that comes next;
    heading: of own ship at the newest spoke [rad].
    """

    of: SpokeSourceInfo
    rows: list[Rows]
    next: int
    heading: float


class LastScan:
    """A sink that keeps row numbers and power [W] of the newest revolution. `_lock` guards all of it together."""

    def __init__(self, spoke_source: SpokeSource) -> None:
        self._lock = threading.Lock()
        self._spoke_source, self._info = spoke_source, spoke_source.info
        self._rows: deque[Rows] = deque()
        self._next, self._heading = 0, 0.0

    def read(self) -> "Revolution":
        """Returns what is kept."""
        with self._lock:
            return Revolution(self._info, list(self._rows), self._next, self._heading)

    def open_epoch(self, radar: RadarInfo) -> None:
        """Drops the rows of another source; another display range keeps them."""
        with self._lock:
            if radar.epoch.spoke_source is not self._spoke_source:
                self._spoke_source, self._info, self._next = radar.epoch.spoke_source, radar.epoch.info, 0
                self._rows.clear()

    def send(self, batch: SpokeBatch) -> None:
        """Keeps a copy of a batch, as a part of a block holds all of its memory; drops what is older than one revolution."""
        block, azimuths = batch.block, batch.epoch.info.radar.azimuths
        with self._lock:
            self._spoke_source, self._info = batch.epoch.spoke_source, batch.epoch.info
            self._next = block.first + len(block)
            self._heading = self._heading if np.isnan(block.heading[-1]) else float(block.heading[-1])
            earlier = None if batch.earlier is None else batch.earlier.copy()
            self._rows.append((np.arange(block.index, block.index + len(block)), block.power.copy(), earlier))
            kept = sum(len(rows) for rows, *_ in self._rows)
            while kept - len(self._rows[0][0]) >= azimuths:
                kept -= len(self._rows.popleft()[0])

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Keeps the rows: older echoes stay in the picture."""

    def close(self, reason: str) -> None:
        """Keeps the rows: the picture stays."""


class CorrelationStage(SinkGroup):
    """A sink that passes spokes on, with the power of the scan before while `scan_correlation` is on.

    Its memory begins when the control is switched on and ends with it, or with the source.
    """

    def __init__(self, sinks: Sequence[SpokeSink]) -> None:
        super().__init__(sinks)
        self._memory: tuple[SpokeSource, ScanMemory] | None = None

    @override
    def send(self, batch: SpokeBatch) -> None:
        """Passes on spokes, and remembers them."""
        if batch.video.scan_correlation:
            batch = replace(batch, earlier=self._memory_of(batch.epoch).take(batch.block))
        else:
            self._memory = None
        super().send(batch)

    @override
    def close(self, reason: str) -> None:
        """Passes on the notice, and forgets."""
        self._memory = None
        super().close(reason)

    def _memory_of(self, epoch: Epoch) -> ScanMemory:
        if self._memory is None or self._memory[0] is not epoch.spoke_source:
            self._memory = epoch.spoke_source, ScanMemory(epoch.info.radar, epoch.info.range, epoch.info.range_step)
        return self._memory[1]


def draw(
    rows: list[Rows], azimuths: int, to: Layout, video: Controls, noise_power: float, title: str, size: int,
    range_max: float | None, heading: float,
) -> bytes:  # fmt: skip
    """Returns a picture, see display.last_scan. Runs in a process of its own."""
    from radar_service.display.last_scan import last_scan_png  # here: the serving process does not draw

    return last_scan_png(
        rows, azimuths, to, video, noise_power, title=title, size=size, range_max=range_max, heading=heading
    )

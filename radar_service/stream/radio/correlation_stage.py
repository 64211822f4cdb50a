"""Scan-to-scan correlation of one radar, for all its receivers alike."""

from collections.abc import Sequence
from dataclasses import replace

from radar_service.display.scan_correlation import ScanMemory
from radar_service.stream.source import SpokeSource
from radar_service.stream.spokes import RadarInfo, SinkGroup, SpokeBatch, SpokeSink


class CorrelationStage:
    """A sink that passes spokes on, with the power of the scan before while `scan_correlation` is on.

    Its memory begins when the control is switched on and ends with it, or with the engine.
    """

    def __init__(self, sinks: Sequence[SpokeSink]) -> None:
        self._sinks = SinkGroup(sinks)
        self._memory: tuple[SpokeSource, ScanMemory] | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Passes on the notice; another display range keeps the memory."""
        self._sinks.open_epoch(radar)

    def send(self, batch: SpokeBatch) -> None:
        """Passes on spokes, and remembers them."""
        if batch.video.scan_correlation:
            batch = replace(batch, earlier=self._memory_of(batch.epoch.engine).take(batch.block))
        else:
            self._memory = None
        self._sinks.send(batch)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Passes on the notice."""
        self._sinks.skip(epoch, first, count, reason)

    def close(self, reason: str) -> None:
        """Passes on the notice, and forgets."""
        self._memory = None
        self._sinks.close(reason)

    def _memory_of(self, engine: SpokeSource) -> ScanMemory:
        if self._memory is None or self._memory[0] is not engine:
            self._memory = engine, ScanMemory(engine.scene.radar, engine.range, engine.range_step)
        return self._memory[1]

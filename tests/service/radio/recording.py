"""A sink that records what a transmitter does, and waits for it, without an event loop."""

import threading
from typing import Any

from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch

SOON = 60.0  # s, for what should take milliseconds


class RecordingSink:
    """Records every call in order as (name, details); batches also as they are."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, Any]] = []
        self.batches: list[SpokeBatch] = []
        self.epochs: list[Epoch] = []
        self._changed = threading.Condition()

    def open_epoch(self, radar: RadarInfo) -> None:
        self.epochs.append(radar.epoch)
        self._record("open", radar.epoch.name)

    def send(self, batch: SpokeBatch) -> None:
        self.batches.append(batch)
        self._record("send", (batch.epoch.name, batch.first, len(batch)))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        self._record("skip", (epoch, first, count, reason))

    def close(self, reason: str) -> None:
        self._record("close", reason)

    @property
    def spokes(self) -> int:
        """Number of spokes received."""
        return sum(map(len, self.batches))

    @property
    def numbers(self) -> list[int]:
        """Numbers of the spokes received, counted from the start of their scene."""
        return [n for batch in self.batches for n in range(batch.block.first, batch.block.first + len(batch))]

    def names(self) -> list[str]:
        """The calls without repetition: a run of `send` is one."""
        return [name for k, (name, _) in enumerate(self.calls) if not k or self.calls[k - 1][0] != name or name != "send"]

    def wait_for(self, condition: Any) -> None:
        """Waits until the condition holds. Raises AssertionError after SOON."""
        with self._changed:
            assert self._changed.wait_for(condition, SOON), self.calls

    def _record(self, name: str, details: Any) -> None:
        with self._changed:
            self.calls.append((name, details))
            self._changed.notify_all()

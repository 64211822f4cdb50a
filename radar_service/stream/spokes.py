"""The interface between a radar and all receivers of its spokes.

The transmitter hands each `SpokeBatch` to any number of `SpokeSink`s before anything is encoded. The feed is one sink
(`fanout.feed_encoder`), the memory of the last scan is another (`radio.last_scan`).
"""

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from radar_service.display.video import Controls, Layout
from radar_service.records import SpokeBlock
from radar_service.stream.source import SpokeSource, cell_layout
from radar_service.types import Singles


@dataclass(frozen=True)
class Epoch:
    """A part of the feed in which sequence numbers count on and the range cells stay the same.

    range: of the display [m], None for all cells.
    """

    name: str
    engine: SpokeSource
    range: float | None

    def layout(self, bins: int | None) -> Layout:
        """Returns how a spoke of this epoch becomes `bins` bins; None is one for each cell."""
        return cell_layout(self.engine, bins, self.range)


@dataclass(frozen=True)
class SpokeBatch:
    """Consecutive spokes of one scan at the moment when they are due, not encoded.

    first: sequence number of the first spoke within the epoch.
    block: the spokes.
    video: the display controls in force.
    before: power (N,) [W] of the spoke before the first one, None where there was none.
    earlier: power (K, N) [W] that the scan before had around each cell, see `ScanMemory`; None without scan correlation.
    """

    epoch: Epoch
    first: int
    block: SpokeBlock
    video: Controls
    before: Singles | None = None
    earlier: Singles | None = None

    def __len__(self) -> int:
        return len(self.block)


@dataclass(frozen=True)
class RadarInfo:
    """The description of the radar in the first message of an epoch.

    simulated: time of the next spoke [s]; controls: their state, as REST gives it.
    """

    identity: str
    name: str
    epoch: Epoch
    simulated: float
    controls: Mapping[str, Any]
    truth_allowed: bool

    @classmethod
    def unnamed(cls, epoch: Epoch) -> "RadarInfo":
        """The description of a radar outside a service."""
        return cls("0", "radar 0", epoch, 0.0, {}, False)


class SpokeSink(Protocol):
    """Receives the spokes of one radar.

    The transmitter calls a sink from its own thread, one call at a time; the next spokes wait until the call returns.
    """

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch: sequence numbers start at 0. The first call, and one after each change of scene or range."""

    def send(self, batch: SpokeBatch) -> None:
        """Takes the next spokes of the open epoch."""

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Receives the notice that `count` spokes of this epoch, from sequence number `first` on, will never come."""

    def close(self, reason: str) -> None:
        """Receives the notice that no spokes come until another epoch opens."""


class SinkGroup:
    """Several sinks as one: each receives all, in the order in which they were given."""

    def __init__(self, sinks: Sequence[SpokeSink]) -> None:
        self._sinks = tuple(sinks)

    def open_epoch(self, radar: RadarInfo) -> None:
        """As SpokeSink.open_epoch."""
        for sink in self._sinks:
            sink.open_epoch(radar)

    def send(self, batch: SpokeBatch) -> None:
        """As SpokeSink.send."""
        for sink in self._sinks:
            sink.send(batch)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """As SpokeSink.skip."""
        for sink in self._sinks:
            sink.skip(epoch, first, count, reason)

    def close(self, reason: str) -> None:
        """As SpokeSink.close."""
        for sink in self._sinks:
            sink.close(reason)


def new_epoch_name() -> str:
    """Returns a name that no other epoch has had, in this process or an earlier one."""
    return secrets.token_hex(4)

"""The interface between a radar and all receivers of its spokes.

The transmitter hands each `SpokeBatch` to any number of `SpokeSink`s before anything is encoded. The feed is one sink
(`fanout.hub.FeedEncoder`), the memory of the last scan is another (`radio.last_scan`).
"""

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import cached_property
from typing import Any, Protocol

from typing_extensions import override

from radar_service.display.video import Bytes, Controls, Layout, display_video, peaks
from radar_service.numerics import Singles
from radar_service.records import SpokeBlock
from radar_service.service.scene_request import SceneRequest, cell_layout
from radar_service.spoke_source import SpokeSource, SpokeSourceInfo
from radar_service.world import NOT_STEERABLE, CommandLog, ErrorSettings

NO_COMMANDS = CommandLog(NOT_STEERABLE)


def whole_second() -> datetime:
    """Returns the present second in UTC."""
    return datetime.now(UTC).replace(microsecond=0)


@dataclass(frozen=True)
class Epoch:
    """A part of the feed in which sequence numbers count on and the range cells stay the same.

    spoke_source: another one after a failure; range: of the display [m], None for all cells.
    commands: all that came so far; scene_request: of the scene, None where there was none; start_utc: UTC at simulated time 0.
    info: of the spoke source. Another process gets an epoch without its spoke source and the commands.
    """

    name: str
    spoke_source: SpokeSource = field(repr=False, compare=False)
    range: float | None
    commands: CommandLog = field(default_factory=lambda: NO_COMMANDS, repr=False, compare=False)
    scene_request: SceneRequest | None = field(default=None, compare=False)
    start_utc: datetime = field(default_factory=whole_second, compare=False)
    info: SpokeSourceInfo = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "info", self.spoke_source.info)

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in vars(self).items() if key not in ("spoke_source", "commands")}

    @property
    def is_blind(self) -> bool:
        """Whether clients are told neither the seed nor the number of bodies."""
        return self.scene_request is not None and self.scene_request.blind

    @property
    def goes_on(self) -> bool:
        """Whether it goes on with the time, the commands and the errors of a scene that ran."""
        return self.scene_request is not None and self.scene_request.goes_on

    def layout(self, bins: int | None) -> Layout:
        """Returns how a spoke of this epoch becomes `bins` bins; None is one for each cell."""
        return cell_layout(self.info, bins, self.range)


@dataclass(frozen=True)
class SpokeBatch:
    """Consecutive spokes of one scan at the moment when they are due, not encoded.

    first: sequence number of the first spoke within the epoch.
    block: the spokes.
    video: the display controls in force.
    before: power (N,) [W] of the spoke before the first one, None where there was none.
    earlier: power (K, N) [W] that the scan before had around each cell, see `ScanMemory`; None without scan correlation.
    errors: on purpose, in force at these spokes.
    """

    epoch: Epoch
    first: int
    block: SpokeBlock
    video: Controls
    before: Singles | None = None
    earlier: Singles | None = None
    errors: ErrorSettings | None = None

    def __len__(self) -> int:
        return len(self.block)

    @cached_property
    def _cells(self) -> Bytes:
        """The video of each shown cell, once for all views."""
        to, noise_power = self.epoch.layout(None), self.epoch.info.noise_power
        return display_video(self.block.power, to, self.video, noise_power, self.before, self.earlier)

    def video_bytes(self, to: Layout) -> Bytes:
        """Returns the video of the display (K, bins), as `display_video`: the highest byte is that of the highest level."""
        return peaks(self._cells, to)


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

    @property
    def utc(self) -> datetime:
        """The time of the next spoke."""
        return self.epoch.start_utc + timedelta(seconds=self.simulated)

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
        return

    def close(self, reason: str) -> None:
        """Receives the notice that no spokes come until another epoch opens."""
        return


class SinkGroup(SpokeSink):
    """Several sinks as one: each receives all, in the order in which they were given."""

    def __init__(self, sinks: Sequence[SpokeSink]) -> None:
        self._sinks = tuple(sinks)

    @override
    def open_epoch(self, radar: RadarInfo) -> None:
        for sink in self._sinks:
            sink.open_epoch(radar)

    @override
    def send(self, batch: SpokeBatch) -> None:
        for sink in self._sinks:
            sink.send(batch)

    @override
    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        for sink in self._sinks:
            sink.skip(epoch, first, count, reason)

    @override
    def close(self, reason: str) -> None:
        for sink in self._sinks:
            sink.close(reason)


def new_epoch_name() -> str:
    """Returns a name that no other epoch has had, in this process or an earlier one."""
    return secrets.token_hex(4)

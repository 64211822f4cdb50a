"""The feed as a sink of spokes: encodes each batch once for each view that clients have."""

from collections.abc import Callable, Mapping
from functools import reduce
from operator import or_
from typing import Protocol

from radar_service.cell_sources import SourceRequest
from radar_service.stream.codecs.registry import CODECS
from radar_service.stream.fanout.hub import EncodedBatch
from radar_service.stream.feed_request import Mode, View
from radar_service.stream.spokes import Epoch, RadarInfo, SpokeBatch


class EncodedSink(Protocol):
    """Takes encoded batches, as FeedOutput does."""

    @property
    def views(self) -> tuple[View, ...]:
        """What to encode."""

    def open_epoch(self, epoch: str, hello: Callable[[View, Mode], bytes], spoke_period: float) -> None:
        """Begins an epoch, with spokes of that period in real time [s]."""

    def publish(self, batch: EncodedBatch) -> None:
        """Takes the next batch."""

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Receives the notice of spokes that will never come, from number `first` on."""

    def close(self, reason: str) -> None:
        """Receives the notice that no more spokes come."""


class FeedEncoder:
    """The sink that encodes spokes for the feed. Runs in the transmitter's thread.

    radar_info: describes the radar in an epoch for a hello; it is called on the event loop.
    """

    def __init__(self, output: EncodedSink, radar_info: Callable[[Epoch], RadarInfo], clock: Callable[[], float]) -> None:
        self._output, self._radar_info, self._clock = output, radar_info, clock
        self._timings: dict[str, tuple[int, float]] = {}
        self._answered: tuple[View, ...] = ()  # those whose sources the next spokes tell

    @property
    def timings(self) -> Mapping[str, tuple[int, float]]:
        """Number of encoded batches, and the time that they took [s], by encoding."""
        return dict(self._timings)

    def requested(self) -> SourceRequest:
        """Returns what clients need of the sources of the next spokes. Those who join later get the spokes after these."""
        self._answered = self._output.views
        return reduce(or_, (view.sources for view in self._answered), SourceRequest())

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch."""

        def hello(view: View, mode: Mode) -> bytes:
            return CODECS[view.codec].hello(self._radar_info(radar.epoch), view, mode)

        self._output.open_epoch(radar.epoch.name, hello, radar.epoch.engine.scene.radar.spoke_period)

    def send(self, batch: SpokeBatch) -> None:
        """Encodes a batch for each view and publishes it."""
        data = {view: self._encoded(batch, view) for view in self._output.views if self._is_answered(view)}
        self._output.publish(EncodedBatch(batch.epoch.name, batch.first, len(batch), data))

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Announces spokes that will never come."""
        self._output.skip(epoch, first, count, reason)

    def close(self, reason: str) -> None:
        """Ends the feed until another epoch opens."""
        self._output.close(f"the radar has stopped: {reason}")

    def _is_answered(self, view: View) -> bool:
        return view in self._answered or not view.sources

    def _encoded(self, batch: SpokeBatch, view: View) -> bytes:
        began = self._clock()
        data = CODECS[view.codec].spokes(batch, view)
        count, seconds = self._timings.get(view.encoding, (0, 0.0))
        self._timings[view.encoding] = count + 1, seconds + self._clock() - began
        return data

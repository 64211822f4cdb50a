"""The feed as a sink of spokes: encodes each batch once for each view that clients have, and hands it to the event loop."""

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from concurrent.futures import Executor
from functools import reduce
from operator import or_
from typing import Any

from radar_service.records.cell_sources import SourceRequest
from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.feed_truth import FeedTruth
from radar_service.service.fanout.hub import EncodedBatch, Hub
from radar_service.service.feed_request import Mode, View
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch


class FeedEncoder:
    """The sink that encodes spokes for the clients of a hub. Runs in the transmitter's thread; a call returns when the hub has
    done it. `start` comes first and is called on the hub's event loop.
    """

    def __init__(
        self, hub: Hub, truths: Executor, radar_info: Callable[[Epoch], RadarInfo], clock: Callable[[], float]
    ) -> None:
        """truths: where sources are asked for the truth; radar_info: describes the radar in an epoch for a hello; it is called on
        the event loop."""
        self._hub, self._radar_info, self._clock = hub, radar_info, clock
        self._truth = FeedTruth(hub, truths)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._timings: dict[str, tuple[int, float]] = {}
        self._answered: tuple[View, ...] = ()  # those whose sources the next spokes tell

    @property
    def timings(self) -> Mapping[str, tuple[int, float]]:
        """Number of encoded batches, and the time that they took [s], by encoding."""
        return dict(self._timings)

    def start(self) -> None:
        """Remembers the running event loop."""
        self._loop = asyncio.get_running_loop()
        self._truth.start()

    def stop(self) -> None:
        """Asks for no more truths."""
        self._truth.stop()

    def requested(self) -> SourceRequest:
        """Returns what clients need of the sources of the next spokes. Those who join later get the spokes after these."""
        self._answered = self._hub.views
        return reduce(or_, (view.sources for view in self._answered), SourceRequest())

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch."""

        def hello(view: View, mode: Mode) -> bytes:
            return CODECS[view.codec].hello(self._radar_info(radar.epoch), view, mode)

        period = radar.epoch.info.radar.spoke_period
        self._call(lambda: self._hub.open_epoch(radar.epoch.name, hello, period))

    def send(self, batch: SpokeBatch) -> None:
        """Encodes a batch for each view; returns when it is queued for every client, for lossless ones too."""
        data = {view: self._encoded(batch, view) for view in self._hub.views if self._is_answered(view)}
        self._on_loop(self._hub.publish(EncodedBatch(batch.epoch.name, batch.first, len(batch), data)))
        self._truth.sent(batch.epoch, batch.block.index, batch.block.time)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Announces spokes that will never come."""
        self._call(lambda: self._hub.skip(epoch, first, count, reason))

    def close(self, reason: str) -> None:
        """Ends the feed until another epoch opens; returns when the clients have left, or their time to read is over."""
        self._on_loop(self._hub.finish(f"the radar has stopped: {reason}"))

    def _is_answered(self, view: View) -> bool:
        return view in self._answered or not view.sources

    def _encoded(self, batch: SpokeBatch, view: View) -> bytes:
        began = self._clock()
        data = CODECS[view.codec].spokes(batch, view)
        count, seconds = self._timings.get(view.encoding, (0, 0.0))
        self._timings[view.encoding] = count + 1, seconds + self._clock() - began
        return data

    def _call(self, function: Callable[[], None]) -> None:
        async def call() -> None:
            function()

        self._on_loop(call())

    def _on_loop(self, call: Coroutine[Any, Any, None]) -> None:
        assert self._loop is not None, "start() comes first"
        asyncio.run_coroutine_threadsafe(call, self._loop).result()

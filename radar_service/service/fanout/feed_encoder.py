"""The feed as a sink of spokes: encodes each batch once for each view that clients have, and hands it to the event loop.

The truth is asked and sent beside the spokes, so that a late one delays none.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine, Mapping
from concurrent.futures import Executor
from functools import reduce
from operator import or_
from typing import Any

from radar_service.numerics import Floats
from radar_service.records import SourceRequest
from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.hub import EncodedBatch, Hub
from radar_service.service.feed_request import Mode, View
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch

TRUTHS_PER_SCAN = 8  # enough to draw a track, at a cost that cannot be measured
MAX_WAITING = 4 * TRUTHS_PER_SCAN  # truths that are to be asked; beyond it the oldest are given up

Messages = list[tuple[str, bytes]]  # codec and message


class FeedTruth:
    """Sends the truth of TRUTHS_PER_SCAN instants of each scan to the clients that request it, in order.

    What a radar's process does not answer, because it has died or is slow, is announced as missing. Truths that wait when
    their epoch ends are not sent. Belongs to the event loop, but for `sent`.

    pool: where sources are asked, one question at a time; `start` comes first.
    """

    def __init__(self, hub: Hub, pool: Executor) -> None:
        self._hub, self._pool = hub, pool
        self._waiting: deque[tuple[Epoch, float]] = deque()
        self._given_up: list[tuple[Epoch, float]] = []  # since the question that is being asked
        self._asking: asyncio.Task[None] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self) -> None:
        """Remembers the running event loop."""
        self._loop = asyncio.get_running_loop()

    def stop(self) -> None:
        """Asks no more."""
        self._loop = None
        self._waiting.clear()
        if self._asking:
            self._asking.cancel()

    def sent(self, epoch: Epoch, index: int, times: Floats) -> None:
        """Asks for the truth at times (K,) [s] at which spokes were sent, from `index` of their scan on, if a client requests it.
        From any thread."""
        if self._hub.truth_codecs and self._loop:
            every = max(1, epoch.info.radar.azimuths // TRUTHS_PER_SCAN)
            due = [float(time) for k, time in enumerate(times) if (index + k) % every == 0]
            if due:
                self._loop.call_soon_threadsafe(self._put, epoch, due)

    def _put(self, epoch: Epoch, times: list[float]) -> None:
        self._waiting.extend((epoch, time) for time in times)
        while len(self._waiting) > MAX_WAITING:
            self._given_up.append(self._waiting.popleft())
        if self._asking is None and self._loop:
            self._asking = self._loop.create_task(self._ask_all())

    async def _ask_all(self) -> None:
        while self._waiting:
            epoch, time = self._waiting.popleft()
            if epoch.name == self._hub.epoch:
                self._hub.tell(epoch.name, await self._asked(epoch, time))
                self._announce_given_up()
        self._asking = None

    async def _asked(self, epoch: Epoch, time: float) -> Messages:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._pool, _truth, epoch, time, self._hub.truth_codecs)
        except Exception as error:  # of any kind: the feed goes on
            return self._missing(epoch, [time], str(error))

    def _announce_given_up(self) -> None:
        """Announces the truths that were given up while an older one was awaited."""
        epoch = self._given_up[-1][0] if self._given_up else None
        times = [time for other, time in self._given_up if epoch and other.name == epoch.name]
        self._given_up.clear()
        if epoch:
            self._hub.tell(epoch.name, self._missing(epoch, times, "the radar's process tells the truth too slowly"))

    def _missing(self, epoch: Epoch, times: list[float], reason: str) -> Messages:
        return [
            (name, CODECS[name].no_truth(epoch.name, times[0], times[-1], len(times), reason))
            for name in self._hub.truth_codecs
        ]


def _truth(epoch: Epoch, time: float, codecs: tuple[str, ...]) -> Messages:
    state = epoch.spoke_source.truth(time)
    return [(name, CODECS[name].truth(epoch.name, state)) for name in codecs]


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
        self._last = -1  # the highest number that a spoke of this epoch has had since the start of the simulation

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

        self._last = -1
        period = radar.epoch.info.radar.spoke_period
        self._call(lambda: self._hub.open_epoch(radar.epoch.name, hello, period))

    def send(self, batch: SpokeBatch) -> None:
        """Encodes a batch for each view; returns when it is queued for every client, for lossless ones too."""
        rises = batch.block.first > self._last
        self._last = max(self._last, batch.block.first + len(batch) - 1)
        views = [view for view in self._hub.views if self._is_answered(view) and (rises or not CODECS[view.codec].rising)]
        data = {view: self._encoded(batch, view) for view in views}
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

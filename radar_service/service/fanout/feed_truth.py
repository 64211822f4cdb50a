"""The truth on the feed: asked and sent beside the spokes, so that a late one delays none."""

import asyncio
from collections import deque
from concurrent.futures import Executor

from radar_service.numerics.types import Floats
from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.hub import Hub
from radar_service.service.spokes import Epoch

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

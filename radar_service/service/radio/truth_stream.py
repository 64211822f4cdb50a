"""Sinks that tell the truth of what was sent: of the feed at instants of a scan; of the stream each beam crossing, and all bodies
at the end of each scan."""

import asyncio
import contextlib
import math
from collections import deque
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Executor
from typing import NamedTuple

from typing_extensions import override

from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.client_queue import GOING_AWAY, TOO_SLOW
from radar_service.service.fanout.hub import FeedRefused, Hub
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, SpokeSink
from radar_service.spoke_source import SpokeSource, SpokeSourceFault, TruthLine

MAX_FOLLOWERS = 16
MAX_BEHIND = 4096  # batches: a minute at 15 ms each
TRUTHS_PER_SCAN = 8  # of the feed: enough to draw a track, at a cost that cannot be measured
MAX_WAITING = 4 * TRUTHS_PER_SCAN  # truths that are to be asked; beyond it the oldest are given up
MAX_KEPT = 4  # scans whose lines are kept, so that several followers ask for them once

Messages = list[tuple[str, bytes]]  # codec and message


class SentSpokes(NamedTuple):
    """Spokes of a scan that were sent: times of the first and the last one [s].

    ends: whether they end the scan; commands: how many act until then.
    """

    spoke_source: SpokeSource
    scan: int
    first: float
    last: float
    ends: bool
    commands: int = 0


class Follower:
    """A client of the stream. reason, code: why it was ended, and the websocket's close code; "" while it is not.

    radiometric: whether its crossings have the power of each body too.
    """

    def __init__(self, radiometric: bool = False) -> None:
        self.radiometric = radiometric
        self.reason, self.code = "", GOING_AWAY
        self._sent: asyncio.Queue[SentSpokes | None] = asyncio.Queue()

    async def next(self) -> SentSpokes | None:
        """Returns what was sent next; None at the end."""
        if (sent := await self._sent.get()) is None:
            self._sent.put_nowait(None)
        return sent

    def put(self, sent: SentSpokes) -> None:
        """Notes what was sent."""
        if self._sent.qsize() < MAX_BEHIND:
            return self._sent.put_nowait(sent)
        while not self._sent.empty():
            self._sent.get_nowait()
        self.end("this client reads the truth too slowly", TOO_SLOW)

    def end(self, reason: str, code: int = GOING_AWAY) -> None:
        """Ends it, after what it has yet to read."""
        if not self.reason:
            self.reason, self.code = reason, code
        self._sent.put_nowait(None)


class TruthStream(SpokeSink):
    """A sink that tells followers of its own what was sent. Belongs to the event loop, but for the methods of sinks.

    pool: where sources are asked; completed: adds to a line of a source's truth what was reported; `start` comes first.
    """

    def __init__(
        self, spoke_source: SpokeSource, pool: Executor,
        completed: Callable[[SpokeSource, TruthLine], str] = lambda spoke_source, line: line.text,
    ) -> None:  # fmt: skip
        self._spoke_source, self._pool, self._completed = spoke_source, pool, completed
        self._followers: set[Follower] = set()
        self._kept: dict[tuple[SpokeSource, int | None, int, bool], asyncio.Future[list[TruthLine]]] = {}
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self) -> None:
        """Remembers the running event loop."""
        self._loop = asyncio.get_running_loop()

    @override
    def open_epoch(self, radar: RadarInfo) -> None:
        self._spoke_source = radar.epoch.spoke_source

    @override
    def send(self, batch: SpokeBatch) -> None:
        epoch, block = batch.epoch, batch.block
        if self._followers and self._loop:
            ends = block.index + len(block) == epoch.info.radar.azimuths
            commands = epoch.commands.acting_at(block.first + len(block) - 1)
            first, last = float(block.time[0]), float(block.time[-1])
            sent = SentSpokes(epoch.spoke_source, block.scan, first, last, ends, commands)
            self._loop.call_soon_threadsafe(self._put, sent)

    @override
    def close(self, reason: str) -> None:
        if self._loop:
            self._loop.call_soon_threadsafe(self.end, reason)

    def end(self, reason: str) -> None:
        """Ends all followers, on the event loop."""
        for follower in self._followers:
            follower.end(reason)

    def join(self, radiometric: bool = False) -> Follower:
        """Returns a new follower, which `leave` takes back. Raises FeedRefused where there are too many."""
        if len(self._followers) >= MAX_FOLLOWERS:
            raise FeedRefused(f"the truth has its {MAX_FOLLOWERS} clients; try again later")
        follower = Follower(radiometric)
        self._followers.add(follower)
        return follower

    def leave(self, follower: Follower) -> None:
        """Forgets a follower."""
        self._followers.discard(follower)

    async def lines(self, follower: Follower) -> AsyncIterator[str]:
        """Yields the lines for a follower: a header for each scene, then what happens from now on."""
        header, waiting = "", deque[TruthLine]()
        position: tuple[SpokeSource, int, int] | None = None
        before = 0.0
        sent: SentSpokes | None = SentSpokes(self._spoke_source, -1, 0.0, 0.0, False)
        while sent is not None:
            if (sent.spoke_source, sent.scan, sent.commands) != position:
                first = await self._asked(sent.spoke_source, None)
                if first and first[0].text != header:
                    header = first[0].text
                    yield header
                scan = []
                if sent.scan >= 0:
                    scan = await self._asked(sent.spoke_source, sent.scan, sent.commands, follower.radiometric)
                goes_on = position is not None and position[:2] == (sent.spoke_source, sent.scan)
                since = before if goes_on else sent.first  # where commands have changed the rest of the scan
                waiting = deque(line for line in scan if line.time >= since)
                position = sent.spoke_source, sent.scan, sent.commands
            while waiting and (sent.ends or waiting[0].time <= sent.last):
                yield self._completed(sent.spoke_source, waiting.popleft())
            before = math.nextafter(sent.last, math.inf)  # all lines until `last` are sent
            sent = await follower.next()

    def _put(self, sent: SentSpokes) -> None:
        for follower in self._followers:
            follower.put(sent)

    async def _asked(
        self, spoke_source: SpokeSource, scan: int | None, commands: int = 0, radiometric: bool = False
    ) -> list[TruthLine]:
        """The lines of a scan after so many commands, or the header; none where the source fails, which another one
        replaces."""
        key = spoke_source, scan, commands, radiometric
        if key not in self._kept:
            loop = asyncio.get_running_loop()
            self._kept[key] = asyncio.ensure_future(
                loop.run_in_executor(self._pool, spoke_source.truth_lines, scan, radiometric)
            )
            while len(self._kept) > MAX_KEPT:
                del self._kept[next(iter(self._kept))]
        with contextlib.suppress(SpokeSourceFault):
            return await asyncio.shield(self._kept[key])
        self._kept.pop(key, None)
        return []


class FeedTruth(SpokeSink):
    """Sends the truth of TRUTHS_PER_SCAN instants of each scan to the clients that request it, in order.

    What a radar's process does not answer, because it has died or is slow, is announced as missing. Truths that wait when
    their epoch ends are not sent. A sink after the feed. Belongs to the event loop, but for the methods of sinks.

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

    @override
    def open_epoch(self, radar: RadarInfo) -> None:
        """Lets the hub tell which epoch runs."""

    @override
    def send(self, batch: SpokeBatch) -> None:
        """Asks for the truth at instants of spokes that were sent, if a client requests it."""
        if self._hub.truth_codecs and self._loop:
            epoch, block = batch.epoch, batch.block
            every = max(1, epoch.info.radar.azimuths // TRUTHS_PER_SCAN)
            due = [float(time) for k, time in enumerate(block.time) if (block.index + k) % every == 0]
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

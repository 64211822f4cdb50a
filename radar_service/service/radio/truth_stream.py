"""The stream of the truth: each beam crossing once its spokes have been sent, and all bodies at the end of each scan."""

import asyncio
import contextlib
import math
from collections import deque
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Executor
from typing import NamedTuple

from typing_extensions import override

from radar_service.service.fanout.client_queue import GOING_AWAY, TOO_SLOW
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink
from radar_service.spoke_source import SpokeSource, SpokeSourceFault, TruthLine

MAX_FOLLOWERS = 16
MAX_BEHIND = 4096  # batches: a minute at 15 ms each
MAX_KEPT = 4  # scans whose lines are kept, so that several followers ask for them once


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

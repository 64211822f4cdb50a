"""A listener's mailbox: bounded, and what it loses it announces in the place of what was lost."""

import asyncio
import itertools
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from radar_service.stream import wire
from radar_service.stream.websocket import Write, frame

_NUMBERS = itertools.count(1)

Mode = Literal["live", "lossless"]

MAILBOX_MESSAGES = 64  # about a second of batches at 15 ms
MAILBOX_BYTES = 4 * 2**20
TRAILING_BYTES = 64 * 2**10  # for a client that has lost something, until it has caught up: the kernel holds 0.4 MB already
MAILBOX_NOTICES = 256  # hellos, gaps and the like, which cannot be dropped: more means a client that does not read
GOING_AWAY, TOO_SLOW = 1001, 4408  # websocket close codes


@dataclass(frozen=True)
class View:
    """What a client wants to see; bins None is one for every cell.

    sector: true bearings [degrees] from and to, clockwise, None all; spokes: how many neighbouring azimuths at most are
    merged by their peaks; compression: of the samples, "" none.
    """

    encoding: str
    bins: int | None = None
    sector: tuple[int, int] | None = None
    spokes: int = 1
    compression: str = ""

    def as_dict(self) -> dict[str, object]:
        """What is shaped of it, in plain data."""
        return {"sector_deg": self.sector and list(self.sector), "spokes": self.spokes, "compression": self.compression}


@dataclass(frozen=True)
class Item:
    """A message for clients. count > 0: spokes first to first + count; droppable: a slow client may miss it."""

    data: bytes
    epoch: str
    first: int = 0
    count: int = 0
    droppable: bool = False

    @cached_property
    def frame(self) -> bytes:
        """The message as it goes over a websocket, made when the first client takes it."""
        return frame(self.data)


def gap(epoch: str, first: int, count: int, reason: str) -> Item:
    """The message that announces spokes which this client will not get."""
    message = {"type": "gap", "epoch": epoch, "first": first, "count": count, "reason": reason}
    return Item(wire.pack(message), epoch, first, count)


class Client:
    """One listener's mailbox. `counts`: spokes put in, spokes lost."""

    def __init__(
        self, view: View, mode: Mode = "live", truth: bool = False, messages: int = MAILBOX_MESSAGES,
        size: int = MAILBOX_BYTES,
    ) -> None:  # fmt: skip
        self.view, self.mode, self.truth = view, mode, truth
        self.number = next(_NUMBERS)  # by which a line of the journal names it
        self.delivered = self.lost = 0  # spokes
        self.gaps = 0  # announced for what it was too slow for
        self.bytes = 0  # taken out
        self.closed = False  # nothing more comes after what is queued
        self.code = GOING_AWAY  # websocket close code, once closed
        self._over = asyncio.Event()
        self._messages, self._size = messages, size
        self._queue: deque[Item] = deque()
        self._droppable = self._bytes = 0
        self._trailing = False  # it has lost something, and has not caught up since
        self.write: Write | None = None  # straight to the client, past an empty mailbox
        self._reader: asyncio.Future[None] | None = None  # who waits for a message
        self._room = asyncio.Event()
        self._backlog: deque[Item] = deque()  # hello and history, ahead of the queue and outside its bounds
        self.started = False  # whether it has been given a number, so that a jump would be a loss

    @property
    def full(self) -> bool:
        """Whether one more batch would exceed a bound; a single batch always fits."""
        most = min(self._size, TRAILING_BYTES) if self._trailing else self._size
        return self._droppable >= self._messages or (self._droppable > 0 and self._bytes >= most)

    def put(self, item: Item) -> None:
        """Queue a message; where the bounds are exceeded the oldest batches make room.

        Who loses something has stalled: it keeps only the newest, so that when it reads again it soon sees the present.
        """
        if self.closed or self._written(item):
            return
        while item.droppable and self.full:
            self._trailing = self.mode == "live"
            self._drop_oldest()
        self._append(item)
        if len(self._queue) - self._droppable > MAILBOX_NOTICES:
            self.end(wire.pack({"type": "bye", "epoch": item.epoch, "reason": "this client does not read"}), TOO_SLOW)

    def end(self, last: bytes, code: int = GOING_AWAY) -> None:
        """Forget what is queued, say `last`, and take no more."""
        if self.closed:
            return
        self._queue.clear()
        self._backlog.clear()
        self._droppable = self._bytes = 0
        self._append(Item(last, ""))
        self.closed, self.code = True, code
        self._room.set()
        self._over.set()

    async def over(self) -> None:
        """Wait until the client has been ended."""
        await self._over.wait()

    def begin(self, items: Iterable[Item]) -> None:
        """What comes before everything else: the hello, and history to catch up with (shared bytes, so not bounded here)."""
        self._backlog.extend(items)
        self.started = any(item.count for item in self._backlog)
        self._wake()

    async def get(self) -> Item | None:
        """The next message, or None after the last one."""
        while not self._queue and not self._backlog:
            if self.closed:
                return None
            self._reader = asyncio.get_running_loop().create_future()
            await self._reader
        if self._backlog:
            item = self._backlog.popleft()
            self.bytes += len(item.data)
            return item
        item = self._queue.popleft()
        self._trailing = self._trailing and bool(self._queue)
        self.bytes += len(item.data)
        if item.droppable:
            self._droppable -= 1
            self._bytes -= len(item.data)
            self.delivered += item.count
        self._room.set()
        return item

    async def room(self) -> None:
        """Wait until a batch fits without loss, or the client is gone."""
        while self.full and not self.closed:
            self._room.clear()
            await self._room.wait()

    def _written(self, item: Item) -> bool:
        """Whether the message has gone straight to the client, which waits for it and has room."""
        waits = self._reader is not None and not (self._reader.done() or self._queue or self._backlog)
        if self.write is None or not waits or not self.write(item.frame):
            return False
        self.started = self.started or item.count > 0
        self.bytes += len(item.data)
        self.delivered += item.count if item.droppable else 0
        return True

    def _wake(self) -> None:
        if self._reader is not None and not self._reader.done():
            self._reader.set_result(None)

    def _append(self, item: Item) -> None:
        self._queue.append(item)
        self.started = self.started or item.count > 0
        if item.droppable:
            self._droppable += 1
            self._bytes += len(item.data)
        self._wake()

    def _drop_oldest(self) -> None:
        at = next(i for i, item in enumerate(self._queue) if item.droppable)
        item = self._queue[at]
        self._droppable -= 1
        self._bytes -= len(item.data)
        self.lost += item.count
        if not item.count:
            del self._queue[at]
            return
        before = self._queue[at - 1] if at else None
        first = item.first
        if (
            before and before.count
        ):  # a gap, and what it announces ends where this begins: another epoch's has a hello between
            del self._queue[at]
            at, first = at - 1, before.first
        else:
            self.gaps += 1
        self._queue[at] = gap(item.epoch, first, item.first + item.count - first, "this client is too slow")

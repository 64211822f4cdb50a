"""The queue of one client: bounded, with a gap message in place of lost spokes."""

import asyncio
import contextlib
import itertools
import math
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

from radar_service.service.codecs.codec import CODECS, Codec
from radar_service.service.feed_request import Mode, View

_NUMBERS = itertools.count(1)

QUEUE_MESSAGES = 64  # about a second of batches at 15 ms
QUEUE_BYTES = 4 * 2**20
CATCH_UP_BYTES = 64 * 2**10  # of a client that has lost batches, until its queue is empty: the kernel holds 0.4 MB already
QUEUE_NOTICES = 256  # hellos, gaps and the like, which are never dropped: a client with more does not read
GOING_AWAY, TOO_SLOW, FULL = 1001, 4408, 4503  # websocket close codes
GRACE = 1.0  # s for the last messages to leave where the server stops, or a client sends too much or nothing
FLUSH = 10.0  # s for them in all other cases: a slow client may read a megabyte before them
NOT_TAKEN = "this client did not take them before the end"
FINAL_BINARY = 0x82  # a binary message in one frame

Write = Callable[[bytes], bool]  # writes a frame at once; returns whether it did


@dataclass(frozen=True)
class QueueItem:
    """A message for clients.

    count > 0: it covers spokes first to first + count; droppable: a slow client may lose it; data b"": the protocol has
    no such message, so it counts but is not sent.
    """

    data: bytes
    epoch: str
    first: int = 0
    count: int = 0
    droppable: bool = False

    @cached_property
    def frame(self) -> bytes:
        """The message as a websocket frame, encoded when the first client takes it; the server's library would do it for each.

        Its head has 2, 4 or 10 bytes (RFC 6455, section 5.2), and nothing in it depends on the client.
        """
        size = len(self.data)
        if size < 126:
            return bytes((FINAL_BINARY, size)) + self.data
        if size < 2**16:
            return bytes((FINAL_BINARY, 126)) + size.to_bytes(2) + self.data
        return bytes((FINAL_BINARY, 127)) + size.to_bytes(8) + self.data


def gap(codec: Codec, epoch: str, first: int, count: int, reason: str) -> QueueItem:
    """Returns the message that announces spokes which this client will not receive."""
    return QueueItem(codec.gap(epoch, first, count, reason), epoch, first, count)


class ClientQueue:
    """The queue between the hub and one client. Belongs to the event loop: no locks, no other threads.

    delivered: number of delivered spokes.
    lost: number of lost spokes.
    gaps: announced because the client was too slow.
    bytes: taken by the client.
    closed: whether nothing comes after the queued messages.
    code: websocket close code, once closed.
    owner: address of the client's machine, "" where it is not known.
    started: whether the client has a sequence number, or was promised one; after that a jump is a loss.
    write: sends a frame directly, past an empty queue, where the server can do that; is_held: whether it may not do so now.
    """

    def __init__(
        self, view: View, mode: Mode = "live", truth: bool = False, messages: int = QUEUE_MESSAGES, size: int = QUEUE_BYTES,
        owner: str = "",
    ) -> None:  # fmt: skip
        self.view, self.mode, self.truth, self.owner = view, mode, truth, owner
        self.codec = CODECS[view.codec]
        self.number = next(_NUMBERS)  # names the client in log lines
        self.delivered = self.lost = self.gaps = self.bytes = 0
        self.closed, self.code = False, GOING_AWAY
        self.started = False
        self.write: Write | None = None
        self.is_held: Callable[[], bool] = lambda: False
        self._messages, self._size = messages, size
        self._queue: deque[QueueItem] = deque()
        self._backlog: deque[QueueItem] = deque()  # hello and history: before the queue and outside its bounds
        self._batches = self._batch_bytes = 0  # of the droppable items in the queue
        self._catching_up = False
        self._taken: QueueItem | None = None  # by `get`, and not sent as far as is known
        self._reader: asyncio.Future[None] | None = None  # waits for a message
        self._room, self._ended = asyncio.Event(), asyncio.Event()
        self._end_time = math.inf  # when what waits may no longer be taken [s of the event loop]

    @property
    def full(self) -> bool:
        """Whether one more batch would exceed a bound; a single batch always fits."""
        maximum = min(self._size, CATCH_UP_BYTES) if self._catching_up else self._size
        return self._batches >= self._messages or (self._batches > 0 and self._batch_bytes >= maximum)

    @property
    def queued(self) -> int:
        """Number of messages that the client has not taken."""
        return len(self._backlog) + len(self._queue)

    @property
    def waiting(self) -> tuple[QueueItem, ...]:
        """The messages that the client has not taken, in order."""
        return (*self._backlog, *self._queue)

    def put(self, item: QueueItem) -> None:
        """Queues a message; where a bound is exceeded a live client loses its oldest batches first.

        A client that loses batches keeps only the newest ones, so that it soon shows the present when it reads again. A lossless
        one loses nothing here: the producer waits for its room.
        """
        if self.closed or self._write_directly(item):
            return
        while item.droppable and self.mode == "live" and self.full:
            self._catching_up = True
            self._drop_oldest()
        self._append(item)
        if len(self._queue) - self._batches > QUEUE_NOTICES:
            self.end(self.codec.bye(item.epoch, "this client does not read"), TOO_SLOW)

    def end(self, last: bytes, code: int = GOING_AWAY, within: float = 0.0) -> None:
        """Queues the message `last`, and takes no more. What waits may be taken for `within` [s]; then `rest` is to be sent.

        Another call can only shorten that time.
        """
        if not self.closed:
            self._append(QueueItem(last, ""))
            self.code = code
            self.close()
        self._end_time = min(self._end_time, asyncio.get_running_loop().time() + within)
        self._ended.set()

    def close(self) -> None:
        """Takes no more messages; callers that wait for room continue."""
        self.closed = True
        self._room.set()

    async def ended(self) -> None:
        """Waits until `end` was called and its time is over."""
        await self._ended.wait()
        while (left := self._end_time - asyncio.get_running_loop().time()) > 0.0:
            self._ended.clear()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(left):
                    await self._ended.wait()

    def rest(self) -> list[QueueItem]:
        """Takes all that was not sent, with gaps in place of the spokes. The caller of `get` has stopped."""
        waiting = [item for item in (self._taken, *self.waiting) if item is not None]
        if self._taken is not None and self._taken.droppable:
            self.delivered -= self._taken.count
        self._taken, self._batches, self._batch_bytes = None, 0, 0
        self._backlog.clear()
        self._queue.clear()
        rest: list[QueueItem] = []
        for item in waiting:
            if not item.droppable:
                rest.append(item)
            elif item.count and rest and rest[-1].count:
                rest[-1] = self._loss(item, rest[-1], NOT_TAKEN)
            elif item.count:
                rest.append(self._loss(item, None, NOT_TAKEN))
        return rest

    def begin(self, items: Iterable[QueueItem], since: bool = False) -> None:
        """Queues what comes before all else: the hello and the history (shared bytes, so not bounded here).

        since: whether the client was promised all numbers after these.
        """
        self._backlog.extend(items)
        self.started = since
        self._wake_reader()

    async def get(self) -> QueueItem | None:
        """Returns the next message, None after the last one. The one before counts as sent."""
        self._taken = None
        while not self._queue and not self._backlog:
            if self.closed:
                return None
            self._reader = asyncio.get_running_loop().create_future()
            await self._reader
        if self._backlog:
            item = self._taken = self._backlog.popleft()
            self.bytes += len(item.data)
            return item
        item = self._taken = self._queue.popleft()
        self._catching_up = self._catching_up and bool(self._queue)
        self.bytes += len(item.data)
        if item.droppable:
            self._batches -= 1
            self._batch_bytes -= len(item.data)
            self.delivered += item.count
        self._room.set()
        return item

    async def room(self) -> None:
        """Waits until a batch fits without loss, or the client has gone."""
        while self.full and not self.closed:
            self._room.clear()
            await self._room.wait()

    def _write_directly(self, item: QueueItem) -> bool:
        """Sends the message without the queue where the client waits for it and the socket has room."""
        is_waited_for = self._reader is not None and not (self._reader.done() or self._queue or self._backlog)
        if self.write is None or not (is_waited_for and item.data) or self.is_held() or not self.write(item.frame):
            return False
        self.started = self.started or item.count > 0
        self.bytes += len(item.data)
        self.delivered += item.count if item.droppable else 0
        return True

    def _wake_reader(self) -> None:
        if self._reader is not None and not self._reader.done():
            self._reader.set_result(None)

    def _append(self, item: QueueItem) -> None:
        self._queue.append(item)
        self.started = self.started or item.count > 0
        if item.droppable:
            self._batches += 1
            self._batch_bytes += len(item.data)
        self._wake_reader()

    def _drop_oldest(self) -> None:
        """Replaces the oldest batch by a gap, or extends the gap before it."""
        at = next(i for i, item in enumerate(self._queue) if item.droppable)
        item = self._queue[at]
        self._batches -= 1
        self._batch_bytes -= len(item.data)
        before = self._queue[at - 1] if at else None
        if not item.count:
            del self._queue[at]
        elif before and before.count:  # a gap that ends where this batch begins; a hello separates two epochs
            del self._queue[at]
            self._queue[at - 1] = self._loss(item, before, "this client is too slow")
        else:
            self._queue[at] = self._loss(item, None, "this client is too slow")

    def _loss(self, item: QueueItem, before: QueueItem | None, reason: str) -> QueueItem:
        """Counts a batch as lost; returns the gap in its place, which includes the gap `before` it."""
        self.lost += item.count
        self.gaps += before is None
        first = before.first if before else item.first
        return gap(self.codec, item.epoch, first, item.first + item.count - first, reason)

"""One producer, many clients: a bounded mailbox for each, every view encoded once, a bounded history to resume from.

The rules, all of them testable without a socket:
1. A view is an encoding, a number of bins, a sector, a merging, a packing. A batch is encoded once per
   view, whoever asks; clients share the bytes.
2. A `live` client that falls behind loses whole batches, oldest first, and finds a gap in their place.
3. A `lossless` client makes the producer wait, at most PATIENCE; then it is told `bye` and let go.
4. Sequence numbers count spokes within an epoch. A gap names exactly the numbers that this client will not see.
Everything here runs on the event loop; the producer's thread only reads `views`, an immutable tuple, and `truth_wanted`.
"""

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from radar_service.stream import wire
from radar_service.stream.mailbox import TOO_SLOW, Client, Item, Mode, View, gap
from radar_service.stream.shape import cut

PATIENCE = 10.0  # s that a lossless client may hold up the simulation
HISTORY_BYTES = 16 * 2**20  # per view: about a minute of 1 KiB spokes at 24 rpm and 720 azimuths
MAX_VIEWS = 16  # each costs the producer an encoding
MAX_CLIENTS = 500
LINGER = 30.0  # s that a view without clients is still encoded, so that whoever reconnects finds no hole


@dataclass(frozen=True)
class Batch:
    """Some consecutive spokes of an epoch, encoded for each view; truth, if any, goes ahead of them to who may have it."""

    epoch: str
    first: int
    count: int
    data: Mapping[View, bytes]
    truth: tuple[bytes, ...] = ()


class Refused(Exception):
    """A client that cannot be served. Its text says why and what to do."""


@dataclass
class _Kept:
    """What the hub remembers of a view: encoded batches of the running epoch, and when a client last had it."""

    history: deque[Item] = field(default_factory=deque)
    size: int = 0
    idle_since: float | None = None

    def keep(self, item: Item) -> None:
        self.history.append(item)
        self.size += len(item.data)
        while self.size > HISTORY_BYTES and len(self.history) > 1:
            self.size -= len(self.history.popleft().data)


class Hub:
    """The clients of one radar. `hello(view, mode)` gives the running epoch's first message for a client, packed."""

    def __init__(self, clock: Callable[[], float], patience: float = PATIENCE, max_clients: int = MAX_CLIENTS) -> None:
        self.clients: set[Client] = set()
        self.views: tuple[View, ...] = ()  # what the producer encodes; replaced whole
        self.epoch = ""
        self.next = 0  # sequence number of the next spoke
        self.lost = self.gaps = self.bytes = 0  # of clients now gone: spokes lost, gaps announced, bytes taken
        self.truth_wanted = False  # by some client; read by the producer
        self._hello: Callable[[View, Mode], bytes] | None = None
        self._kept: dict[View, _Kept] = {}
        self._left = asyncio.Event()
        self._clock, self._patience, self._max_clients = clock, patience, max_clients

    def open_epoch(self, epoch: str, hello: Callable[[View, Mode], bytes]) -> None:
        """Begin an epoch: history is forgotten, every client gets its hello, numbers start at 0."""
        self.epoch, self.next, self._hello = epoch, 0, hello
        for kept in self._kept.values():
            kept.history.clear()
            kept.size = 0
        for client in self.clients:
            client.put(Item(hello(client.view, client.mode), epoch))
            client.started = True  # from here on it has a right to every number

    def join(self, client: Client, since: tuple[str, int] | None = None) -> None:
        """Add a client: hello, then what it missed since (epoch, next number wanted) or a gap, then what comes.

        `since` from another epoch means all of this one. Raises Refused when the radar has not begun or is full.
        """
        if self._hello is None:
            raise Refused("the radar is starting; try again in a moment")
        if len(self.clients) >= self._max_clients:
            raise Refused(f"the radar has its {self._max_clients} clients; try again later")
        self._want(client.view)
        client.begin([Item(self._hello(client.view, client.mode), self.epoch), *self._missed(client.view, since)])
        self.clients.add(client)
        self.truth_wanted = self.truth_wanted or client.truth

    def leave(self, client: Client) -> None:
        """Remove a client; its view lingers for whoever reconnects."""
        self.clients.discard(client)
        self._left.set()
        self.truth_wanted = any(other.truth for other in self.clients)
        self.lost, self.gaps, self.bytes = self.lost + client.lost, self.gaps + client.gaps, self.bytes + client.bytes
        client.closed = True
        client._room.set()
        if all(other.view != client.view for other in self.clients) and client.view in self._kept:
            self._kept[client.view].idle_since = self._clock()

    async def publish(self, batch: Batch) -> None:
        """Hand a batch to every client, waiting for the lossless ones. Batches of an epoch that is over are ignored."""
        await self._wait_for_lossless()
        if batch.epoch != self.epoch:
            return
        items = {view: Item(data, batch.epoch, batch.first, batch.count, True) for view, data in batch.data.items()}
        for view, item in items.items():
            if view in self._kept:
                self._kept[view].keep(replace(item))  # its own, for the one on its way also holds a frame
        truths = [Item(state, batch.epoch, droppable=True) for state in batch.truth]
        for client in self.clients:
            for state in truths if client.truth else ():
                client.put(state)
            self._deliver(client, batch, items.get(client.view))
        self.next = batch.first + batch.count
        self._forget_idle_views()

    def skip(self, epoch: str, count: int, reason: str) -> None:
        """Announce to everybody that the next spokes of this epoch will never come."""
        if epoch != self.epoch or count <= 0:
            return
        lost = gap(epoch, self.next, count, reason)
        for kept in self._kept.values():
            kept.keep(lost)
        for client in self.clients:
            client.put(lost)
        self.next += count

    def close(self, reason: str) -> None:
        """Say bye to every client."""
        for client in list(self.clients):
            client.end(wire.pack({"type": "bye", "epoch": self.epoch, "reason": reason}))

    async def emptied(self, timeout: float) -> None:
        """Wait until every client has left, at most that long [s]."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while self.clients:
                    self._left.clear()
                    await self._left.wait()

    def _deliver(self, client: Client, batch: Batch, item: Item | None) -> None:
        if item is not None:
            client.put(item)
        elif client.started:  # it came back while this batch was being encoded without its view
            client.put(gap(batch.epoch, batch.first, batch.count, "sent before this view was asked for"))

    async def _wait_for_lossless(self) -> None:
        full = [client for client in self.clients if client.mode == "lossless" and client.full]
        if not full:
            return
        waits = {asyncio.ensure_future(client.room()): client for client in full}
        _, late = await asyncio.wait(waits, timeout=self._patience)
        for task in late:
            task.cancel()
            reason = f"lossless: nothing was read for {self._patience:g} s; read faster, or resume with since"
            waits[task].end(wire.pack({"type": "bye", "epoch": self.epoch, "reason": reason}), TOO_SLOW)
            self.clients.discard(waits[task])

    def _want(self, view: View) -> None:
        if view not in self._kept and len(self._kept) >= MAX_VIEWS:
            self._make_room_for_view()
        self._kept.setdefault(view, _Kept()).idle_since = None
        self.views = tuple(self._kept)

    def _make_room_for_view(self) -> None:
        idle = [(kept.idle_since, view) for view, kept in self._kept.items() if kept.idle_since is not None]
        if not idle:
            raise Refused(f"{MAX_VIEWS} different views are being served; ask for an encoding and bins that others have")
        del self._kept[min(idle, key=lambda pair: pair[0])[1]]

    def _forget_idle_views(self) -> None:
        now = self._clock()
        old = [v for v, kept in self._kept.items() if kept.idle_since is not None and now - kept.idle_since > LINGER]
        for view in old:
            del self._kept[view]
        if old:
            self.views = tuple(self._kept)

    def _missed(self, view: View, since: tuple[str, int] | None) -> list[Item]:
        if since is None:
            return []
        wanted = min(since[1], self.next) if since[0] == self.epoch else 0
        held = [item for item in self._kept[view].history if item.first + item.count > wanted]
        start = held[0].first if held else self.next
        if start > wanted:
            return [gap(self.epoch, wanted, start - wanted, "no longer held"), *held]
        if held and start < wanted:
            held[0] = self._rest(held[0], wanted)
        return held

    def _rest(self, item: Item, wanted: int) -> Item:
        """The part of a kept message from number `wanted` on."""
        count = item.first + item.count - wanted
        if not item.droppable:
            return gap(self.epoch, wanted, count, "the radar did not make them")
        return Item(wire.pack(cut(wire.unpack(item.data), count)), self.epoch, wanted, count, True)

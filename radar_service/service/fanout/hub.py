"""The feed as a sink: one producer, many clients; one encoding for each view, a bounded queue for each client, a history.

The rules; each can be tested without a socket:
1. A batch is encoded once for each view. Clients with equal views share the bytes.
2. A `live` client that falls behind loses whole batches, oldest first, and receives a gap in their position.
3. A `lossless` client makes the producer wait, at most PATIENCE; then it receives `bye` and is disconnected. So does one
   that makes others wait for longer by reading slower than FLOOR.
4. Sequence numbers count spokes within an epoch. A gap names exactly the numbers that this client will not receive.
5. Before a `bye` a client receives what waits for it, within DRAIN; a gap stands for the rest.
The hub belongs to the event loop. The producer's thread only reads `views` and `truth_codecs`, immutable tuples that are
replaced whole.

An owner of views is the address of the machine that clients come from.
"""

import asyncio
import contextlib
from collections import defaultdict, deque
from collections.abc import Callable, Coroutine, Iterable, Mapping, Set
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_
from typing import Any

from radar_service.records import SourceRequest
from radar_service.service.codecs.codec import CODECS, Codec
from radar_service.service.fanout.client_queue import FLUSH, FULL, TOO_SLOW, ClientQueue, QueueItem, gap
from radar_service.service.feed_request import Mode, View
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch

PATIENCE = 10.0  # s that a lossless client may delay the simulation
WINDOW = 10.0  # s over which a client is judged
FLOOR = 0.5  # of the spokes of real time: below it, the others see the radar at less than half its speed
MAX_OWN_VIEWS = 8  # of one address, not counting those that clients of other addresses have too
MAX_VIEWS = 16  # each costs the producer an encoding
MAX_CLIENTS = 500
DRAIN: Mapping[Mode, float] = {"live": 2.0, "lossless": PATIENCE}  # s to take what waits before a `bye`
STOP_DRAIN: Mapping[Mode, float] = {"live": 0.5, "lossless": 0.5}  # s for clients to take it when the server stops
HISTORY_BYTES = 4 * 2**20  # per view: 14 s of 1 KiB spokes at 24 rpm and 720 azimuths
LINGER = 30.0  # s that a view without clients is still encoded, so that a client that reconnects misses nothing


class DelayAccount:
    """The delays that one client causes, from `now` [s] on. delivered: number of spokes that it has received so far."""

    def __init__(self, now: float, delivered: int) -> None:
        self._since, self._delivered, self._waited = now, delivered, 0.0

    def add(self, waited: float) -> None:
        """Adds a time [s] that the radar has waited for this client alone."""
        self._waited += waited

    def is_too_slow(self, now: float, delivered: int, spoke_period: float) -> bool:
        """Returns whether, over the last WINDOW, it was waited for most of the time and took less than FLOOR of real time.

        spoke_period: of the radar in real time [s]. Judges once for each WINDOW.
        """
        elapsed = now - self._since
        if elapsed < WINDOW:
            return False
        is_waited_for = self._waited > elapsed / 2.0
        is_below_floor = (delivered - self._delivered) * spoke_period < FLOOR * elapsed
        self._since, self._delivered, self._waited = now, delivered, 0.0
        return is_waited_for and is_below_floor


class Delays:
    """The waits of a radar for its lossless clients, on its event loop."""

    def __init__(self, clock: Callable[[], float], patience: float = PATIENCE) -> None:
        self._clock, self._patience = clock, patience
        self._accounts: dict[ClientQueue, DelayAccount] = {}

    def forget(self, client: ClientQueue) -> None:
        """Forgets a client that has left."""
        self._accounts.pop(client, None)

    async def wait(self, clients: Set[ClientQueue], spoke_period: float) -> dict[ClientQueue, str]:
        """Waits until the lossless ones of all clients have room; returns those to disconnect, each with the reason.

        These are clients that read nothing, and those that others wait for too long; alone, a client may take its time.
        spoke_period: of the radar in real time [s].
        """
        full = [client for client in clients if client.mode == "lossless" and client.full]
        if not full:
            return {}
        waits = {asyncio.ensure_future(self._wait_for(client)): client for client in full}
        _, late = await asyncio.wait(waits, timeout=self._patience)
        for task in late:
            task.cancel()
        reason = f"nothing was read for {self._patience:g} s; read faster, or resume with since"
        ends = {waits[task]: reason for task in late}
        for client in full:
            if client not in ends and len(clients - ends.keys()) > 1 and self._is_too_slow(client, spoke_period):
                reason = f"for {WINDOW:g} s you have read less than {100 * FLOOR:g} % of real time, and others wait for you"
                ends[client] = f"{reason}; request mode=live, or a smaller view"
        return ends

    async def _wait_for(self, client: ClientQueue) -> None:
        if client.closed:  # it has left since
            return
        began = self._clock()
        account = self._accounts.setdefault(client, DelayAccount(began, client.delivered))
        await client.room()
        account.add(self._clock() - began)

    def _is_too_slow(self, client: ClientQueue, spoke_period: float) -> bool:
        account = self._accounts.get(client)  # none of a client that has left meanwhile
        return account is not None and account.is_too_slow(self._clock(), client.delivered, spoke_period)


def own_views(clients: Iterable[ClientQueue]) -> dict[str, list[View]]:
    """Returns for each owner the views that only it has, the one with the newest client last."""
    owners: dict[View, set[str]] = defaultdict(set)
    newest: dict[View, int] = {}
    for client in clients:
        owners[client.view].add(client.owner)
        newest[client.view] = max(client.number, newest.get(client.view, 0))
    views: dict[str, list[View]] = defaultdict(list)
    for view in sorted(newest, key=newest.__getitem__):
        if len(owners[view]) == 1:
            views[next(iter(owners[view]))].append(view)
    return views


def view_to_give(clients: Iterable[ClientQueue], owner: str) -> View | None:
    """Returns the view that the owner with the most gives up for `owner`; None where that one would not have fewer."""
    views = own_views(clients)
    most = max(views, key=lambda other: len(views[other]), default="")
    return views[most][-1] if most != owner and len(views[most]) > len(views[owner]) + 1 else None


@dataclass(frozen=True)
class EncodedBatch:
    """Consecutive spokes of an epoch, encoded for each view."""

    epoch: str
    first: int
    count: int
    data: Mapping[View, bytes]


@dataclass(frozen=True)
class ClientTotals:
    """Sums over all clients since the start: spokes lost, gaps announced, bytes taken."""

    lost: int = 0
    gaps: int = 0
    bytes: int = 0

    def with_client(self, client: ClientQueue) -> "ClientTotals":
        """Returns the sums with one more client."""
        return ClientTotals(self.lost + client.lost, self.gaps + client.gaps, self.bytes + client.bytes)


class FeedRefused(Exception):
    """A client that cannot be served. The text says why and what to do."""


class ViewHistory:
    """The newest messages of the running epoch in one view, at most HISTORY_BYTES of them.

    idle_since: time when the last client of the view left [s of the hub's clock], None while there is one.
    """

    def __init__(self, codec: Codec) -> None:
        self.idle_since: float | None = None
        self._codec = codec
        self._items: deque[QueueItem] = deque()
        self._size = 0

    def add(self, item: QueueItem) -> None:
        """Keeps a message and drops the oldest ones beyond the bound."""
        self._items.append(item)
        self._size += len(item.data)
        while self._size > HISTORY_BYTES and len(self._items) > 1:
            self._size -= len(self._items.popleft().data)

    def clear(self) -> None:
        """Drops all messages."""
        self._items.clear()
        self._size = 0

    def since(self, epoch: str, first: int, end: int) -> list[QueueItem]:
        """Returns the messages that cover the sequence numbers from `first` to `end`, with a gap for those not kept."""
        kept = [item for item in self._items if item.first + item.count > first]
        start = kept[0].first if kept else end
        if start > first:
            return [gap(self._codec, epoch, first, start - first, "no longer held"), *kept]
        if kept and start < first:
            kept[0] = self._rest(kept[0], epoch, first)
        return kept

    def _rest(self, item: QueueItem, epoch: str, first: int) -> QueueItem:
        """Returns the part of a message from the number `first` on."""
        count = item.first + item.count - first
        if not item.droppable:
            return gap(self._codec, epoch, first, count, "the radar did not send them")
        return QueueItem(self._codec.trim(item.data, count), epoch, first, count, True)


class Hub:
    """The clients of one radar.

    clients: those connected.
    views: to be encoded by the producer.
    truth_codecs: protocols with a client that requested truth.
    epoch: name of the running epoch.
    next: sequence number of the next spoke.
    """

    def __init__(self, clock: Callable[[], float], patience: float = PATIENCE, max_clients: int = MAX_CLIENTS) -> None:
        self.clients: set[ClientQueue] = set()
        self.views: tuple[View, ...] = ()
        self.truth_codecs: tuple[str, ...] = ()
        self.epoch = ""
        self.next = 0
        self._departed = ClientTotals()
        self._hello: Callable[[View, Mode], bytes] | None = None
        self._histories: dict[View, ViewHistory] = {}
        self._spoke_period = 0.0
        self._left = asyncio.Event()
        self._clock, self._delays, self._max_clients = clock, Delays(clock, patience), max_clients

    def open_epoch(self, epoch: str, hello: Callable[[View, Mode], bytes], spoke_period: float = 0.0) -> None:
        """Begins an epoch: drops the history, sends every client its hello, and starts numbers at 0.

        hello: returns the first message of the epoch for a view and a mode; spoke_period: in real time [s].
        """
        self.epoch, self.next, self._hello, self._spoke_period = epoch, 0, hello, spoke_period
        for history in self._histories.values():
            history.clear()
        for client in self.clients:
            client.put(QueueItem(hello(client.view, client.mode), epoch))
            client.started = True  # from here on every missing number is a loss

    def join(self, client: ClientQueue, since: tuple[str, int] | None = None) -> None:
        """Adds a client: it receives a hello, then what it missed since (epoch, next number), then new spokes.

        Where `since` names another epoch the client receives all of this one. Raises FeedRefused when the radar has not
        begun or is full.
        """
        if self._hello is None:
            raise FeedRefused("the radar is starting; try again in a moment")
        if len(self.clients) >= self._max_clients:
            raise FeedRefused(f"the radar has its {self._max_clients} clients; try again later")
        history = self._use_view(client)
        missed: list[QueueItem] = []
        if since is not None:
            missed = history.since(self.epoch, min(since[1], self.next) if since[0] == self.epoch else 0, self.next)
        client.begin([QueueItem(self._hello(client.view, client.mode), self.epoch), *missed], since is not None)
        self.clients.add(client)
        self._update_truth_codecs()

    def leave(self, client: ClientQueue) -> None:
        """Removes a client. Its view is encoded a while longer, for a client that reconnects."""
        self.clients.discard(client)
        self._delays.forget(client)
        self._left.set()
        self._update_truth_codecs()
        self._departed = self._departed.with_client(client)
        client.close()
        if all(other.view != client.view for other in self.clients) and client.view in self._histories:
            self._histories[client.view].idle_since = self._clock()

    def totals(self) -> ClientTotals:
        """Returns the sums over all clients, those that have left included."""
        totals = self._departed
        for client in self.clients:
            totals = totals.with_client(client)
        return totals

    async def publish(self, batch: EncodedBatch) -> None:
        """Queues a batch for every client and waits for the lossless ones. Ignores batches of an earlier epoch."""
        for client, reason in (await self._delays.wait(self.clients, self._spoke_period)).items():
            client.end(client.codec.bye(self.epoch, f"lossless: {reason}"), TOO_SLOW)
            self.clients.discard(client)
            self._delays.forget(client)
        if batch.epoch != self.epoch:
            return
        self.skip(batch.epoch, batch.first, 0, "the radar could not send them")
        items = {view: QueueItem(data, batch.epoch, batch.first, batch.count, True) for view, data in batch.data.items()}
        for view, history in self._histories.items():
            history.add(
                replace(items[view]) if view in items else _not_encoded(view, batch)
            )  # a copy without a cached frame
        for client in self.clients:
            if client.view in items:
                client.put(items[client.view])
            elif client.started:  # it returned while this batch was encoded without its view
                client.put(_not_encoded(client.view, batch))
        self.next = batch.first + batch.count
        self._drop_idle_views()

    def tell(self, epoch: str, messages: Iterable[tuple[str, bytes]]) -> None:
        """Queues pairs of codec and message for clients that requested the truth. Ignores those of an earlier epoch."""
        for codec, data in messages if epoch == self.epoch else ():
            item = QueueItem(data, epoch, droppable=True)
            for client in self.clients:
                if client.truth and client.view.codec == codec:
                    client.put(item)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Announces that `count` spokes of this epoch from number `first` on will never come, nor those before that have not."""
        missing = first + count - self.next
        if epoch != self.epoch or missing <= 0:
            return
        gaps = {name: gap(codec, epoch, self.next, missing, reason) for name, codec in CODECS.items()}
        for view, history in self._histories.items():
            history.add(gaps[view.codec])
        for client in self.clients:
            client.put(gaps[client.view.codec])
        self.next += missing

    def close(self, reason: str, within: Mapping[Mode, float] | None = None) -> None:
        """Sends `bye` to every client, after what waits for it. within: times to take that [s], by mode; DRAIN by default."""
        for client in list(self.clients):
            client.end(client.codec.bye(self.epoch, reason), within=(within or DRAIN)[client.mode])

    async def finish(self, reason: str) -> None:
        """Sends `bye` to every client, and waits until all have left, or their time for that is over."""
        self.close(reason)
        await self.emptied(max(DRAIN.values()) + FLUSH)

    async def emptied(self, timeout: float) -> None:
        """Waits until every client has left, at most `timeout` [s]."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while self.clients:
                    self._left.clear()
                    await self._left.wait()

    def _update_truth_codecs(self) -> None:
        self.truth_codecs = tuple({client.view.codec for client in self.clients if client.truth})

    def _use_view(self, client: ClientQueue) -> ViewHistory:
        view = client.view
        if view not in self._histories:
            self._check_own_views(client.owner)
            if len(self._histories) >= MAX_VIEWS:
                self._drop_a_view(client.owner)
        history = self._histories.setdefault(view, ViewHistory(CODECS[view.codec]))
        history.idle_since = None
        self.views = tuple(self._histories)
        return history

    def _check_own_views(self, owner: str) -> None:
        if owner and len(own_views(self.clients).get(owner, ())) >= MAX_OWN_VIEWS:
            raise FeedRefused(f"your address has {MAX_OWN_VIEWS} views of its own; request one that a client has already")

    def _drop_a_view(self, owner: str) -> None:
        """Makes room for a view of that owner: an idle one goes, or one of the owner that has the most."""
        idle = [(kept.idle_since, view) for view, kept in self._histories.items() if kept.idle_since is not None]
        view = min(idle, key=lambda pair: pair[0])[1] if idle else view_to_give(self.clients, owner)
        if view is None:
            raise FeedRefused(f"{MAX_VIEWS} different views are being served; request an encoding and bins that others have")
        for client in [client for client in self.clients if client.view == view]:
            reason = "another address needs a view, and yours has the most"
            client.end(client.codec.bye(self.epoch, reason), FULL, DRAIN[client.mode])
            self.clients.discard(client)
        del self._histories[view]

    def _drop_idle_views(self) -> None:
        now = self._clock()
        old = [v for v, kept in self._histories.items() if kept.idle_since is not None and now - kept.idle_since > LINGER]
        for view in old:
            del self._histories[view]
        if old:
            self.views = tuple(self._histories)


def _not_encoded(view: View, batch: EncodedBatch) -> QueueItem:
    return gap(CODECS[view.codec], batch.epoch, batch.first, batch.count, "encoded before this view was requested")


class FeedEncoder:
    """The sink that encodes spokes for the clients of a hub. Runs in the transmitter's thread; a call returns when the hub has
    done it. `start` comes first and is called on the hub's event loop.
    """

    def __init__(self, hub: Hub, radar_info: Callable[[Epoch], RadarInfo], clock: Callable[[], float]) -> None:
        """radar_info: describes the radar in an epoch for a hello; it is called on the event loop."""
        self._hub, self._radar_info, self._clock = hub, radar_info, clock
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

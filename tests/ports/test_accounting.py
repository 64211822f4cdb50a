"""Each number that the hub has had is received once or announced in one gap, in order, however a feed ends.

The accounts here are kept from the messages alone, not by a client of this project.
"""

import asyncio
import contextlib
import math
import threading
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.records.truth import Truth
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import EncodedBatch, Hub
from radar_service.service.feed_request import View
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import SpokeBatch
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world.scene import Scene
from tests.ports.asgi import Closed, Server, Socket, running
from tests.ports.playing import station as paused
from tests.service.fake import AZIMUTHS, FakeEngine, made_by, scene
from tests.service.fanout.batches import spokes


class Account:
    """The numbers of one client. next: by epoch, the first one that it does not have; None before its first one."""

    def __init__(self) -> None:
        self.epoch = ""
        self.next: dict[str, int | None] = {}
        self.types: list[str] = []
        self.received = self.shift = 0  # shift: of the last number against the number of the spoke from t = 0
        self.truths: list[tuple[float, int]] = []  # time [s] and how many a message stands for

    def take(self, message: dict[str, Any]) -> None:
        """Raises AssertionError for a number that is lost, repeated or out of order, and for a message after `bye`."""
        assert "bye" not in self.types
        self.types.append(message["type"])
        if message["type"] == "hello":
            self.epoch = message["epoch"]
            self.next.setdefault(self.epoch, 0 if self.next else None)
        elif message["type"] in ("spokes", "gap"):
            first, count = message["first"], message["count"]
            assert message["epoch"] == self.epoch and count > 0
            assert self.next[self.epoch] in (None, first), (self.next, message)
            self.next[self.epoch] = first + count
            if message["type"] == "spokes":
                self.received += count
                self.shift = first - message.get("scan", 0) * AZIMUTHS - message["index"]
        elif message["type"] in ("truth", "no_truth"):
            self.truths.append((message["time"], message.get("count", 1)))


PLAIN, LABELS = View("u8"), View("u8", labels=True)
FORMS = [
    ("live", PLAIN, False),
    ("live", PLAIN, True),
    ("live", LABELS, False),
    ("lossless", PLAIN, True),
    ("lossless", LABELS, False),
]
number = st.integers(0, 4)
OPERATIONS = st.lists(
    st.one_of(
        st.tuples(st.just("join"), st.integers(0, len(FORMS) - 1), st.booleans()),
        st.tuples(st.just("read"), number, st.integers(1, 6)),
        st.tuples(st.just("leave"), number, st.just(0)),
        st.tuples(st.just("end"), number, st.booleans()),
        st.tuples(st.just("publish"), st.integers(1, 9), st.booleans()),
        st.tuples(st.just("lose"), st.integers(1, 9), st.just(0)),
        st.tuples(st.just("skip"), st.integers(1, 9), st.just(0)),
        st.tuples(st.just("tell"), st.just(0), st.just(0)),
        st.tuples(st.just("open"), st.just(0), st.just(0)),
    ),
    min_size=5, max_size=40,
)  # fmt: skip


class Connection:
    """Sends what a queue gives, one message for each permit of `room`."""

    def __init__(self, client: ClientQueue, account: Account) -> None:
        self.client, self.account, self.room = client, account, asyncio.Semaphore(0)
        self._sending = asyncio.create_task(self._send())

    async def _send(self) -> None:
        while (item := await self.client.get()) is not None:
            await self.room.acquire()
            self.account.take(wire.unpack(item.data))

    async def cut(self) -> None:
        self._sending.cancel()
        (outcome,) = await asyncio.gather(self._sending, return_exceptions=True)
        assert outcome is None or isinstance(outcome, asyncio.CancelledError), outcome


class Model:
    """A hub with clients that come, read, stall, return, are ended and leave, as `ports.feed` drives them."""

    def __init__(self) -> None:
        self.hub, self.produced, self.epochs = Hub(lambda: 0.0, patience=0.0), 0, 0
        self.clients: list[Connection] = []
        self.ends: dict[ClientQueue, tuple[str, int]] = {}  # epoch and next number when a client was ended
        self.open()

    def open(self, *_: int) -> None:
        self.epochs, self.produced = self.epochs + 1, 0
        name = f"e{self.epochs}"
        self.hub.open_epoch(name, lambda view, mode: wire.pack({"type": "hello", "epoch": name}))

    async def publish(self, count: int, has_labels: bool) -> None:
        """has_labels: whether the batch was encoded for all views, or before that of the labels was requested."""
        data = spokes(self.produced, count, self.hub.epoch)
        views = {view: data for view in self.hub.views if has_labels or not view.labels}
        batch = EncodedBatch(self.hub.epoch, self.produced, count, views)
        self.produced += count
        await self.hub.publish(batch)

    def lose(self, count: int, _: int) -> None:
        """A batch has its numbers, and fails before the hub has it."""
        self.produced += count

    def skip(self, count: int, _: int) -> None:
        self.hub.skip(self.hub.epoch, self.produced, count, "the wheel came off")
        self.produced += count

    def tell(self, *_: int) -> None:
        self.hub.tell(self.hub.epoch, [("native", wire.pack({"type": "truth", "epoch": self.hub.epoch, "time": 0.0}))])

    def join(self, form: int, _: bool, account: Account | None = None) -> None:
        mode, view, truth = FORMS[form]
        client = ClientQueue(view, mode, truth, messages=3)
        since = (account.epoch, account.next[account.epoch] or 0) if account else None
        if account and since:
            account.next[account.epoch] = since[1]
        self.hub.join(client, since)
        account = account or Account()
        if self.hub.next == 0 and not view.labels:
            account.next[self.hub.epoch] = 0  # it gets all of this epoch
        self.clients.append(Connection(client, account))

    async def read(self, which: int, count: int) -> None:
        for connection in self.clients[which : which + 1]:
            for _ in range(count):
                connection.room.release()
                await asyncio.sleep(0)
                await asyncio.sleep(0)

    async def leave(self, which: int, _: int) -> None:
        """The connection breaks, and the client returns with `since`."""
        for connection in self.clients[which : which + 1]:
            client, account = connection.client, connection.account
            if account.epoch and not client.closed:
                await connection.cut()
                self.hub.leave(client)
                self.clients.remove(connection)
                self.join(FORMS.index((client.mode, client.view, client.truth)), False, account)

    def end(self, which: int, is_orderly: bool) -> None:
        for connection in self.clients[which : which + 1]:
            connection.client.end(wire.pack({"type": "bye", "epoch": ""}), within=1e9 if is_orderly else 0.0)

    async def run(self, operations: list[tuple[str, Any, Any]]) -> None:
        """Carries out operations; then all clients are ended, and what they did not read is the rest."""
        for form in range(len(FORMS)):
            self.join(form, False)
        for name, *arguments in operations:
            had, before = (self.hub.epoch, self.hub.next), [(each.client, each.client.closed) for each in self.clients]
            if asyncio.iscoroutine(done := getattr(self, name)(*arguments)):
                await done
            kept = [each.client for each in self.clients if each.client.mode == "lossless" and not each.client.closed]
            assert not any(client.lost for client in kept)
            self.ends |= {client: had for client, was_closed in before if client.closed and not was_closed}
        self.hub.close("that is all")
        for connection in self.clients:
            account = connection.account
            await connection.cut()
            for item in connection.client.rest():
                account.take(wire.unpack(item.data))
            epoch, end = self.ends.get(connection.client, (self.hub.epoch, self.hub.next))
            assert account.types[-1] == "bye" and account.epoch == epoch and account.next[epoch] in (None, end)


@settings(max_examples=60, deadline=None)
@given(OPERATIONS)
@example([("read", 2, 1), ("leave", 2, 0), ("publish", 3, False)])  # it returns while a batch is encoded without its view
@example([*[("publish", 3, True)] * 3, ("tell", 0, 0)])  # a truth for a lossless client whose queue is full
def test_every_number_is_received_or_announced_whatever_happens(operations: list[tuple[str, Any, Any]]) -> None:
    asyncio.run(Model().run(operations))


TRUTHFUL = (2, 4)  # those of QUERIES with truth
QUERIES = ("", "?mode=lossless", "?mode=lossless&truth=1", "?labels=1&powers=256", "?encoding=f32&truth=1")


class Untold(FakeEngine):
    """An engine whose process has died for questions, but still has spokes."""

    def truth(self, t: float) -> Truth:
        raise SpokeSourceFault("its process has ended")


class Slow(FakeEngine):
    """An engine that tells no truth before `answers` is set."""

    def __init__(self, of: Scene) -> None:
        super().__init__(of)
        self.answers = threading.Event()

    def truth(self, t: float) -> Truth:
        assert self.answers.wait(60)
        return super().truth(t)


def station(engine: FakeEngine | None = None, **options: Any) -> Station:
    return paused(engine, settings=Settings(pace=Pace("pause", math.inf)), allow_truth=True, **options)


async def follow(socket: Socket, account: Account, reads: asyncio.Event) -> None:
    """Reads until the server closes the connection, once `reads` is set."""
    await reads.wait()
    try:
        while True:
            account.take(await socket.receive())
    except Closed as closed:
        assert "bye" in account.types and closed.code == 1001


@contextlib.asynccontextmanager
async def playing(only: Station, reads_late: bool = False) -> AsyncIterator[tuple[Server, list[Account]]]:
    """What each kind of client, and one that resumes, has of a radar that the body drives to its end.

    reads_late: whether they read when that is done, and not before.
    """
    accounts, reads = [Account() for _ in range(len(QUERIES) + 1)], asyncio.Event()
    async with running(create_app([only])) as server:
        feeds = [await server.feed(query) for query in QUERIES]
        feeds.append(await server.feed(f"?since={only.hub.epoch}:0"))
        await until(lambda: len(only.hub.clients) == len(accounts))
        for account in accounts if only.hub.next == 0 else ():
            account.next[only.hub.epoch] = 0  # all were there before the first spoke
        following = [asyncio.create_task(follow(*pair, reads)) for pair in zip(feeds, accounts, strict=True)]
        if not reads_late:
            reads.set()
        yield server, accounts
        reads.set()
        await asyncio.gather(*following)


async def run(server: Server) -> None:
    await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "run"}})


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.001)


SPOKES = 159  # of an engine that dies at 160: blocks are of five, and the last one of a scan is of four


@pytest.fixture
def few_truths(monkeypatch: pytest.MonkeyPatch) -> None:
    """One truth a scan: what the radar sends fits into a queue."""
    monkeypatch.setattr("radar_service.service.radio.truth_stream.TRUTHS_PER_SCAN", 1)


@pytest.mark.usefixtures("few_truths")
async def test_the_end_of_a_radar_comes_after_all_its_spokes() -> None:
    """It fails for good, as at the end of a replay, while its clients have yet to read all."""
    only = station(engine=FakeEngine(scene(), dies_at=160), restarts=0)
    async with playing(only, reads_late=True) as (server, accounts):
        await run(server)
        await until(lambda: only.transmitter.state.fault is not None and all(client.closed for client in only.hub.clients))
    for account in accounts:
        assert account.next == {only.hub.epoch: only.hub.next} and account.received == only.hub.next == SPOKES


@pytest.mark.usefixtures("few_truths")
@pytest.mark.parametrize("stops", [False, True])
async def test_what_is_not_read_in_time_is_announced_before_the_bye(stops: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first message was sent, the second one waits for the socket: it is in the gap too."""
    for name in ("fanout.hub.DRAIN", "radio.station.STOP_DRAIN"):
        monkeypatch.setattr(f"radar_service.service.{name}", {"live": 0.0, "lossless": 0.0})
    only, stopping = station(engine=FakeEngine(scene(), dies_at=160), restarts=0), list[asyncio.Task[None]]()
    async with playing(only, reads_late=True) as (server, accounts):
        await run(server)
        await until(lambda: only.hub.next == SPOKES)
        if stops:
            stopping.append(asyncio.create_task(only.stop()))  # it waits for its clients, which may read now
        await until(lambda: all(client.closed for client in only.hub.clients))
    for account in accounts:
        assert account.next == {only.hub.epoch: only.hub.next}
        assert account.received == 0 and account.types == ["hello", "gap", "bye"]


async def stop(only: Station, ends: list[int]) -> None:
    """Stops the radar; ends: gets the number that comes next."""
    ends.append(only.hub.next)  # before others run: what comes later comes after `bye`
    await only.stop()


@pytest.mark.parametrize("dies_at", [None, 40])
async def test_a_radar_that_tells_no_truth_loses_no_spoke_and_goes_on(dies_at: int | None) -> None:
    only, ends = station(engine=Untold(scene(), dies_at=dies_at), make=made_by(Untold)), list[int]()
    async with playing(only) as (server, accounts):
        await run(server)
        await until(lambda: all("no_truth" in accounts[k].types for k in TRUTHFUL) and only.hub.next > 200)
        await stop(only, ends)
    for account in accounts:
        assert account.next == {only.hub.epoch: ends[0]}
    assert only.transmitter.state.restarts == (dies_at is not None)


async def test_a_truth_that_is_late_delays_no_spoke_and_follows_in_order() -> None:
    only, ends = station(engine=(engine := Slow(scene()))), list[int]()
    async with playing(only) as (server, accounts):
        await run(server)
        await until(lambda: only.hub.next > 10 * AZIMUTHS)
        assert not any("truth" in account.types for account in accounts)
        engine.answers.set()
        await until(lambda: all(accounts[k].types.count("truth") > 9 for k in TRUTHFUL))
        await stop(only, ends)
    for account in accounts:
        assert account.next == {only.hub.epoch: ends[0]}
    told = accounts[TRUTHFUL[0]].truths
    assert told[:2] == [(0.0, 1), (pytest.approx(engine.scene.radar.rotation_period / 8), told[1][1])] and told[1][1] > 20
    assert only.transmitter.state.restarts == 0 and [time for time, _ in told] == sorted(time for time, _ in told)


async def test_a_batch_that_a_sink_fails_to_take_is_announced() -> None:
    only, ends = station(), list[int]()
    encode, failed = only.feed.send, list[int]()

    def fail_once(batch: SpokeBatch) -> None:
        if not failed and batch.first > 50:
            failed.append(batch.first)
            raise ValueError("cannot be encoded")
        encode(batch)

    async with playing(only) as (server, accounts):
        only.feed.send = fail_once  # type: ignore[method-assign]
        await run(server)
        await until(lambda: only.hub.next > 200)
        await stop(only, ends)
    for account in accounts:
        assert account.next == {only.hub.epoch: ends[0]} and account.shift == 0
    assert failed


async def test_a_swap_ends_an_epoch_for_everybody_at_the_same_number() -> None:
    only, ends = station(), list[int]()
    async with playing(only) as (server, accounts):
        await run(server)
        await until(lambda: only.hub.next > 50)
        assert (await server.http.put("/api/radars/0/scene", json={"scene": {"name": "second"}})).status_code == 200
        await until(lambda: all(len(account.next) == 2 for account in accounts))
        await stop(only, ends)
    assert len({next(iter(account.next.values())) for account in accounts}) == 1
    assert {account.next[only.hub.epoch] for account in accounts} == set(ends)

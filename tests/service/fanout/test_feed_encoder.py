"""The feed as a sink: one encoding for each view, and the time that it takes."""

import asyncio
import contextlib
import itertools
import threading
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.truth import Truth
from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.feed_encoder import MAX_WAITING, TRUTHS_PER_SCAN, FeedEncoder, FeedTruth
from radar_service.service.fanout.hub import EncodedBatch, Hub
from radar_service.service.feed_request import Mode, View
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import AZIMUTHS, BINS, FakeEngine, power_of, scene
from tests.service.fanout.batches import U8, everything, opened

EPOCH = Epoch("e", FakeEngine(scene()), None)


class Clients(Hub):
    """A hub that keeps what it is given. views: those to encode."""

    def __init__(self, *views: View) -> None:
        super().__init__(lambda: 0.0)
        self.views = views
        self.batches: list[EncodedBatch] = []
        self.others: list[Any] = []

    def open_epoch(self, epoch: str, hello: Callable[[View, Mode], bytes], spoke_period: float = 0.0) -> None:
        self.others.append(epoch)
        self.hello, self.spoke_period = hello, spoke_period

    async def publish(self, batch: EncodedBatch) -> None:
        self.batches.append(batch)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        self.others.append((epoch, first, count, reason))

    async def finish(self, reason: str) -> None:
        self.others.append(reason)


def encoder(hub: Hub) -> FeedEncoder:
    ticks = itertools.count()
    controls = {"pace": {"state": "run", "factor": 1.0}}
    return FeedEncoder(
        hub,
        ThreadPoolExecutor(1),
        lambda epoch: RadarInfo("0", "radar", epoch, 2.5, controls, True),
        lambda: float(next(ticks)),
    )


def test_a_protocol_whose_spokes_rise_leaves_out_those_that_come_late_or_again() -> None:
    """Errors on purpose send them so. In a new epoch the numbers begin anew."""
    rising = CODECS["signalk"].request({}, True).view
    hub, engine = Clients(U8, rising), FakeEngine(scene())
    feed = encoder(hub)

    def calls() -> None:
        for epoch in (EPOCH, Epoch("f", engine, None)):
            feed.open_epoch(RadarInfo.unnamed(epoch))
            for number, (first, count) in enumerate(((0, 2), (4, 1), (3, 1), (4, 1), (5, 2), (6, 1), (7, 1))):
                feed.send(SpokeBatch(epoch, number, engine.block(first, count), Controls()))

    transmit(feed, calls)
    assert [U8 in batch.data for batch in hub.batches] == [True] * 14
    assert [rising in batch.data for batch in hub.batches] == [True, True, False, False, True, False, True] * 2


def transmit(feed: FeedEncoder, calls: Callable[[], None]) -> None:
    """Lets another thread make the calls, beside the event loop of the hub."""

    async def test() -> None:
        feed.start()
        await asyncio.to_thread(calls)

    asyncio.run(test())


def batch(first: int, count: int) -> SpokeBatch:
    return SpokeBatch(EPOCH, first, FakeEngine(scene()).block(first, count), Controls())


def test_a_batch_is_encoded_once_for_each_view() -> None:
    hub = Clients(View("f32"), View("f32", 4), View("u8"))
    feed = encoder(hub)
    transmit(feed, lambda: feed.send(batch(5, 3)))
    (published,) = hub.batches
    assert (published.epoch, published.first, published.count) == ("e", 5, 3) and tuple(published.data) == hub.views
    samples = wire.samples(wire.unpack(published.data[View("f32")]))
    np.testing.assert_array_equal(samples, power_of(5 + np.arange(3), BINS))
    assert feed.timings == {"f32": (2, 2.0), "u8": (1, 1.0)}  # a tick each


def test_spokes_are_encoded_with_labels_for_clients_whose_request_they_follow() -> None:
    """A client that comes after the request for the next spokes gets the spokes after these."""
    early, late, plain = View("f32", labels=True), View("u8", powers=(256,)), View("f32")
    hub = Clients(plain, early)
    feed = encoder(hub)
    assert feed.requested() == SourceRequest(labels=True)
    hub.views = plain, early, late, View("f32", 4)
    transmit(feed, lambda: feed.send(batch(0, 3)))
    assert feed.requested() == SourceRequest(True, (256,))
    transmit(feed, lambda: feed.send(batch(3, 3)))
    assert [tuple(published.data) for published in hub.batches] == [(plain, early, View("f32", 4)), hub.views]
    assert encoder(Clients(plain)).requested() == SourceRequest()


def test_the_hello_is_that_of_the_clients_view() -> None:
    hub = Clients()
    feed = encoder(hub)
    transmit(feed, lambda: feed.open_epoch(RadarInfo.unnamed(EPOCH)))
    hello = wire.unpack(hub.hello(View("f16", 5), "lossless"))
    assert (hello["epoch"], hello["encoding"]["name"], hello["encoding"]["bins"], hello["mode"]) == (
        "e",
        "f16",
        5,
        "lossless",
    )
    assert hello["clocks"]["simulated_s"] == 2.5 and hello["truth"] is True
    assert hub.spoke_period == EPOCH.info.scene.radar.spoke_period


async def test_each_call_of_another_thread_is_done_when_it_returns() -> None:
    feed = encoder(hub := Hub(lambda: 0.0))
    feed.start()
    await asyncio.to_thread(feed.open_epoch, RadarInfo.unnamed(EPOCH))
    hub.join(client := ClientQueue(U8))

    def calls() -> None:
        feed.send(batch(0, 4))
        assert hub.next == 4
        feed.skip("e", 4, 5, "it broke")
        assert hub.next == 9
        feed.close("it broke")

    transmitting = asyncio.create_task(asyncio.to_thread(calls))
    messages = []
    while (item := await client.get()) is not None:
        assert not transmitting.done()  # it waits for who has yet to read
        messages.append(wire.unpack(item.data))
    hub.leave(client)
    await transmitting
    assert [message["type"] for message in messages] == ["hello", "spokes", "gap", "bye"]
    assert messages[-1]["reason"] == "the radar has stopped: it broke"


class Engine(FakeEngine):
    """Answers while `answers` is set; fails at the times in `fails`."""

    def __init__(self, *fails: float) -> None:
        super().__init__(scene())
        self.fails, self.asked = fails, 0
        self.answers = threading.Event()
        self.answers.set()

    def truth(self, t: float) -> Truth:
        self.asked += 1
        assert self.answers.wait(60)
        if t in self.fails:
            raise RuntimeError("the wheel came off")
        return super().truth(t)


class Played:
    """Truths of an engine for a client, who requests them or not."""

    def __init__(self, engine: Engine, requests: bool = True) -> None:
        self.engine, self.hub, self.client = engine, opened(), ClientQueue(U8, truth=requests)
        self.hub.join(self.client)
        self.pool = ThreadPoolExecutor(1)
        self.truth = FeedTruth(self.hub, self.pool)
        self.truth.start()

    def send(self, scans: int, epoch: str = "e") -> None:
        for scan in range(scans):
            block = self.engine.block(scan * AZIMUTHS, AZIMUTHS)
            self.truth.sent(Epoch(epoch, self.engine, None), block.index, block.time)

    async def told(self, count: int) -> list[dict[str, Any]]:
        """The messages after the hello, which stand for `count` truths."""
        messages: list[dict[str, Any]] = []
        while sum(message.get("count", 1) for message in messages) < count:
            await asyncio.sleep(0.001)
            messages += [message for message in await everything(self.client) if message["type"] != "hello"]
        return messages


@contextlib.asynccontextmanager
async def playing(engine: Engine, **options: Any) -> AsyncIterator[Played]:
    played = Played(engine, **options)
    try:
        yield played
    finally:
        engine.answers.set()
        played.truth.stop()
        played.pool.shutdown()


async def test_truth_comes_so_many_times_a_scan_where_a_client_requests_it() -> None:
    async with playing(Engine()) as played:
        played.send(1)
        messages = await played.told(TRUTHS_PER_SCAN)
        assert {message["type"] for message in messages} == {"truth"}
        np.testing.assert_allclose([m["time"] for m in messages], np.arange(8) * 2.5 / 8, rtol=1e-12)  # rounding
    async with playing(Engine(), requests=False) as played:
        played.send(1)
        await asyncio.sleep(0)
        assert played.engine.asked == 0


async def test_a_truth_that_fails_is_announced_in_its_position() -> None:
    async with playing(Engine(2.5 / 8)) as played:
        played.send(1)
        messages = await played.told(TRUTHS_PER_SCAN)
        assert [message["type"] for message in messages] == ["truth", "no_truth", *["truth"] * 6]
        expected = {"epoch": "e", "time": 2.5 / 8, "until": 2.5 / 8, "count": 1, "reason": "the wheel came off"}
        assert messages[1] == {"type": "no_truth", **expected}


async def test_truths_that_come_too_slowly_are_given_up_oldest_first_in_one_message() -> None:
    async with playing(Engine()) as played:
        played.engine.answers.clear()
        played.send(1)
        while not played.engine.asked:
            await asyncio.sleep(0.001)
        played.send(9)
        await asyncio.sleep(0)
        assert not await played.told(0)
        played.engine.answers.set()
        first, missing, *others = await played.told(10 * TRUTHS_PER_SCAN)
        assert first["type"] == "truth" and [other["type"] for other in others] == ["truth"] * MAX_WAITING
        assert (missing["type"], missing["count"]) == ("no_truth", 10 * TRUTHS_PER_SCAN - 1 - MAX_WAITING)
        assert "too slowly" in missing["reason"] and missing["time"] == 2.5 / 8


@pytest.mark.parametrize("ends", ["epoch", "stop"])
async def test_truths_of_an_epoch_that_is_over_or_of_a_radar_that_stops_are_not_asked(ends: str) -> None:
    async with playing(Engine()) as played:
        played.engine.answers.clear()
        played.send(1)
        while not played.engine.asked:
            await asyncio.sleep(0.001)
        if ends == "epoch":
            played.hub.open_epoch("f", lambda view, mode: wire.pack({"type": "hello", "epoch": "f"}))
            played.send(1, "f")
            await asyncio.sleep(0)
        else:
            played.truth.stop()
            played.send(1)
        played.engine.answers.set()
        messages = await played.told(TRUTHS_PER_SCAN if ends == "epoch" else 0)
        assert {message["epoch"] for message in messages} == ({"f"} if ends == "epoch" else set())
        assert played.engine.asked == (1 + TRUTHS_PER_SCAN if ends == "epoch" else 1)

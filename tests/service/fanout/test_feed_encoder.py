"""The feed as a sink: one encoding for each view, and the time that it takes."""

import asyncio
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from radar_service import wire
from radar_service.display.video import Controls
from radar_service.ports.signalk.codec import SignalKCodec
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.codecs.codec import CODECS
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import EncodedBatch, FeedEncoder, Hub
from radar_service.service.feed_request import Mode, View
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import BINS, FakeEngine, power_of, scene
from tests.service.fanout.batches import U8

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
        lambda epoch: RadarInfo("0", "radar", epoch, 2.5, controls, True),
        lambda: float(next(ticks)),
    )


def test_a_protocol_whose_spokes_rise_leaves_out_those_that_come_late_or_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors on purpose send them so. In a new epoch the numbers begin anew."""
    monkeypatch.setitem(CODECS, SignalKCodec.name, codec := SignalKCodec())
    rising = codec.request({}, True).view
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

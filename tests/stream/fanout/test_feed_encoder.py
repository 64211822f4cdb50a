"""The feed as a sink: one encoding for each view, and the time that it takes."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from radar_service.cell_sources import SourceRequest
from radar_service.display.video import Controls
from radar_service.stream.codecs.native import wire
from radar_service.stream.fanout.feed_encoder import FeedEncoder
from radar_service.stream.fanout.hub import EncodedBatch
from radar_service.stream.feed_request import Mode, View
from radar_service.stream.spokes import Epoch, RadarInfo, SpokeBatch
from tests.stream.fake import BINS, FakeEngine, power_of, scene

EPOCH = Epoch("e", FakeEngine(scene()), None)


class Output:
    """Keeps what it takes."""

    def __init__(self, *views: View) -> None:
        self.views = views
        self.batches: list[EncodedBatch] = []
        self.others: list[Any] = []
        self.hello: Callable[[View, Mode], bytes] = lambda view, mode: b""

    def open_epoch(self, epoch: str, hello: Callable[[View, Mode], bytes], spoke_period: float) -> None:
        self.others.append(epoch)
        self.hello, self.spoke_period = hello, spoke_period

    def publish(self, batch: EncodedBatch) -> None:
        self.batches.append(batch)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        self.others.append((epoch, first, count, reason))

    def close(self, reason: str) -> None:
        self.others.append(reason)


def encoder(output: Output) -> FeedEncoder:
    ticks = itertools.count()
    controls = {"pace": {"state": "run", "factor": 1.0}}
    return FeedEncoder(output, lambda epoch: RadarInfo("0", "radar", epoch, 2.5, controls, True), lambda: float(next(ticks)))


def batch(first: int, count: int) -> SpokeBatch:
    return SpokeBatch(EPOCH, first, FakeEngine(scene()).block(first, count), Controls())


def test_a_batch_is_encoded_once_for_each_view() -> None:
    output = Output(View("f32"), View("f32", 4), View("u8"))
    feed = encoder(output)
    feed.send(batch(5, 3))
    (published,) = output.batches
    assert (published.epoch, published.first, published.count) == ("e", 5, 3) and tuple(published.data) == output.views
    samples = wire.samples(wire.unpack(published.data[View("f32")]))
    np.testing.assert_array_equal(samples, power_of(5 + np.arange(3), BINS))
    assert feed.timings == {"f32": (2, 2.0), "u8": (1, 1.0)}  # a tick each


def test_spokes_are_encoded_with_labels_for_clients_whose_request_they_follow() -> None:
    """A client that comes after the request for the next spokes gets the spokes after these."""
    early, late, plain = View("f32", labels=True), View("u8", powers=(256,)), View("f32")
    output = Output(plain, early)
    feed = encoder(output)
    assert feed.requested() == SourceRequest(labels=True)
    output.views = plain, early, late, View("f32", 4)
    feed.send(batch(0, 3))
    assert feed.requested() == SourceRequest(True, (256,))
    feed.send(batch(3, 3))
    assert [tuple(published.data) for published in output.batches] == [(plain, early, View("f32", 4)), output.views]
    assert encoder(Output(plain)).requested() == SourceRequest()


def test_the_hello_is_that_of_the_clients_view() -> None:
    output = Output()
    encoder(output).open_epoch(RadarInfo.unnamed(EPOCH))
    hello = wire.unpack(output.hello(View("f16", 5), "lossless"))
    assert (hello["epoch"], hello["encoding"]["name"], hello["encoding"]["bins"], hello["mode"]) == (
        "e",
        "f16",
        5,
        "lossless",
    )
    assert hello["clocks"]["simulated_s"] == 2.5 and hello["truth"] is True
    assert output.spoke_period == EPOCH.engine.scene.radar.spoke_period


def test_gaps_and_ends_pass_through() -> None:
    output = Output()
    feed = encoder(output)
    feed.skip("e", 9, 4, "it broke")
    feed.close("it broke")
    assert output.others == [("e", 9, 4, "it broke"), "the radar has stopped: it broke"]

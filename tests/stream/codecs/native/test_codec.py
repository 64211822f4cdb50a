"""The native codec: each message by its fields, and the view applied to its spokes."""

import numpy as np

from radar_service.display.video import Controls
from radar_service.stream.codecs.native import wire
from radar_service.stream.codecs.native.codec import NativeCodec
from radar_service.stream.feed_request import View
from radar_service.stream.spokes import Epoch, SpokeBatch
from tests.stream.fake import BINS, FakeEngine, power_of, scene

CODEC = NativeCodec()
EPOCH = Epoch("e", FakeEngine(scene()), None)
BATCH = SpokeBatch(EPOCH, 100, FakeEngine(scene()).block(6, 4), Controls())


def test_spokes_carry_numbers_of_the_epoch_and_rows_of_the_scan() -> None:
    message = wire.unpack(CODEC.spokes(BATCH, View("f32")))
    assert (message["first"], message["count"], message["index"], message["scan"]) == (100, 4, 6, 0)
    np.testing.assert_array_equal(wire.samples(message), power_of(6 + np.arange(4), BINS))


def test_a_view_is_applied() -> None:
    message = wire.unpack(CODEC.spokes(BATCH, View("f32", 5, spokes=4, compression="zstd")))
    assert (message["compression"], message["row_first"], message["row_count"]) == ("zstd", [0, 2], [2, 2])
    assert message["bins"] == 5 and (message["first"], message["count"]) == (100, 4)


def test_trimming_keeps_the_last_spokes() -> None:
    message = wire.unpack(CODEC.trim(CODEC.spokes(BATCH, View("f32")), 1))
    assert (message["first"], message["count"], message["index"]) == (103, 1, 9)
    np.testing.assert_array_equal(wire.samples(message), power_of([9], BINS))


def test_notices_have_these_fields() -> None:
    assert wire.unpack(CODEC.gap("e", 3, 2, "x")) == {"type": "gap", "epoch": "e", "first": 3, "count": 2, "reason": "x"}
    assert wire.unpack(CODEC.bye("e", "x")) == {"type": "bye", "epoch": "e", "reason": "x"}
    truth = wire.unpack(CODEC.truth("e", EPOCH.engine.truth(2.5)))
    assert (truth["type"], truth["epoch"], truth["time"], len(truth["bodies"])) == ("truth", "e", 2.5, 1)

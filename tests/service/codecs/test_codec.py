"""What every registered codec keeps to, so that hub, feed and recorders can use any of them."""

import pytest

from radar_service.display.video import Controls
from radar_service.service.codecs.codec import Codec
from radar_service.service.codecs.registry import CODECS
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import FakeEngine, scene

EPOCH = Epoch("e", FakeEngine(scene()), None)
INFO = RadarInfo("0", "radar", EPOCH, 0.0, {"pace": {"state": "run", "factor": 1.0}}, True)


@pytest.mark.parametrize("name", CODECS)
def test_a_codec_is_registered_by_its_name_and_has_the_address_of_a_radar(name: str) -> None:
    codec: Codec = CODECS[name]
    assert codec.name == name and codec.path.startswith("/") and "{radar}" in codec.path
    view = codec.request({}, True).view
    assert view.codec == name and ClientQueue(view).codec is codec


def test_addresses_differ() -> None:
    assert len({codec.path for codec in CODECS.values()}) == len(CODECS)


@pytest.mark.parametrize("name", CODECS)
def test_messages_are_bytes_and_the_same_twice(name: str) -> None:
    codec, batch = CODECS[name], SpokeBatch(EPOCH, 3, FakeEngine(scene()).block(3, 5), Controls())
    view = codec.request({}, True).view
    assert isinstance(codec.hello(INFO, view, "live"), bytes)
    assert codec.spokes(batch, view) == codec.spokes(batch, view) != b""
    for message in (codec.gap("e", 3, 2, "x"), codec.bye("e", "x"), codec.truth("e", FakeEngine(scene()).truth(0.0))):
        assert isinstance(message, bytes)


@pytest.mark.parametrize("name", CODECS)
def test_a_trimmed_message_is_that_of_the_last_spokes(name: str) -> None:
    codec, engine = CODECS[name], FakeEngine(scene())
    view = codec.request({}, True).view
    whole = codec.spokes(SpokeBatch(EPOCH, 3, engine.block(3, 5), Controls()), view)
    assert codec.trim(whole, 2) == codec.spokes(SpokeBatch(EPOCH, 6, engine.block(6, 2), Controls()), view)

"""What every registered codec keeps to, so that hub, feed and recorders can use any of them."""

import asyncio
from collections.abc import Mapping

import pytest

from radar_service.display.video import Controls
from radar_service.ports.app import create_app
from radar_service.ports.port_host import PortHost
from radar_service.ports.signalk.signalk_port import SignalKPort
from radar_service.records.truth import Truth
from radar_service.service.codecs.codec import CODECS, Codec
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.feed_request import FeedRequest, Mode, View
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.ports.asgi import PATIENCE, Server, Socket, running
from tests.service.fake import FakeEngine, factory, scene

PortHost((SignalKPort(),))  # its codec joins
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


class NumbersCodec:
    """Sends the numbers of spokes as text, and has no hello, no truth, no gap and no bye."""

    name, port, path, rising = "numbers", "feed", "/numbers/{radar}", False

    def request(self, query: Mapping[str, str], is_local: bool) -> FeedRequest:
        return FeedRequest(View("text", codec=self.name), truth=query.get("truth") == "1")

    def hello(self, radar: RadarInfo, view: View, mode: Mode) -> bytes:
        return b""

    def spokes(self, batch: SpokeBatch, view: View) -> bytes:
        return " ".join(str(batch.first + k) for k in range(len(batch))).encode()

    def truth(self, epoch: str, state: Truth) -> bytes:
        return b""

    def no_truth(self, epoch: str, time: float, until: float, count: int, reason: str) -> bytes:
        return b""

    def gap(self, epoch: str, first: int, count: int, reason: str) -> bytes:
        return b""

    def bye(self, epoch: str, reason: str) -> bytes:
        return b""

    def trim(self, data: bytes, count: int) -> bytes:
        return b" ".join(data.split()[-count:])


async def text(socket: Socket) -> str:
    return (await asyncio.wait_for(socket.raw(), PATIENCE)).decode()


def play(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a client of the protocol receives of 7 spokes, beside a client of the native feed."""
    monkeypatch.setitem(CODECS, "numbers", NumbersCodec())
    received: list[str] = []

    async def test(server: Server) -> None:
        socket = await server.open("/numbers/0")
        native = await server.feed()
        await server.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": 7}})
        while sum(len(line.split()) for line in received) < 7:
            received.append(await text(socket))
        assert sum(message["count"] for message in await native.spokes(7)) == 7
        assert {view.codec for view in server.stations[0].hub.views} == {"native", "numbers"}
        timings = server.stations[0].feed.timings
        assert set(timings) == {"u8", "text"}

    async def whole() -> None:
        only = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")))
        async with running(create_app([only])) as server:
            server.stations = [only]
            await test(server)

    asyncio.run(asyncio.wait_for(whole(), 60))
    assert "" not in received  # a message that the protocol does not have is not sent
    return received


def test_a_registered_codec_has_a_feed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert " ".join(play(monkeypatch)).split() == [str(n) for n in range(7)]

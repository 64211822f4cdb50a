"""Frames as RFC 6455 has them, and as clients get them through a real socket."""

import asyncio

import pytest
from websockets.asyncio.client import connect

from radar_service.stream import wire
from radar_service.stream.app import create_app
from radar_service.stream.pace import Pace
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings
from radar_service.stream.websocket import FramedWebSocket, frame
from tests.stream.fake import FakeEngine, factory, power_of, scene
from tests.stream.serving import served


@pytest.mark.parametrize(
    ("size", "head"),
    [(0, "8200"), (125, "827d"), (126, "827e007e"), (256, "827e0100"), (65_535, "827effff"), (65_536, "827f0000000000010000")],
)  # fmt: skip
def test_frames_are_those_of_the_standard(size: int, head: str) -> None:
    """256 and 65,536 bytes are the examples of RFC 6455, section 5.7."""
    data = bytes(range(256)) * 256
    assert frame(data[:size]) == bytes.fromhex(head) + data[:size]


@pytest.mark.parametrize("bins", [20, 15_000])
def test_what_is_written_as_frames_arrives_as_messages(bins: int, monkeypatch: pytest.MonkeyPatch) -> None:
    written = []
    plain = FramedWebSocket.write_frame

    def noted(self: FramedWebSocket, ready: bytes) -> bool:
        written.append(len(ready))
        return plain(self, ready)

    monkeypatch.setattr(FramedWebSocket, "write_frame", noted)
    engine = FakeEngine(scene(range_max_m=bins * 10.0))
    only = Station("0", engine, factory(), settings=Settings(pace=Pace(factor=5)))

    async def listen(url: str) -> None:
        async with connect(url, proxy=None, compression=None, max_size=None) as socket:
            number = None
            while number is None or number < 40:
                message = wire.unpack(bytes(await socket.recv(decode=False)))
                if message["type"] == "spokes":
                    assert number in (None, message["first"])
                    number = message["first"] + message["count"]
                    expected = power_of(range(message["first"], number), bins)
                    assert (wire.samples(message) == expected).all()

    with served(create_app([only]), [only]) as (host, port):
        asyncio.run(asyncio.wait_for(listen(f"ws://{host}:{port}/api/radars/0/feed?encoding=f32"), 20))
    assert len(written) >= 9 and max(written) > 4 * bins  # a hello and 40 spokes in fives

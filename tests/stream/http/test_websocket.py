"""Websocket frames through a real socket, well formed and malformed."""

import asyncio

import pytest
from websockets.asyncio.client import connect

from radar_service.stream.codecs.native import wire
from radar_service.stream.http.app import create_app
from radar_service.stream.http.server import INBOUND_LIMIT
from radar_service.stream.http.websocket import FramedWebSocket
from radar_service.stream.radio.station import Station
from radar_service.stream.settings import Pace, Settings
from tests.stream.fake import FakeEngine, factory, power_of, scene
from tests.stream.http.loopback import UPGRADE, Address, radar
from tests.stream.serving import answer, dialled, served


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


FRAMES = {
    "unmasked": b"\x82\x01a", "reserved bits": b"\xf2\x80abcd", "unknown opcode": b"\x83\x80abcd",
    "half a ping": b"\x89\xfe\xff\xff", "claims 2^62 bytes": b"\x82\xff\x40" + b"\x00" * 7 + b"abcd",
    "continues nothing": b"\x80\x80abcd", "text that is not text": b"\x81\x82\x00\x00\x00\x00\xff\xff",
    "too long": b"\x82\xfe" + (INBOUND_LIMIT + 1).to_bytes(2, "big") + b"\x00" * 4 + b"x" * (INBOUND_LIMIT + 1),
}  # fmt: skip


@pytest.mark.parametrize("name", FRAMES)
def test_malformed_and_oversized_frames_end_their_connection_only(name: str) -> None:
    async def other(address: Address) -> None:
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            hello = wire.unpack(bytes(await feed.recv()))
            with dialled(address) as connection:
                connection.sendall(UPGRADE)
                assert connection.recv(12) == b"HTTP/1.1 101"
                connection.sendall(FRAMES[name])
                await asyncio.to_thread(answer, connection)  # ends
            first = -1
            for _ in range(3):
                message = wire.unpack(bytes(await feed.recv()))
                assert message["epoch"] == hello["epoch"] and message["first"] > first
                first = message["first"]

    with radar() as address:
        asyncio.run(asyncio.wait_for(other(address), 20))

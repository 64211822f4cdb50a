"""Websocket frames through a real socket, well formed and malformed."""

import asyncio
import json
import socket
import threading
from collections.abc import Callable, Iterator

import pytest
from websockets.asyncio.client import connect

from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.ports.http import websocket
from radar_service.ports.http.server import INBOUND_LIMIT
from radar_service.ports.http.websocket import BYTES_AT_ONCE, FRAMES_AT_ONCE, TOO_MUCH, FramedWebSocket
from radar_service.ports.rest.websockets import POSES_AT_ONCE
from radar_service.service.fanout.client_queue import TOO_SLOW
from radar_service.service.settings import Pace, Settings
from tests.ports.playing import station
from tests.ports.serving import UPGRADE, Address, Turns, answer, dialled, radar, served
from tests.service.fake import power_of, scene, steerable_scene


@pytest.fixture(scope="module")
def address() -> Iterator[Address]:
    """A radar that tests share whose clients end their own connections."""
    with radar() as at:
        yield at


def upgraded(address: Address) -> socket.socket:
    """A connection that has become a websocket of the feed."""
    connection = dialled(address)
    connection.sendall(UPGRADE)
    assert connection.recv(12) == b"HTTP/1.1 101"
    return connection


@pytest.mark.parametrize("bins", [20, 15_000])
def test_what_is_written_as_frames_arrives_as_messages(bins: int, monkeypatch: pytest.MonkeyPatch) -> None:
    written = []
    plain = FramedWebSocket.write_frame

    def noted(self: FramedWebSocket, ready: bytes) -> bool:
        written.append(len(ready))
        return plain(self, ready)

    monkeypatch.setattr(FramedWebSocket, "write_frame", noted)
    only = station(scene(range_max_m=bins * 10.0), settings=Settings(pace=Pace(factor=30)))

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
        asyncio.run(asyncio.wait_for(listen(f"ws://{host}:{port}/api/radars/0/feed?encoding=f32"), 60))
    assert len(written) >= 9 and max(written) > 4 * bins  # a hello and 40 spokes in fives


FRAMES = {
    "unmasked": b"\x82\x01a", "reserved bits": b"\xf2\x80abcd", "unknown opcode": b"\x83\x80abcd",
    "half a ping": b"\x89\xfe\xff\xff", "claims 2^62 bytes": b"\x82\xff\x40" + b"\x00" * 7 + b"abcd",
    "continues nothing": b"\x80\x80abcd", "text that is not text": b"\x81\x82\x00\x00\x00\x00\xff\xff",
    "too long": b"\x82\xfe" + (INBOUND_LIMIT + 1).to_bytes(2, "big") + b"\x00" * 4 + b"x" * (INBOUND_LIMIT + 1),
}  # fmt: skip


def test_malformed_and_oversized_frames_end_their_connection_only(address: Address) -> None:
    async def other() -> None:
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            hello, first = wire.unpack(bytes(await feed.recv())), -1
            for frames in FRAMES.values():
                with upgraded(address) as connection:
                    connection.sendall(frames)
                    await asyncio.to_thread(answer, connection)  # ends
                message = wire.unpack(bytes(await feed.recv()))
                assert message["epoch"] == hello["epoch"] and message["first"] > first
                first = message["first"]

    asyncio.run(asyncio.wait_for(other(), 60))


FLOOD_BYTES = 2 * 2**20  # parsing 350,000 empty frames takes seconds
LONGEST_TURN = 0.2  # s of processor time: ten times what is needed, and a quarter of what the mildest attack took before
FLOODS = {
    "empty pings": b"\x89\x80abcd", "empty pongs": b"\x8a\x80abcd", "empty continuations": b"\x00\x80abcd",
    "empty messages": b"\x82\x80abcd", "long pings": b"\x89\xfd" + b"abcd" + b"x" * 125,
}  # fmt: skip


def flood(address: Address, frame: bytes) -> bytes:
    """Sends FLOOD_BYTES of one frame after the beginning of a message, while the server takes them; returns the answer."""
    with upgraded(address) as connection:
        try:
            connection.sendall((b"\x02\x80abcd" if frame[0] == 0 else b"") + frame * (FLOOD_BYTES // len(frame)))
            connection.shutdown(socket.SHUT_WR)
        except OSError:  # the server has cut the connection, and its close frame may be lost with it
            return b""
        return answer(connection)


def test_a_client_that_floods_is_cut_and_silences_nobody() -> None:
    async def listen(address: Address) -> None:
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed", compression=None) as feed:
            await feed.recv()
            for frame in FLOODS.values():
                flooding = asyncio.create_task(asyncio.to_thread(flood, address, frame))
                while not flooding.done():
                    await feed.recv()
                await flooding
            for _ in range(5):
                await feed.recv()

    with radar(turns=(turns := Turns())) as address:
        asyncio.run(asyncio.wait_for(listen(address), 60))
    assert 0.0 < turns.longest < LONGEST_TURN


def test_a_client_that_sends_too_much_reads_why(address: Address) -> None:
    """Few enough bytes that the server reads them all, so that its close frame is not lost by a reset."""
    parts = b"\xa3bye", b"this client sends too much", b"\x88\x02" + TOO_MUCH.to_bytes(2)
    for frame in (b"\x89\x80abcd", b"\x8a\xfdabcd" + b"x" * 125):
        with upgraded(address) as connection:
            connection.sendall(frame * (1 + min(FRAMES_AT_ONCE, BYTES_AT_ONCE // len(frame))))
            last = read_until(connection, parts[-1])
        places = [last.index(part) for part in parts]
        assert places == sorted(places)


def test_a_client_within_its_budget_stays(address: Address) -> None:
    async def talk() -> None:
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            for _ in range(FRAMES_AT_ONCE // 4):
                await feed.ping()
                await feed.send("words")
            for _ in range(3):
                assert wire.unpack(bytes(await feed.recv()))["type"] in ("hello", "spokes")

    asyncio.run(asyncio.wait_for(talk(), 60))


Connection = tuple[socket.socket, FramedWebSocket, threading.Event]


@pytest.fixture
def connection(address: Address, monkeypatch: pytest.MonkeyPatch) -> Iterator[Connection]:
    """A client's socket, the server's side of it, and what is set when that side has lost it."""
    lost, protocols = threading.Event(), list[FramedWebSocket]()
    made, gone = FramedWebSocket.connection_made, FramedWebSocket.connection_lost

    def noted_made(self: FramedWebSocket, transport: asyncio.BaseTransport) -> None:
        protocols.append(self)
        made(self, transport)

    def noted_lost(self: FramedWebSocket, exc: Exception | None) -> None:
        gone(self, exc)
        if self in protocols[:1]:
            lost.set()

    monkeypatch.setattr(FramedWebSocket, "connection_made", noted_made)
    monkeypatch.setattr(FramedWebSocket, "connection_lost", noted_lost)
    with upgraded(address) as client:
        yield client, protocols[0], lost


def on_loop(protocol: FramedWebSocket, *calls: Callable[[], object]) -> None:
    """Makes calls in one turn of the server's loop, and waits for it."""

    async def make() -> None:
        for call in calls:
            call()

    asyncio.run_coroutine_threadsafe(make(), protocol.loop).result(10)


def read_until(client: socket.socket, end: bytes, got: bytes = b"") -> bytes:
    """What comes until it has `end`, or until the server closes."""
    read = bytearray(got)
    while end not in read[-2 * len(end) - 2**18 :] and (piece := client.recv(2**17)):
        read += piece
    return bytes(read)


MUCH = b"x" * 2**24  # more than both kernels hold
TOO_SLOW_FRAME = b"\x88\x02" + TOO_SLOW.to_bytes(2)


def test_a_client_that_does_not_read_is_cut_for_good(connection: Connection, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its kernel takes nothing, so what the server has written never leaves; the server's slot is free all the same."""
    monkeypatch.setattr(websocket, "CUT_SECONDS", 0.1)
    _, protocol, lost = connection
    on_loop(protocol, lambda: protocol.transport.write(MUCH), protocol.keepalive_timeout)
    assert lost.wait(60)


def test_a_client_that_answers_no_pings_gets_bye_and_a_close_code(
    connection: Connection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(websocket, "CUT_SECONDS", 20.0)
    client, protocol, _ = connection
    on_loop(protocol, lambda: protocol.transport.write(MUCH), protocol.keepalive_timeout)
    got = read_until(client, TOO_SLOW_FRAME)
    assert got.index(b"\xa3bye") < got.index(b"this client does not answer pings") < got.index(TOO_SLOW_FRAME)


def test_a_connection_that_has_gone_is_not_cut(
    connection: Connection, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The client reads all before the server would cut it."""
    monkeypatch.setattr(websocket, "CUT_SECONDS", 0.2)
    client, protocol, lost = connection
    on_loop(protocol, lambda: protocol.transport.write(b"x" * 2**20), protocol.keepalive_timeout, protocol.transport.close)
    answer(client)
    assert lost.wait(60)
    later = threading.Event()
    on_loop(protocol, lambda: protocol.loop.call_later(0.3, later.set))
    assert later.wait(60)
    assert not [record for record in caplog.records if record.name == "asyncio"]


def test_a_client_that_reads_slowly_stays_while_it_reads(connection: Connection) -> None:
    """Its pong is late because the ping waits behind spokes."""
    client, protocol, lost = connection
    on_loop(protocol, lambda: protocol.transport.write(MUCH), protocol.send_keepalive_ping)
    got = bytearray(client.recv(2**17))
    while protocol.transport.get_write_buffer_size() > len(MUCH) // 2:
        got += client.recv(2**17)
    timer = protocol.pong_timer
    on_loop(protocol, protocol.keepalive_timeout)
    assert protocol.pong_timer is not timer and not lost.is_set()
    on_loop(protocol, protocol.keepalive_timeout)  # it has read nothing since, but for what its kernel took
    assert TOO_SLOW_FRAME in read_until(client, TOO_SLOW_FRAME, bytes(got)) or lost.wait(10)


def test_the_last_ping_is_answered_when_the_client_reads_again(connection: Connection) -> None:
    first, last = (b"\x89\x81\x00\x00\x00\x00" + letter for letter in (b"a", b"b"))
    client, protocol, _ = connection
    on_loop(protocol, lambda: protocol.transport.write(MUCH), lambda: protocol.data_received(first),
            lambda: protocol.data_received(last))  # fmt: skip
    got = read_until(client, b"\x8a\x01b")
    assert b"\x8a\x01b" in got and b"\x8a\x01a" not in got


def test_refused_websockets_leave_no_error_in_the_log(address: Address, caplog: pytest.LogCaptureFixture) -> None:
    with dialled(address) as connection:
        connection.sendall(UPGRADE.replace(b"upgrade\r\n", b"upgrade\r\norigin: http://elsewhere\r\n", 1))
        assert b" 403 " in answer(connection)
    assert not [record for record in caplog.records if record.name.startswith("uvicorn")]


def test_text_that_is_none_ends_its_connection_without_an_error_in_the_log(
    address: Address, caplog: pytest.LogCaptureFixture
) -> None:
    """In one frame, and cut within a character."""
    for frames in (FRAMES["text that is not text"], b"\x01\x81\x00\x00\x00\x00\xe2\x80\x81\x00\x00\x00\x00\xff"):
        with upgraded(address) as connection:
            connection.sendall(frames)
            assert b"\x88\x02\x03\xef" in answer(connection)  # close, 1007
    assert not [record for record in caplog.records if record.name.startswith("uvicorn")]


def test_a_client_that_sends_poses_may_send_more() -> None:
    """More frames at once than other clients may send, within those of poses."""
    only = station(steerable_scene())
    pose = '{"body": "buoy", "position_m": [1, 2], "course_deg": 90, "speed_kn": 5}'

    async def send(url: str) -> list[str]:
        async with connect(url, proxy=None) as socket:
            for _ in range(FRAMES_AT_ONCE + 50):
                await socket.send(pose)
            return [json.loads(await socket.recv())["type"] for _ in range(FRAMES_AT_ONCE + 50)]

    with served(create_app([only]), [only]) as (host, port):
        answers = asyncio.run(asyncio.wait_for(send(f"ws://{host}:{port}/api/radars/0/poses"), 60))
    assert answers.count("pose") >= POSES_AT_ONCE and set(answers) <= {"pose", "refused"}

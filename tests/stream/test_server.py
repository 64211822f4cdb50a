"""Sockets of a served application: how many, from whom, how slow, how long, how malformed; and nobody else notices."""

import asyncio
import contextlib
import socket
from collections.abc import Iterator

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from radar_service.stream import server, wire
from radar_service.stream.app import create_app
from radar_service.stream.pace import Pace
from radar_service.stream.server import INBOUND_LIMIT, SEND_BUFFER, listening_socket
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings
from tests.stream.fake import FakeEngine, factory, scene
from tests.stream.serving import answer, dialled, served

Address = tuple[str, int]
GET = b"GET /api/health/alive HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: close\r\n\r\n"
UPGRADE = (
    b"GET /api/radars/0/feed HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: upgrade\r\nupgrade: websocket\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


@contextlib.contextmanager
def radar(refused: list[str] | None = None, **limits: float) -> Iterator[Address]:
    only = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace(factor=10)))
    told = (lambda _: None) if refused is None else refused.append
    with served(create_app([only]), [only], refused=told, **limits) as address:
        yield address


def works(address: Address) -> bool:
    with dialled(address) as connection:
        connection.sendall(GET)
        return b'{"yes":true}' in answer(connection)


def test_more_connections_than_the_server_takes_are_told_so() -> None:
    refused: list[str] = []
    with radar(refused, connections=3) as address:
        idle = [dialled(address) for _ in range(3)]
        with idle.pop() as third:
            third.sendall(GET)
            assert b'{"yes":true}' in answer(third)  # it is served, and so has come in
        idle.append(dialled(address))
        with dialled(address) as one_too_many:
            said = answer(one_too_many)
        assert said.startswith(b"HTTP/1.1 503 ") and b"try again later" in said and refused == ["connections"]
        for connection in idle:
            connection.close()
        while not works(address):  # the server sees them go a moment later
            continue


def test_one_address_cannot_take_all_connections(monkeypatch: pytest.MonkeyPatch) -> None:
    with radar(per_address=2) as address:
        many = [dialled(address) for _ in range(6)]  # of this machine: as many as it likes
        assert works(address)
        monkeypatch.setattr(server, "is_loopback", lambda host: False)
        with dialled(address) as one_too_many:
            assert b"this address has all" in answer(one_too_many)
        for connection in many:
            connection.close()


@pytest.mark.parametrize("asked_before", [False, True])
@pytest.mark.parametrize("begun", [b"", b"GET / HT", UPGRADE[:-2]])
def test_who_does_not_finish_asking_is_cut_off(begun: bytes, asked_before: bool) -> None:
    refused: list[str] = []
    with radar(refused, seconds=0.2) as address, dialled(address) as slow:
        if asked_before:
            slow.sendall(GET.replace(b"close", b"keep-alive"))
            while b"true" not in slow.recv(4096):
                continue
            begun = begun or b"G"  # who asks nothing more is let go by the keep-alive limit
        slow.sendall(begun)
        answer(slow)  # ends, or the test does after ten seconds
        assert refused == ["slow request"]
        assert works(address)


def test_who_has_asked_is_not_cut_off() -> None:
    async def listen(address: Address) -> int:
        got = 0
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            while got < 24 * 5:  # at 24 rpm and ten times as fast: 1.25 s, six times the limit
                got += wire.unpack(bytes(await feed.recv())).get("count", 0)
        return got

    with radar(seconds=0.2) as address:
        assert asyncio.run(asyncio.wait_for(listen(address), 20)) >= 24 * 5


@pytest.mark.parametrize(
    "rubbish",
    [
        b"\x00" * 100, b"GET\r\n\r\n", b"A" * 100_000, b"GET / HTTP/1.1\r\nx: " + b"y" * 100_000,
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\ncontent-length: -1\r\n\r\n",
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\ncontent-length: 999999999999\r\ncontent-type: application/json\r\n\r\n{}",
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\ntransfer-encoding: chunked\r\n\r\nzz\r\n",
    ],
)  # fmt: skip
def test_malformed_requests_end_the_connection_only(rubbish: bytes) -> None:
    with radar(seconds=0.5) as address:
        with dialled(address) as connection:
            connection.sendall(rubbish)
            said = answer(connection)
            assert said[:13] in (b"", b"HTTP/1.1 400 ", b"HTTP/1.1 413 "), said[:200]
        assert works(address)


def test_a_body_that_stops_coming_is_refused_in_time(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("radar_service.stream.guard.BODY_SECONDS", 0.1)
    head = (
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\nconnection: close\r\ncontent-length: 99\r\ncontent-type: application/json"
    )
    with radar() as address:
        with dialled(address) as connection:
            connection.sendall(head + b'\r\n\r\n{"name"')
            assert answer(connection).startswith(b"HTTP/1.1 400 ")
        with dialled(address) as connection:
            connection.sendall(head + b'\r\n\r\n{"name"')  # and gone
        assert works(address)
    assert "Traceback" not in capfd.readouterr().err


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


def test_a_stalled_client_is_left_little_stale_data() -> None:
    """The kernel doubles what is asked for, for its own book-keeping (socket(7))."""
    with listening_socket("127.0.0.1", 0) as listener, dialled(listener.getsockname()[:2]):
        taken, _ = listener.accept()
        with taken:
            assert taken.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF) in (SEND_BUFFER, 2 * SEND_BUFFER)


def test_stopping_says_bye_to_all_and_takes_nobody_any_more() -> None:
    async def listen(address: Address, stop: asyncio.Event) -> tuple[str, int | None]:
        reason = ""
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            with contextlib.suppress(ConnectionClosed):
                async for data in feed:
                    message = wire.unpack(bytes(data))
                    stop.set()
                    reason = message.get("reason", "")
        return reason, feed.close_code

    async def all_of(address: Address, end: contextlib.ExitStack) -> list[tuple[str, int | None]]:
        stop = asyncio.Event()
        clients = [asyncio.create_task(listen(address, stop)) for _ in range(20)]
        await stop.wait()
        await asyncio.to_thread(end.close)
        return await asyncio.gather(*clients)

    with contextlib.ExitStack() as end:
        address = end.enter_context(radar())
        parted = asyncio.run(asyncio.wait_for(all_of(address, end), 20))
    assert {code for _, code in parted if _} == {1001}
    assert all(reason == "the server is stopping" and code == 1001 for reason, code in parted)
    with pytest.raises(ConnectionRefusedError):
        dialled(address)

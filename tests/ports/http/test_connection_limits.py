"""Connections of a served application: how many, from whom, how slow, how malformed; others do not notice."""

import asyncio
from contextlib import ExitStack

import pytest
from websockets.asyncio.client import connect

from radar_service import wire
from radar_service.ports.http import server
from tests.ports.http.loopback import GET, UPGRADE, Address, radar, works
from tests.ports.serving import answer, dialled


def test_too_many_connections_are_refused_with_the_reason() -> None:
    refused: list[str] = []
    with radar(refused, connections=3) as address:
        idle = [dialled(address) for _ in range(3)]
        with idle.pop() as third:
            third.sendall(GET)
            assert b'{"yes":true}' in answer(third)  # it is served, and so has come in
        idle.append(dialled(address))
        with dialled(address) as one_too_many:
            reply = answer(one_too_many)
        assert reply.startswith(b"HTTP/1.1 503 ") and b"try again later" in reply and refused == ["connections"]
        for connection in idle:
            connection.close()
        while not works(address):  # the server sees them go a moment later
            continue


def test_a_refused_client_that_sends_a_body_reads_the_answer() -> None:
    """A socket that is closed with unread bytes resets the connection, and the answer in it is lost."""
    request = b"PUT / HTTP/1.1\r\nhost: x\r\ncontent-length: 100000\r\n\r\n"
    with radar(connections=1) as address, dialled(address), dialled(address) as refused:
        for _ in range(10):
            refused.sendall(request + bytes(10_000))
        assert answer(refused).startswith(b"HTTP/1.1 503 ")


def test_one_address_cannot_take_all_connections(monkeypatch: pytest.MonkeyPatch) -> None:
    with radar(per_address=2) as address:
        many = [dialled(address) for _ in range(6)]  # of this machine: as many as it likes
        assert works(address)
        monkeypatch.setattr(server, "is_loopback", lambda host: False)
        with dialled(address) as one_too_many:
            assert b"this address has all" in answer(one_too_many)
        for connection in many:
            connection.close()


def test_a_request_that_does_not_arrive_is_closed() -> None:
    """Neither the first one of a connection, nor one after another that was answered."""
    refused: list[str] = []
    with radar(refused, seconds=0.2) as address, ExitStack() as on_end:
        first = {part: on_end.enter_context(dialled(address)) for part in (b"", b"GET / HT", UPGRADE[:-2])}
        second = {part: on_end.enter_context(dialled(address)) for part in (b"G", b"GET / HT", UPGRADE[:-2])}
        for connection in second.values():
            connection.sendall(GET.replace(b"close", b"keep-alive"))
            while b"true" not in connection.recv(4096):
                continue
        for begun, connection in (*first.items(), *second.items()):
            connection.sendall(begun)
        for connection in (*first.values(), *second.values()):
            answer(connection)  # ends, or the test does after a minute
        assert refused == ["slow request"] * 6
        assert works(address)


def test_a_complete_request_is_not_closed() -> None:
    async def listen(address: Address) -> int:
        got = 0
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            while got < 24 * 2:  # at 24 rpm and ten times as fast: 0.5 s, two and a half times the limit
                got += wire.unpack(bytes(await feed.recv())).get("count", 0)
        return got

    with radar(seconds=0.2) as address:
        assert asyncio.run(asyncio.wait_for(listen(address), 60)) >= 24 * 2


def test_malformed_requests_end_the_connection_only() -> None:
    requests = [
        b"\x00" * 100, b"GET\r\n\r\n", b"A" * 100_000, b"GET / HTTP/1.1\r\nx: " + b"y" * 100_000,
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\ncontent-length: -1\r\n\r\n",
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\ncontent-length: 999999999999\r\ncontent-type: application/json\r\n\r\n{}",
        b"POST /api/scenes HTTP/1.1\r\nhost: x\r\ntransfer-encoding: chunked\r\n\r\nzz\r\n",
    ]  # fmt: skip
    with radar(seconds=0.5, keep_alive=0) as address:
        for rubbish in requests:
            with dialled(address) as connection:
                connection.sendall(rubbish)
                reply = answer(connection)
                assert reply[:13] in (b"", b"HTTP/1.1 400 ", b"HTTP/1.1 413 "), reply[:200]
            assert works(address)

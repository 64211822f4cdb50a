"""The served application: connections, how many, from whom, how slow, how malformed; bodies that end early, and how it stops."""

import asyncio
import contextlib
import errno
import resource
import socket
from contextlib import ExitStack

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.ports.http import server
from radar_service.ports.http.server import SEND_BUFFER, listening_socket, note_fault, possible_connections
from tests.ports.playing import FLAT_OUT, station
from tests.ports.serving import GET, UPGRADE, Address, answer, dialled, radar, served, works
from tests.processes.test_fork_server import until


def test_a_body_that_stops_coming_is_refused_in_time(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("radar_service.ports.http.security.BODY_SECONDS", 0.1)
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


@pytest.mark.parametrize(("limit", "expected"), [(64, 24), (48, 8), (10, 8), (1024, 600), (resource.RLIM_INFINITY, 600)])
def test_connections_leave_descriptors_for_swaps(limit: int, expected: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resource, "getrlimit", lambda _: (limit, limit))
    assert possible_connections(600) == expected and possible_connections(3) == 3


def test_a_connection_for_which_no_descriptor_is_left_is_one_line_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    loop = asyncio.new_event_loop()
    with caplog.at_level("INFO"):
        note_fault(loop, {"message": "accept", "exception": OSError(errno.EMFILE, "x")})
        note_fault(loop, {"message": "another fault", "exception": ValueError("x")})
    loop.close()
    assert [(record.getMessage(), bool(record.exc_info)) for record in caplog.records] == [
        ("no file descriptors are left for connections", False), ("another fault", True)
    ]  # fmt: skip


def test_a_stalled_client_is_left_little_stale_data() -> None:
    """The kernel doubles what is asked for, for its own book-keeping (socket(7))."""
    with listening_socket("127.0.0.1", 0) as listener, dialled(listener.getsockname()[:2]):
        taken, _ = listener.accept()
        with taken:
            assert taken.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF) in (SEND_BUFFER, 2 * SEND_BUFFER)


def test_stopping_says_bye_to_all_and_takes_nobody_any_more() -> None:
    async def listen(address: Address, listening: asyncio.Event) -> tuple[str, int | None]:
        reason = ""
        async with connect(f"ws://{address[0]}:{address[1]}/api/radars/0/feed") as feed:
            with contextlib.suppress(ConnectionClosed):
                async for data in feed:
                    message = wire.unpack(bytes(data))
                    listening.set()
                    reason = message.get("reason", "")
        return reason, feed.close_code

    async def all_of(address: Address, end: contextlib.ExitStack) -> list[tuple[str, int | None]]:
        listening = [asyncio.Event() for _ in range(20)]  # one that still connects is refused, and gets no bye
        clients = [asyncio.create_task(listen(address, event)) for event in listening]
        await asyncio.gather(*(event.wait() for event in listening))
        await asyncio.to_thread(end.close)
        return await asyncio.gather(*clients)

    with contextlib.ExitStack() as end:
        address = end.enter_context(radar())
        parted = asyncio.run(asyncio.wait_for(all_of(address, end), 60))
    assert {code for _, code in parted if _} == {1001}
    assert all(reason == "the server is stopping" and code == 1001 for reason, code in parted)
    with pytest.raises(ConnectionRefusedError):
        dialled(address)


@pytest.mark.parametrize("mode", ["live", "lossless"])
def test_stopping_does_not_wait_for_a_client_that_reads_nothing(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Requests may take an hour here, so that the server ends only where it cuts the connection; else `served` gives up."""
    monkeypatch.setattr("radar_service.ports.http.server.SHUTDOWN_SECONDS", 3600)
    monkeypatch.setattr("radar_service.service.radio.station.LEAVE_TIMEOUT", 0.01)
    only = station(settings=FLAT_OUT)
    with socket.socket() as unread, served(create_app([only]), [only]) as address:
        unread.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        unread.connect(address)
        unread.sendall(UPGRADE.replace(b"/feed", b"/feed?mode=" + mode.encode()))
        until(lambda: any(client.queued > 1 for client in tuple(only.hub.clients)))


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

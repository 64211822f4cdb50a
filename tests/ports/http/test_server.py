"""The served application: bodies that end early, stalled clients, and how it stops."""

import asyncio
import contextlib
import errno
import resource
import socket

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from radar_service import wire
from radar_service.ports.app import create_app
from radar_service.ports.http.server import SEND_BUFFER, listening_socket, note_fault, possible_connections
from tests.ports.http.loopback import UPGRADE, Address, radar, works
from tests.ports.playing import FLAT_OUT, station
from tests.ports.serving import answer, dialled, served
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

"""The served application: bodies that end early, stalled clients, and how it stops."""

import asyncio
import contextlib
import socket

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from radar_service.stream.codecs.native import wire
from radar_service.stream.http.server import SEND_BUFFER, listening_socket
from tests.stream.http.loopback import Address, radar, works
from tests.stream.serving import answer, dialled


def test_a_body_that_stops_coming_is_refused_in_time(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("radar_service.stream.http.security.BODY_SECONDS", 0.1)
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
        parted = asyncio.run(asyncio.wait_for(all_of(address, end), 20))
    assert {code for _, code in parted if _} == {1001}
    assert all(reason == "the server is stopping" and code == 1001 for reason, code in parted)
    with pytest.raises(ConnectionRefusedError):
        dialled(address)

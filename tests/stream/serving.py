"""An application served on a free port of this machine by a thread of this process, for tests of sockets themselves."""

import asyncio
import contextlib
import socket
import threading
from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI

from radar_service.stream.http.server import Server, configuration, listening_socket
from radar_service.stream.radio.station import Station


@contextlib.contextmanager
def served(app: FastAPI, stations: list[Station], **limits: Any) -> Iterator[tuple[str, int]]:
    """Host and port while the application is served; afterwards it has stopped. limits: as `configuration` takes them."""
    listener, begun = listening_socket("127.0.0.1", 0), threading.Event()
    host, port = listener.getsockname()[:2]
    server = Server(configuration(app, **limits), stations, begun.set)
    thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[listener])), name="server under test")
    thread.start()
    try:
        assert begun.wait(20)
        yield str(host), int(port)
    finally:
        server.should_exit = True
        thread.join(20)
        assert not thread.is_alive()


def dialled(address: tuple[str, int]) -> socket.socket:
    """A connection that gives up waiting after ten seconds."""
    return socket.create_connection(address, timeout=10)


def answer(connection: socket.socket) -> bytes:
    """All that comes until the other side closes or resets."""
    got = b""
    with contextlib.suppress(ConnectionResetError):
        while piece := connection.recv(65536):
            got += piece
    return got

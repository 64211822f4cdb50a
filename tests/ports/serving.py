"""An application served on a free port of this machine by a thread of this process, for tests of sockets themselves."""

import asyncio
import contextlib
import gc
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI

from radar_service.ports.app import create_app
from radar_service.ports.http.server import Requests, Server, configuration, listening_socket
from radar_service.service.radio.station import Station, Stations
from radar_service.service.settings import Pace, Settings
from tests.ports.playing import station
from tests.processes.test_fork_server import until


class Turns:
    """How long one piece of work kept the server from all others.

    longest: processor time of the server's thread between two ticks [s]. What else runs on the machine does not count, so
    that tests of behaviour pass there too; `python -m tests.measurements.strangers` judges times.
    """

    def __init__(self) -> None:
        self.longest = 0.0

    async def watch(self) -> None:
        """Looks every 5 ms, until cancelled."""
        before = time.thread_time()
        while True:
            await asyncio.sleep(0.005)
            now = time.thread_time()
            self.longest, before = max(self.longest, now - before), now


@contextlib.contextmanager
def served(
    app: FastAPI, stations: list[Station], turns: Turns | None = None, requests: Requests | None = None, **limits: Any
) -> Iterator[tuple[str, int]]:
    """Host and port while the application is served; afterwards it has stopped.

    requests: those of the application; limits: as `configuration` takes them.
    """
    listener = listening_socket("127.0.0.1", 0)
    host, port = listener.getsockname()[:2]
    server = Server(configuration(app, **limits), Stations(stations).stop, requests or Requests())

    async def serve() -> None:
        watching = asyncio.create_task((turns or Turns()).watch())
        await server.serve(sockets=[listener])
        watching.cancel()

    thread = threading.Thread(target=lambda: asyncio.run(serve()), name="server under test")
    freezes = not gc.get_freeze_count()  # as the service does: a search through all that the tests have left takes 0.2 s
    if freezes:  # the suite has done so, and must not be thawed
        gc.freeze()
    if turns:  # nor is what the suite has left since then looked through: late in a run that took 0.3 s
        gc.disable()
    thread.start()
    try:
        until(lambda: server.started)
        yield str(host), int(port)
    finally:
        server.should_exit = True
        thread.join(20)
        gc.enable()
        if freezes:
            gc.unfreeze()
        assert not thread.is_alive()


def dialled(address: tuple[str, int]) -> socket.socket:
    """A connection that gives up waiting after a minute."""
    return socket.create_connection(address, timeout=60)


def answer(connection: socket.socket) -> bytes:
    """All that comes until the other side closes or resets."""
    got = b""
    with contextlib.suppress(ConnectionResetError):
        while piece := connection.recv(65536):
            got += piece
    return got


Address = tuple[str, int]


GET = b"GET /api/health/alive HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: close\r\n\r\n"


UPGRADE = (
    b"GET /api/radars/0/feed HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: upgrade\r\nupgrade: websocket\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


@contextlib.contextmanager
def radar(refused: list[str] | None = None, turns: Turns | None = None, **limits: float) -> Iterator[Address]:
    only = station(settings=Settings(pace=Pace(factor=10)))
    report = (lambda _: None) if refused is None else refused.append
    with served(create_app([only]), [only], turns, refused=report, **limits) as address:
        yield address


def works(address: Address) -> bool:
    with dialled(address) as connection:
        connection.sendall(GET)
        return b'{"yes":true}' in answer(connection)

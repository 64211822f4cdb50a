"""Sockets: where the server listens, how many connections it takes and from whom, and how it takes its leave."""

import asyncio
import socket
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import h11
import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from radar_service.stream.access import is_loopback
from radar_service.stream.journal import note
from radar_service.stream.station import Station
from radar_service.stream.websocket import FramedWebSocket

INBOUND_LIMIT = 4096  # bytes of a websocket message: clients have nothing to say
SHUTDOWN_SECONDS = 5
SEND_BUFFER = 128 * 2**10  # bytes: what a stalled client later gets as stale spokes (reference/streaming.md, section 2)
BACKLOG = 2048  # connections that wait to be taken
MAX_CONNECTIONS = 600  # all together: the clients of a full radar and some for REST
MAX_PER_ADDRESS = 40  # from one other machine; this one has the whole house
REQUEST_SECONDS = 5.0  # from a connection to the end of its first request's head
FULL = b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncontent-type: text/plain\r\ncontent-length: %d\r\n\r\n%b"


class Door(H11Protocol):
    """A connection: turned away when there are too many, cut when it does not ask for anything in time."""

    def __init__(
        self, *, most: int, per_address: int, seconds: float, refused: Callable[[str], None], **settings: Any
    ) -> None:
        super().__init__(**settings)
        self._most, self._per_address, self._seconds, self._turned_away = most, per_address, seconds, refused
        self._hurry: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take the connection, or say why not."""
        super().connection_made(transport)
        reason = self._crowded()
        if reason:
            self._turned_away("connections")
            transport.write(FULL % (len(reason), reason))
            transport.close()
            return
        self._hurry = self.loop.call_later(self._seconds, self._too_slow)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._calm()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read on; until a request's head is whole there is a hurry, be it the first request or a later one."""
        if self.transport.is_closing():
            return
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._calm()
        elif self._hurry is None:
            self._hurry = self.loop.call_later(self._seconds, self._too_slow)

    def _crowded(self) -> bytes:
        if len(self.connections) > self._most:
            return b"this server has all the connections that it takes; try again later\n"
        host = self.client[0] if self.client else ""
        if not host or is_loopback(host):
            return b""
        same = sum(1 for other in self.connections if _peer(other) == host)
        return b"this address has all the connections that it may have\n" if same > self._per_address else b""

    def _calm(self) -> None:
        if self._hurry:
            self._hurry.cancel()
            self._hurry = None

    def _too_slow(self) -> None:
        self._turned_away("slow request")
        self.transport.abort()


def _peer(connection: Any) -> str:
    peer = connection.transport.get_extra_info("peername") if connection.transport else None
    return str(peer[0]) if peer else ""


class Server(uvicorn.Server):
    """A server that takes leave of the feeds before it closes their sockets. started: called once it is on the air."""

    def __init__(self, config: uvicorn.Config, stations: Sequence[Station], started: Callable[[], None]) -> None:
        super().__init__(config)
        self._stations, self._started = stations, started
        self.gave_up = False

    def give_up(self) -> None:
        """Stop, for a radar cannot go on. May be called from any thread."""
        self.gave_up = self.should_exit = True

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """As usual, then say where to look."""
        await super().startup(sockets)
        for listener in sockets or []:
            host, port = listener.getsockname()[:2]
            note("started", host=host, port=port)
            print(f"radar on the air: open http://{f'[{host}]' if ':' in host else host}:{port}/", flush=True)
        self._started()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Take no more connections, say bye to every client, then close as usual."""
        note("stopping")
        for server in self.servers:
            server.close()  # else who has been told bye comes back at once, and is cut off without a word
        await asyncio.gather(*(station.stop() for station in self._stations))
        await super().shutdown(sockets)


def configuration(
    app: ASGIApp, *, connections: int = MAX_CONNECTIONS, per_address: int = MAX_PER_ADDRESS,
    seconds: float = REQUEST_SECONDS, refused: Callable[[str], None] = lambda _: None,
) -> uvicorn.Config:  # fmt: skip
    """How the application is served. connections, per_address: most at a time; refused: told what was turned away."""
    door: Any = partial(Door, most=connections, per_address=per_address, seconds=seconds, refused=refused)
    return uvicorn.Config(
        app,
        http=door,
        ws=FramedWebSocket,
        log_level="warning",
        access_log=False,
        log_config=None,  # see journal
        server_header=False,
        proxy_headers=False,  # the address of a connection is the one it comes from
        ws_max_size=INBOUND_LIMIT,
        ws_max_queue=4,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=SHUTDOWN_SECONDS,
        backlog=BACKLOG,
    )


def listening_socket(host: str, port: int) -> socket.socket:
    """A socket that takes connections there. Raises OSError naming the place."""
    try:
        listener = socket.create_server(
            (host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET, backlog=BACKLOG
        )
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, f"{host}:{port}") from None
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)  # every connection inherits it
    return listener

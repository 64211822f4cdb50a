"""The server: where it listens, how it is configured, how many may connect and how slowly they may ask, and how it stops.

When it stops, the jobs that requests wait for are cancelled, and each request is answered.
"""

import asyncio
import contextlib
import errno
import logging
import socket
import sys
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, ClassVar

import h11
import uvicorn
from fastapi.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from radar_service.ports.http.websocket import FramedWebSocket
from radar_service.service.access import is_loopback
from radar_service.service.logs import log_event

ANSWER_SECONDS = 0.3  # for the answers of cancelled jobs: their processes end in milliseconds
STOPPING = "the server is stopping; try again when it runs"
PIECE = 1024  # bytes: 170 chunks of one byte, which take 2 ms; 64 KiB of them would silence everybody for 0.2 s
LINGER = 1.0  # s for a refused client to send its request and to read the answer; a socket that is closed before resets it
MAX_LINGERING = 8  # refused connections that wait so, as each takes a file descriptor; more are closed at once
FULL = b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncontent-type: text/plain\r\ncontent-length: %d\r\n\r\n%b"


class Requests:
    """The requests that have no answer yet, but for websockets. Belongs to the event loop.

    cancel_jobs: what cancels the jobs that requests wait for.
    """

    def __init__(self) -> None:
        self.cancel_jobs: list[Callable[[], None]] = []
        self._limits: set[asyncio.Timeout] = set()
        self._answered = asyncio.Event()

    def following(self, app: ASGIApp) -> ASGIApp:
        """Returns the application with each request followed."""

        async def follow(scope: Scope, receive: Receive, send: Send) -> None:
            await (self.follow(app, scope, receive, send) if scope["type"] == "http" else app(scope, receive, send))

        return follow

    async def follow(self, app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
        """Lets the application answer; a request that `end` finds without an answer gets 503."""
        limit = asyncio.timeout(None)

        async def send_answer(message: Message) -> None:
            self._discard(limit)  # what has begun to be answered is not answered again
            await send(message)

        self._limits.add(limit)
        try:
            async with limit:
                await app(scope, receive, send_answer)
        except TimeoutError:
            if limit not in self._limits or not limit.expired():
                raise
            await JSONResponse({"detail": [STOPPING]}, 503)(scope, receive, send)
        finally:
            self._discard(limit)

    async def end(self) -> None:
        """Cancels all jobs, waits at most ANSWER_SECONDS for the answers, and ends the requests that have none."""
        for cancel in self.cancel_jobs:
            cancel()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ANSWER_SECONDS):
                while self._limits:
                    self._answered.clear()
                    await self._answered.wait()
        for limit in self._limits:
            limit.reschedule(0.0)

    def _discard(self, limit: asyncio.Timeout) -> None:
        self._limits.discard(limit)
        self._answered.set()


class LimitedProtocol(H11Protocol):
    """A connection that is refused when there are too many, and closed when its request does not arrive in time."""

    _lingering: ClassVar[set["LimitedProtocol"]] = set()  # refused, but not closed

    def __init__(
        self, *, connections: int, per_address: int, seconds: float, refused: Callable[[str], None], **settings: Any
    ) -> None:
        """connections, per_address: maximum at a time; seconds: until a request's head is complete."""
        super().__init__(**settings)
        self._maximum, self._per_address, self._seconds, self._refused = connections, per_address, seconds, refused
        self._timer: asyncio.TimerHandle | None = None
        self._unread = b""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accepts the connection, or answers with the reason of the refusal."""
        super().connection_made(transport)
        reason = self._refusal()
        if reason:
            self._refused("connections")
            return self._refuse(reason)
        self._start_timer()

    def connection_lost(self, exc: Exception | None) -> None:
        """Removes the connection from the counts."""
        self._stop_timer()
        self._lingering.discard(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Reads on, a piece in each turn of the event loop, but for a body of known length, which is cheap to read."""
        if self in self._lingering:
            return
        self._unread += data
        if len(self._unread) == len(data):  # otherwise the next turn is planned already
            self._read_on()
        else:
            self.transport.pause_reading()

    def _read_on(self) -> None:
        """Reads the next piece. The timer runs while the head of a request, the first or a later one, is not complete."""
        if self.transport.is_closing():
            return
        if self.transport.get_protocol() is not self:  # it has become a websocket, whose client has yet to be admitted
            return self.transport.resume_reading()
        size = len(self._unread) if self._has_length() else PIECE
        piece, self._unread = self._unread[:size], self._unread[size:]
        super().data_received(piece)
        if self.conn.their_state is not h11.IDLE:
            self._stop_timer()
        elif self._timer is None:
            self._start_timer()
        if self._unread:
            self.transport.pause_reading()
            self.loop.call_soon(self._read_on)
        elif not self.flow.read_paused:
            self.transport.resume_reading()

    def _has_length(self) -> bool:
        """Whether the rest of a body arrives whose length is known, and which is not in chunks."""
        is_body = self.conn.their_state is h11.SEND_BODY
        return is_body and all(name != b"transfer-encoding" for name, _ in self.headers)

    def _refusal(self) -> bytes:
        if len(self.connections) > self._maximum:
            return b"this server has all the connections that it takes; try again later\n"
        host = self.client[0] if self.client else ""
        if not host or is_loopback(host):
            return b""
        same = sum(1 for other in self.connections if _peer(other) == host)
        return b"this address has all the connections that it may have\n" if same > self._per_address else b""

    def _refuse(self, reason: bytes) -> None:
        """Answers without reading the request, and closes when the client has, after LINGER at the latest."""
        self.connections.discard(self)
        self.transport.write(FULL % (len(reason), reason))
        if len(self._lingering) >= MAX_LINGERING or not self.transport.can_write_eof():
            return self.transport.close()
        self._lingering.add(self)
        self.transport.write_eof()
        self._timer = self.loop.call_later(LINGER, self.transport.close)

    def _start_timer(self) -> None:
        self._timer = self.loop.call_later(self._seconds, self._time_out)

    def _stop_timer(self) -> None:
        if self._timer:
            self._timer.cancel()
            self._timer = None

    def _time_out(self) -> None:
        self._refused("slow request")
        self.transport.abort()


def _peer(connection: Any) -> str:
    peer = connection.transport.get_extra_info("peername") if connection.transport else None
    return str(peer[0]) if peer else ""


if sys.platform != "win32":
    import resource

INBOUND_LIMIT = 4096  # bytes of a websocket message: the feed ignores what clients send
CUT_SECONDS = 0.3  # that connections may take to close when the server has stopped, before they are cut
SHUTDOWN_SECONDS = 1  # for their requests to end then
SEND_BUFFER = 128 * 2**10  # bytes: what a stalled client later receives as stale spokes (docs/accuracy.md#fan-out)
BACKLOG = 2048  # connections that wait to be taken
MAX_CONNECTIONS = 600  # all together: the clients of a full radar and some for REST
RESERVED, MIN_CONNECTIONS = 40, 8  # descriptors: a service of one radar holds 16, a swap and two jobs take 20 more
MAX_PER_ADDRESS = 40  # from one other machine; this machine has no such limit
REQUEST_SECONDS = 5.0  # from a connection to the end of its first request's head
KEEP_ALIVE = 5  # s, as uvicorn has it


class Server(uvicorn.Server):
    """A server that ends the feeds and answers all requests before it closes their sockets."""

    def __init__(
        self, config: uvicorn.Config, stop_radars: Callable[[], Awaitable[None]], requests: Requests
    ) -> None:  # fmt: skip
        """stop_radars: ends the radars and their feeds; requests: those of the application."""
        super().__init__(config)
        self._stop_radars, self._requests = stop_radars, requests
        self.gave_up = False

    def stop(self) -> None:
        """Stops the server, also while it starts. May be called from any thread."""
        self.should_exit = True

    def give_up(self) -> None:
        """Stops the server because a radar has failed. May be called from any thread."""
        self.gave_up = self.should_exit = True

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Starts to listen, and prints the address."""
        asyncio.get_running_loop().set_exception_handler(note_fault)
        await super().startup(sockets)
        for listener in sockets or []:
            host, port = listener.getsockname()[:2]
            log_event("started", host=host, port=port)
            print(f"radar on the air: open http://{f'[{host}]' if ':' in host else host}:{port}/", flush=True)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Takes no more connections, cancels all jobs, answers all requests, sends `bye` to every client, then closes all
        connections. Clients that do not read are cut."""
        log_event("stopping")
        for server in self.servers:
            server.close()  # otherwise a client that has received its bye reconnects at once and is cut off
        await asyncio.gather(self._requests.end(), self._stop_radars())
        asyncio.get_running_loop().call_later(CUT_SECONDS, self._cut)
        await super().shutdown(sockets)

    def _cut(self) -> None:
        for connection in list(self.server_state.connections):
            connection.transport.abort()


def note_fault(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Logs a fault of the event loop. Where no descriptors are left for a connection, which then waits, this is one line."""
    error = context.get("exception")
    if isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE):
        log_event("no file descriptors are left for connections", logging.WARNING)
    else:
        loop.default_exception_handler(context)


def possible_connections(connections: int) -> int:
    """Returns how many connections can be taken: descriptors stay free for the processes of a swap and of other jobs."""
    if sys.platform == "win32":
        return connections
    descriptors = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if descriptors == resource.RLIM_INFINITY:
        return connections
    return min(connections, max(MIN_CONNECTIONS, descriptors - RESERVED))


def configuration(
    app: ASGIApp, *, connections: int = MAX_CONNECTIONS, per_address: int = MAX_PER_ADDRESS,
    seconds: float = REQUEST_SECONDS, keep_alive: int = KEEP_ALIVE, refused: Callable[[str], None] = lambda _: None,
) -> uvicorn.Config:  # fmt: skip
    """Returns how the application is served. refused: is called with the reason of each refusal.

    connections, per_address: maximum at a time, of connections as far as descriptors allow; seconds: until a request's head
    is complete; keep_alive: until a connection without a further request is closed [s].
    """
    http: Any = partial(
        LimitedProtocol,
        connections=possible_connections(connections),
        per_address=per_address,
        seconds=seconds,
        refused=refused,
    )
    return uvicorn.Config(
        app,
        loop="asyncio",  # uvloop reads up to 8 MB of one connection while all others wait
        http=http,
        ws=FramedWebSocket,
        log_level="warning",
        access_log=False,
        log_config=None,  # see service.logs
        server_header=False,
        proxy_headers=False,  # a connection's address is the one that it comes from
        ws_max_size=INBOUND_LIMIT,
        ws_max_queue=4,
        ws_per_message_deflate=False,
        timeout_keep_alive=keep_alive,
        timeout_graceful_shutdown=SHUTDOWN_SECONDS,
        backlog=BACKLOG,
    )


def listening_socket(host: str, port: int) -> socket.socket:
    """Returns a socket that listens there. Raises OSError that names host and port."""
    try:
        listener = socket.create_server(
            (host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET, backlog=BACKLOG
        )
    except OSError as error:
        raise OSError(error.errno, error.strerror, f"{host}:{port}") from None
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)  # every connection inherits both
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # asyncio leaves it out for such a listener
    return listener

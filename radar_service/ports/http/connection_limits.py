"""Limits on connections: how many, from whom, and how long a request may take to arrive."""

import asyncio
from collections.abc import Callable
from typing import Any, ClassVar

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from radar_service.service.access import is_loopback

PIECE = 1024  # bytes: 170 chunks of one byte, which take 2 ms; 64 KiB of them would silence everybody for 0.2 s
LINGER = 1.0  # s for a refused client to send its request and to read the answer; a socket that is closed before resets it
MAX_LINGERING = 8  # refused connections that wait so, as each takes a file descriptor; more are closed at once
FULL = b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncontent-type: text/plain\r\ncontent-length: %d\r\n\r\n%b"


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

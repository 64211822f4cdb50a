"""Limits on connections: how many, from whom, and how long a request may take to arrive."""

import asyncio
from collections.abc import Callable
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from radar_service.stream.http.access import is_loopback

FULL = b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncontent-type: text/plain\r\ncontent-length: %d\r\n\r\n%b"


class LimitedProtocol(H11Protocol):
    """A connection that is refused when there are too many, and closed when its request does not arrive in time."""

    def __init__(
        self, *, connections: int, per_address: int, seconds: float, refused: Callable[[str], None], **settings: Any
    ) -> None:
        """connections, per_address: maximum at a time; seconds: until a request's head is complete."""
        super().__init__(**settings)
        self._maximum, self._per_address, self._seconds, self._refused = connections, per_address, seconds, refused
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accepts the connection, or answers with the reason of the refusal."""
        super().connection_made(transport)
        reason = self._refusal()
        if reason:
            self._refused("connections")
            transport.write(FULL % (len(reason), reason))
            transport.close()
            return
        self._start_timer()

    def connection_lost(self, exc: Exception | None) -> None:
        """Removes the connection from the counts."""
        self._stop_timer()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Reads on. The timer runs while the head of a request, the first or a later one, is not complete."""
        if self.transport.is_closing():
            return
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._stop_timer()
        elif self._timer is None:
            self._start_timer()

    def _refusal(self) -> bytes:
        if len(self.connections) > self._maximum:
            return b"this server has all the connections that it takes; try again later\n"
        host = self.client[0] if self.client else ""
        if not host or is_loopback(host):
            return b""
        same = sum(1 for other in self.connections if _peer(other) == host)
        return b"this address has all the connections that it may have\n" if same > self._per_address else b""

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

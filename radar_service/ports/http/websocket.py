"""Websockets that also write frames which are encoded already (see `QueueItem.frame`), bound what a client sends, and let the
application say why a connection ends.

The library parses what arrives at once, without a pause: 60 KB of empty pings, 6 bytes each, silence everybody for 0.2 s,
and a client sends them again and again. So each connection has a budget of bytes and of frames.
"""

import asyncio
import math
from collections.abc import Callable
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from radar_service.service.fanout.client_queue import FLUSH, GOING_AWAY, GRACE, TOO_SLOW
from radar_service.service.token_bucket import TokenBucket

EXTENSION = "radar.websocket"  # of the ASGI scope, where the server has it: this object
OPEN = 1  # websockets.protocol.State
BYTES_PER_SECOND, BYTES_AT_ONCE = 4096, 16384  # the feed ignores messages; pongs have a few bytes each 20 s
FRAMES_PER_SECOND, FRAMES_AT_ONCE = 10, 100  # 100 take 2 ms to parse
PIECE = 64  # bytes parsed between two looks at the budget: at most 11 frames
TOO_MUCH, NOT_TEXT = 4429, 1007  # websocket close codes
TOO_MUCH_SENT = "this client sends too much"
CUT_SECONDS = GRACE  # for a client that is not welcome to take what is written before its connection is cut
FLUSH_LOOKS = 0.02  # s between two looks whether all is written

End = Callable[[int, str], None]  # ends a conversation, with a close code and a reason


class FramedWebSocket(WebSocketsSansIOProtocol):
    """A websocket that offers the application to write frames, and is closed where its client sends too much."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self._byte_budget = TokenBucket(BYTES_PER_SECOND, BYTES_AT_ONCE, self.loop.time)
        self._frame_budget = TokenBucket(FRAMES_PER_SECOND, FRAMES_AT_ONCE, self.loop.time)
        self._on_end: End | None = None
        self._ending = self._is_last = False
        self._cut: asyncio.TimerHandle | None = None
        self._pong = b""  # frame that waits for room
        self._unread = 0.0  # bytes that waited for the client when the time for its pong began; all, where it has read since

    def connection_lost(self, exc: Exception | None) -> None:
        """Forgets the connection: there is nothing to cut any more."""
        if self._cut:
            self._cut.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parses within the budget; beyond it closes the connection."""
        if not self.handshake_initiated:  # this is the head of the request, which the HTTP server has bounded
            return super().data_received(data)
        if not self._byte_budget.take(len(data)):
            return self._end(TOO_MUCH, TOO_MUCH_SENT)
        for at in range(0, len(data), PIECE):
            if self.transport.is_closing() or (self._ending and not self.close_sent):
                return
            super().data_received(data[at : at + PIECE])

    def handle_events(self) -> None:
        """Handles the frames of a piece, within the budget."""
        if self._frame_budget.take(len(self.conn.events)):
            super().handle_events()
        else:
            self._end(TOO_MUCH, TOO_MUCH_SENT)

    def send_receive_event_to_app(self) -> None:
        """Passes on a message; text that is not UTF-8 ends the connection (RFC 6455, section 8.1)."""
        try:
            if self.curr_msg_data_type == "text" and not self.close_sent:
                b"".join(self.frames).decode()
        except UnicodeDecodeError:
            self.conn.send_close(NOT_TEXT)
            return self.handle_parser_exception()
        super().send_receive_event_to_app()

    def handle_ping(self) -> None:
        """Answers a ping, or the last one of several when the client takes answers again (RFC 6455, section 5.5.3)."""
        pong = b"".join(self.conn.data_to_send()) or self._pong
        if self.writable.is_set():
            self.transport.write(pong)
        else:
            self._pong = pong

    def resume_writing(self) -> None:
        """Goes on: the client has read."""
        super().resume_writing()
        self._unread = math.inf
        if self._pong and self.conn.state == OPEN:
            self.transport.write(self._pong)
        self._pong = b""

    def pause_writing(self) -> None:
        """Waits until the client has read, but for its last messages."""
        if not self._is_last:
            super().pause_writing()

    def send_keepalive_ping(self) -> None:
        """Sends a ping, and notes what waits before it."""
        super().send_keepalive_ping()
        self._unread = self.transport.get_write_buffer_size()

    def keepalive_timeout(self) -> None:
        """Ends the connection of a client that does not answer pings, unless it has read something: its pong may come."""
        unread = self.transport.get_write_buffer_size()
        if unread < self._unread and not (self.close_sent or self.transport.is_closing()):
            self._unread = unread
            self.pong_timer = self.loop.call_later(self.ping_timeout or 0.0, self.keepalive_timeout)
        else:
            self._end(TOO_SLOW, "this client does not answer pings")

    def shutdown(self) -> None:
        """Ends the connection because the server stops."""
        if self._on_end and self.conn.state == OPEN:
            self._end(GOING_AWAY, "the server is stopping")
        else:
            super().shutdown()
            self._cut_later(CUT_SECONDS)

    async def run_asgi(self) -> None:
        """Runs the application; its scope holds this object. Cuts the connection where its end is not read."""
        extensions: dict[Any, Any] = self.scope.setdefault("extensions", {})
        extensions[EXTENSION] = self
        await super().run_asgi()
        self._cut_later(FLUSH)

    async def send(self, message: Any) -> None:
        """Sends a message of the application; the answer of a refused handshake completes it."""
        await super().send(message)
        if message["type"] == "websocket.http.response.body" and not message.get("more_body", False):
            self.handshake_complete = True  # otherwise the server logs an error for each refused client

    def widen(self, frames_per_second: float, frames_at_once: float, bytes_per_frame: int) -> None:
        """Allows the client so many frames, beside those of every client."""
        frames, at_once = FRAMES_PER_SECOND + frames_per_second, FRAMES_AT_ONCE + frames_at_once
        self._frame_budget = TokenBucket(frames, at_once, self.loop.time)
        self._byte_budget = TokenBucket(
            BYTES_PER_SECOND + frames_per_second * bytes_per_frame, BYTES_AT_ONCE + frames_at_once * bytes_per_frame,
            self.loop.time,
        )  # fmt: skip

    def write_frame(self, ready: bytes) -> bool:
        """Writes a frame at once; returns False, and writes nothing, where there is no room or the websocket has closed."""
        if not self.writable.is_set() or self.disconnected or self.close_sent or self.conn.state != OPEN:
            return False
        self.transport.write(ready)
        return True

    def on_end(self, end: End) -> None:
        """Notes how to end the conversation; the application then sends its last messages and closes the connection."""
        self._on_end = end

    def write_last(self) -> None:
        """Lets the application write its last messages, whatever waits before them."""
        self._is_last = True
        self.writable.set()
        self._cut_later(FLUSH)

    async def flushed(self) -> None:
        """Waits until all that was written has left, or the connection was cut."""
        while self.transport.get_write_buffer_size() and not self.disconnected:
            await asyncio.sleep(FLUSH_LOOKS)

    def _end(self, code: int, reason: str) -> None:
        """Ends the connection, by the application where it can, and reads no more of it."""
        if self._ending:
            return
        self._ending = True
        if self.conn.state != OPEN:
            self.transport.close()
        elif self._on_end:
            self._on_end(code, reason)
        else:
            self.conn.send_close(code, reason)
            self.handle_parser_exception()  # writes what is to be sent, tells the application, and closes
        self._cut_later(CUT_SECONDS)

    def _cut_later(self, seconds: float) -> None:
        """Cuts the connection after so many seconds, or earlier where that was said before."""
        time = self.loop.time() + seconds
        if not self.disconnected and (self._cut is None or time < self._cut.when()):
            if self._cut:
                self._cut.cancel()
            self._cut = self.loop.call_at(time, self._cut_unread)

    def _cut_unread(self) -> None:
        """Cuts the connection, but for one that its client may still close as it should."""
        if self._ending or self.transport.get_write_buffer_size():
            self.transport.abort()


def framed(scope: Any) -> FramedWebSocket | None:
    """Returns the websocket of an ASGI scope, for what it offers beside that interface; None where another server runs."""
    websocket: FramedWebSocket | None = scope.get("extensions", {}).get(EXTENSION)
    return websocket

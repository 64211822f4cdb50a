"""Websockets that also write frames which are encoded already (see `fanout.frames`), and bound what a client sends.

The library parses what arrives at once, without a pause: 60 KB of empty pings, 6 bytes each, silence everybody for 0.2 s,
and a client sends them again and again. So each connection has a budget of bytes and of frames.
"""

from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from radar_service.stream.fanout.frames import Write
from radar_service.stream.token_bucket import TokenBucket

EXTENSION = "radar.frames"  # of the ASGI scope: where the server can write frames, a function that does
BUDGET = "radar.budget"  # of the ASGI scope: a function that allows a client to send more
OPEN = 1  # websockets.protocol.State
BYTES_PER_SECOND, BYTES_AT_ONCE = 4096, 16384  # the feed ignores messages; pongs have a few bytes each 20 s
FRAMES_PER_SECOND, FRAMES_AT_ONCE = 10, 100  # 100 take 2 ms to parse
PIECE = 64  # bytes parsed between two looks at the budget: at most 11 frames
TOO_MUCH = 4429  # websocket close code
CUT_SECONDS = 2.0  # for a client to take what is written before its closed connection is cut


class FramedWebSocket(WebSocketsSansIOProtocol):
    """A websocket that offers the application to write frames, and is closed where its client sends too much."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self._byte_budget = TokenBucket(BYTES_PER_SECOND, BYTES_AT_ONCE, self.loop.time)
        self._frame_budget = TokenBucket(FRAMES_PER_SECOND, FRAMES_AT_ONCE, self.loop.time)

    def data_received(self, data: bytes) -> None:
        """Parses within the budget; beyond it closes the connection."""
        if not self.handshake_initiated:  # this is the head of the request, which the HTTP server has bounded
            return super().data_received(data)
        if not self._byte_budget.take(len(data)):
            return self._end()
        for at in range(0, len(data), PIECE):
            if self.transport.is_closing():
                return
            super().data_received(data[at : at + PIECE])

    def handle_events(self) -> None:
        """Handles the frames of a piece, within the budget."""
        if self._frame_budget.take(len(self.conn.events)):
            super().handle_events()
        else:
            self._end()

    def handle_ping(self) -> None:
        """Answers a ping, where the client takes answers."""
        if self.writable.is_set():
            super().handle_ping()
        else:
            self.conn.data_to_send()  # is forgotten; a client that sends pings and reads nothing would fill the memory

    def keepalive_timeout(self) -> None:
        """Closes the connection of a client that does not answer pings, and cuts it where that client does not read."""
        super().keepalive_timeout()
        self._cut_later()

    async def run_asgi(self) -> None:
        """Runs the application; its scope holds the function that writes frames."""
        extensions: dict[Any, Any] = self.scope.setdefault("extensions", {})
        extensions[EXTENSION] = self.write_frame
        extensions[BUDGET] = self.widen
        await super().run_asgi()

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

    def _end(self) -> None:
        """Closes the connection because its client has sent too much, and cuts it where that client does not read."""
        if self.conn.state == OPEN:
            self.conn.send_close(TOO_MUCH, "this client sends too much")
            self.handle_parser_exception()  # writes what is to be sent, tells the application, and closes
        else:
            self.transport.close()
        self._cut_later()

    def _cut_later(self) -> None:
        self.loop.call_later(CUT_SECONDS, self.transport.abort)


def widen_budget(scope: Any, frames_per_second: float, frames_at_once: float, bytes_per_frame: int) -> None:
    """Allows the client of an ASGI scope to send more, where the server bounds it: see FramedWebSocket.widen."""
    widen = scope.get("extensions", {}).get(BUDGET)
    if widen:
        widen(frames_per_second, frames_at_once, bytes_per_frame)


def frame_writer(scope: Any) -> Write | None:
    """Returns the function that writes frames to the client of an ASGI scope, None where there is none."""
    write: Write | None = scope.get("extensions", {}).get(EXTENSION)
    return write

"""Websocket frames made once for all clients, where the server's own library would make one for each.

A frame of a server is a head of 2, 4 or 10 bytes and the message (RFC 6455, section 5.2): nothing in it depends on who gets
it. Writing it as it is saves two copies of every message for every client and most of the calls on its way.
"""

from collections.abc import Callable
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

EXTENSION = "radar.frames"  # of the ASGI scope: where the server can write frames, a function that does
OPEN = 1  # websockets.protocol.State
FINAL_BINARY = 0x82  # the last, and here only, part of a binary message

Write = Callable[[bytes], bool]  # whether it was written


def frame(data: bytes) -> bytes:
    """The frame of a binary message."""
    size = len(data)
    if size < 126:
        return bytes((FINAL_BINARY, size)) + data
    if size < 2**16:
        return bytes((FINAL_BINARY, 126)) + size.to_bytes(2) + data
    return bytes((FINAL_BINARY, 127)) + size.to_bytes(8) + data


class FramedWebSocket(WebSocketsSansIOProtocol):
    """A websocket that also writes frames as they come."""

    async def run_asgi(self) -> None:
        """Run the application, which finds the way to write frames in its scope."""
        extensions: dict[Any, Any] = self.scope.setdefault("extensions", {})
        extensions[EXTENSION] = self.write_frame
        await super().run_asgi()

    def write_frame(self, ready: bytes) -> bool:
        """Write a frame at once, or nothing where there is no room or the conversation is over; whether it was written."""
        if not self.writable.is_set() or self.disconnected or self.close_sent or self.conn.state != OPEN:
            return False
        self.transport.write(ready)
        return True


def frame_writer(scope: Any) -> Write | None:
    """The way to write frames to the client of an ASGI scope, where there is one."""
    found: Write | None = scope.get("extensions", {}).get(EXTENSION)
    return found

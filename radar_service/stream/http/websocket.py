"""Websockets that also write frames which are encoded already; see `fanout.frames`."""

from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from radar_service.stream.fanout.frames import Write

EXTENSION = "radar.frames"  # of the ASGI scope: where the server can write frames, a function that does
OPEN = 1  # websockets.protocol.State


class FramedWebSocket(WebSocketsSansIOProtocol):
    """A websocket that offers the application to write frames."""

    async def run_asgi(self) -> None:
        """Runs the application; its scope holds the function that writes frames."""
        extensions: dict[Any, Any] = self.scope.setdefault("extensions", {})
        extensions[EXTENSION] = self.write_frame
        await super().run_asgi()

    def write_frame(self, ready: bytes) -> bool:
        """Writes a frame at once; returns False, and writes nothing, where there is no room or the websocket has closed."""
        if not self.writable.is_set() or self.disconnected or self.close_sent or self.conn.state != OPEN:
            return False
        self.transport.write(ready)
        return True


def frame_writer(scope: Any) -> Write | None:
    """Returns the function that writes frames to the client of an ASGI scope, None where there is none."""
    write: Write | None = scope.get("extensions", {}).get(EXTENSION)
    return write

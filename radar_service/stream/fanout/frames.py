"""Websocket frames encoded once for all clients; the server's own library would encode one for each.

A server's frame is a head of 2, 4 or 10 bytes and the message (RFC 6455, section 5.2). Nothing in it depends on the client.
Writing a ready frame saves two copies of every message for every client, and most function calls.
"""

from collections.abc import Callable

FINAL_BINARY = 0x82  # a binary message in one frame

Write = Callable[[bytes], bool]  # writes a frame at once; returns whether it did


def frame(data: bytes) -> bytes:
    """Returns the frame of a binary message."""
    size = len(data)
    if size < 126:
        return bytes((FINAL_BINARY, size)) + data
    if size < 2**16:
        return bytes((FINAL_BINARY, 126)) + size.to_bytes(2) + data
    return bytes((FINAL_BINARY, 127)) + size.to_bytes(8) + data

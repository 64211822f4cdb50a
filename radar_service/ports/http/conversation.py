"""What the websockets of a service share: close codes, and conversations whose parts run side by side."""

import asyncio
from collections.abc import Coroutine
from typing import Any

from starlette.websockets import WebSocket

BAD_REQUEST, FORBIDDEN, NOT_FOUND, UNAVAILABLE = 4400, 4403, 4404, 4503  # websocket close codes
REFUSALS = {BAD_REQUEST: "feed request", FORBIDDEN: "feed rights", NOT_FOUND: "feed radar", UNAVAILABLE: "feed full or down"}


async def until_first_ends(*parts: Coroutine[Any, Any, None]) -> None:
    """Runs the parts of a conversation side by side until one ends, and then ends the others."""
    tasks = [asyncio.create_task(part) for part in parts]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def close_reason(text: str) -> str:
    """Returns as much of a reason as a close frame holds, 123 bytes."""
    return text.encode()[:120].decode(errors="ignore")


async def until_gone(socket: WebSocket) -> None:
    """Ignores client messages; returns on disconnect."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass

"""What websockets share: close codes, parts side by side, which radar a client wants, why it is refused or ended."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.ports.http.websocket import framed
from radar_service.service.fanout.client_queue import GRACE
from radar_service.service.radio.station import Station

BAD_REQUEST, FORBIDDEN, NOT_FOUND, UNAVAILABLE = 4400, 4403, 4404, 4503  # websocket close codes
REFUSALS = {BAD_REQUEST: "feed request", FORBIDDEN: "feed rights", NOT_FOUND: "feed radar", UNAVAILABLE: "feed full or down"}


async def until_first_ends(*parts: Coroutine[Any, Any, object]) -> None:
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


async def send_texts(socket: WebSocket, texts: AsyncIterator[str]) -> None:
    """Sends texts until there are no more, or the socket has closed: the part that reads ends then, too."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        async for text in texts:
            await socket.send_text(text)


async def accepted(
    socket: WebSocket, stations: Mapping[str, Station], radar: str, refused: Callable[[str], None]
) -> Station | None:
    """Accepts a client and returns its radar; None where there is none, and the client is told.

    refused: is called with the kind of each refusal.
    """
    await socket.accept()
    station = stations.get(radar)
    if station is None:
        await refuse(socket, NOT_FOUND, f'radar: there is no "{radar[:40]}"; see /api/radars', refused)
    return station


async def refuse(socket: WebSocket, code: int, reason: str, refused: Callable[[str], None]) -> None:
    """Refuses a client, with a close code of `feed`."""
    refused(REFUSALS[code])
    await say_bye(socket, code, reason)


End = tuple[int, str]  # a close code, and the reason


async def converse(
    socket: WebSocket, *parts: Coroutine[Any, Any, object], end: "asyncio.Future[End] | None" = None
) -> End | None:
    """Runs parts until one ends, or the server has to end the connection; returns how it ends that. end: others may set it."""
    ends: asyncio.Future[End] = end or asyncio.get_running_loop().create_future()
    if websocket := framed(socket.scope):
        websocket.on_end(lambda code, reason: None if ends.done() else ends.set_result((code, reason)))
    await until_first_ends(*parts, asyncio.wait([ends]))
    return ends.result() if ends.done() else None


async def say_bye(socket: WebSocket, code: int, reason: str) -> None:
    """Sends the reason as the last message and closes, where the client takes that in time."""
    if websocket := framed(socket.scope):
        websocket.write_last()
    with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
        async with asyncio.timeout(GRACE):
            await socket.send_text(json.dumps({"type": "bye", "reason": reason}))
            await socket.close(code, close_reason(reason))

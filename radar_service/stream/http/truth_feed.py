"""The websocket of the truth: JSON Lines, one line a message. Off unless the server was started with --truth."""

import asyncio
import contextlib
import json
from collections.abc import Callable, Mapping

from fastapi import APIRouter
from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.stream.fanout.hub import FeedRefused
from radar_service.stream.http.feed import (
    BAD_REQUEST,
    FORBIDDEN,
    GRACE,
    NOT_FOUND,
    REFUSALS,
    UNAVAILABLE,
    close_reason,
    until_first_ends,
    until_gone,
)  # fmt: skip
from radar_service.stream.radio.station import Station
from radar_service.stream.radio.truth_stream import Follower, TruthStream

PATH = "/api/radars/{radar}/truth/stream"


def truth_routes(stations: Mapping[str, Station], refused: Callable[[str], None]) -> APIRouter:
    """Returns the websocket route of the truth. refused: is called with the kind of each refusal."""
    router = APIRouter()

    @router.websocket(PATH)
    async def stream(socket: WebSocket, radar: str) -> None:
        await socket.accept()
        station = stations.get(radar)
        if station is None:
            return await _refuse(socket, NOT_FOUND, f'radar: there is no "{radar[:40]}"; see /api/radars', refused)
        if not station.allow_truth:
            return await _refuse(socket, FORBIDDEN, "truth: this server does not send it; start it with --truth", refused)
        radiometric = socket.query_params.get("radiometric", "0")
        if radiometric not in ("0", "1"):
            reason = f'radiometric: "{radiometric[:40]}" is not 0 or 1; leave it out for 0'
            return await _refuse(socket, BAD_REQUEST, reason, refused)
        if radiometric == "1" and station.engine.fidelity.engine == "documented":
            reason = "radiometric: the fidelity documented has none; leave it out, or start the server with another one"
            return await _refuse(socket, BAD_REQUEST, reason, refused)
        try:
            follower = station.follow_truth(radiometric == "1")
        except FeedRefused as error:
            return await _refuse(socket, UNAVAILABLE, str(error), refused)
        await _serve(socket, station.truth_stream, follower)

    return router


async def _serve(socket: WebSocket, stream: TruthStream, follower: Follower) -> None:
    """Serves one client until it leaves or is ended."""
    try:
        await until_first_ends(_send(socket, stream, follower), until_gone(socket))
    finally:
        stream.leave(follower)
    if follower.reason:
        await _say_bye(socket, follower.code, follower.reason)


async def _send(socket: WebSocket, stream: TruthStream, follower: Follower) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket has closed; until_gone returns too
        async for line in stream.lines(follower):
            await socket.send_text(line)


async def _refuse(socket: WebSocket, code: int, reason: str, refused: Callable[[str], None]) -> None:
    refused(REFUSALS[code])
    await _say_bye(socket, code, reason)


async def _say_bye(socket: WebSocket, code: int, reason: str) -> None:
    """Sends the reason as the last line and closes, where the client takes that in time."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError, TimeoutError):
        async with asyncio.timeout(GRACE):
            await socket.send_text(json.dumps({"type": "bye", "reason": reason}))
            await socket.close(code, close_reason(reason))

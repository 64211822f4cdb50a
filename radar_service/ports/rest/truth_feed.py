"""The websocket of the truth: JSON Lines, one line a message. Off unless the server was started with --truth."""

import contextlib
from collections.abc import Callable, Mapping

from fastapi import APIRouter
from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.ports.http.conversation import (
    BAD_REQUEST,
    FORBIDDEN,
    UNAVAILABLE,
    accepted,
    converse,
    refuse,
    say_bye,
    until_gone,
)
from radar_service.ports.roles import needs
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.radio.station import Station
from radar_service.service.radio.truth_stream import Follower, TruthStream

PATH = "/api/radars/{radar}/truth/stream"


def truth_routes(stations: Mapping[str, Station], refused: Callable[[str], None]) -> APIRouter:
    """Returns the websocket route of the truth. refused: is called with the kind of each refusal."""
    router = APIRouter()

    @router.websocket(PATH)
    @needs("read")
    async def stream(socket: WebSocket, radar: str) -> None:
        if (station := await accepted(socket, stations, radar, refused)) is None:
            return
        if not station.allow_truth:
            return await refuse(socket, FORBIDDEN, "truth: this server does not send it; start it with --truth", refused)
        radiometric = socket.query_params.get("radiometric", "0")
        if radiometric not in ("0", "1"):
            reason = f'radiometric: "{radiometric[:40]}" is not 0 or 1; leave it out for 0'
            return await refuse(socket, BAD_REQUEST, reason, refused)
        if radiometric == "1" and station.epoch.info.fidelity.engine == "documented":
            reason = "radiometric: the fidelity documented has none; leave it out, or start the server with another one"
            return await refuse(socket, BAD_REQUEST, reason, refused)
        try:
            follower = station.follow_truth(radiometric == "1")
        except FeedRefused as error:
            return await refuse(socket, UNAVAILABLE, str(error), refused)
        try:
            end = await converse(socket, _send(socket, station.truth_stream, follower), until_gone(socket))
        finally:
            station.truth_stream.leave(follower)
        if end:
            follower.end(end[1], end[0])
        if follower.reason:
            await say_bye(socket, follower.code, follower.reason)

    return router


async def _send(socket: WebSocket, stream: TruthStream, follower: Follower) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket has closed; until_gone returns too
        async for line in stream.lines(follower):
            await socket.send_text(line)

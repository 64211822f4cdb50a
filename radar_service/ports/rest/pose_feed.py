"""The websocket that takes poses from another simulator: JSON or msgpack objects in, one answer in JSON for each."""

import asyncio
import contextlib
import json
from collections.abc import Callable, Mapping
from typing import Any

from fastapi import APIRouter
from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service import wire
from radar_service.ports.http.conversation import accepted, converse, say_bye
from radar_service.ports.http.websocket import framed
from radar_service.ports.roles import needs
from radar_service.service.fanout.client_queue import GOING_AWAY
from radar_service.service.poses import PoseReader
from radar_service.service.radio.command_worker import NoRadarError, TooManyCommandsError
from radar_service.service.radio.station import Station
from radar_service.service.token_bucket import TokenBucket
from radar_service.strict_json import parsed
from radar_service.world.commands import CommandError

PATH = "/api/radars/{radar}/poses"
POSES_PER_SECOND, POSES_AT_ONCE = 200.0, 100.0  # of one client: four bodies at 50 Hz
BYTES_PER_POSE = 512  # on average, at most
MAX_ANSWERS = 256  # that wait; the client must read them

Answer = dict[str, Any]


def pose_routes(stations: Mapping[str, Station], refused: Callable[[str], None]) -> APIRouter:
    """Returns the websocket route of poses. refused: is called with the kind of each refusal."""
    router = APIRouter()

    @router.websocket(PATH)
    @needs("command")
    async def take_poses(socket: WebSocket, radar: str) -> None:
        if station := await accepted(socket, stations, radar, refused):
            if websocket := framed(socket.scope):
                websocket.widen(POSES_PER_SECOND, POSES_AT_ONCE, BYTES_PER_POSE)
            await _Conversation(socket, station).run()

    return router


class _Conversation:
    """One client that sends poses."""

    def __init__(self, socket: WebSocket, station: Station) -> None:
        self._socket, self._station = socket, station
        self._poses = PoseReader()
        self._budget = TokenBucket(POSES_PER_SECOND, POSES_AT_ONCE, asyncio.get_running_loop().time)
        self._answers: asyncio.Queue[asyncio.Task[Answer]] = asyncio.Queue(MAX_ANSWERS)

    async def run(self) -> None:
        """Serves the client until it leaves."""
        try:
            end = await converse(self._socket, self._take(), self._answer(), self._station.ended.wait())
        finally:
            while not self._answers.empty():
                self._answers.get_nowait().cancel()
        if end:
            await say_bye(self._socket, *end)
        elif self._station.end:
            await say_bye(self._socket, GOING_AWAY, self._station.end)

    async def _take(self) -> None:
        """Reads poses, in order."""
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            await self._answers.put(asyncio.create_task(self._carried_out(message)))

    async def _answer(self) -> None:
        """Sends one answer for each pose, in order."""
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket has closed; `_take` returns too
            while True:
                await self._socket.send_text(json.dumps(await (await self._answers.get()), allow_nan=False))

    async def _carried_out(self, message: Mapping[str, Any]) -> Answer:
        """The answer to a message: the command that it has become, or why there is none."""
        try:
            if not self._budget.take(1):
                raise TooManyCommandsError(f"at most {POSES_PER_SECOND:g} poses a second are taken; send fewer")
            pose = self._poses.read(_content(message), self._station.epoch.info.scene.steerable)
            command = await self._station.commands.command(pose.body, pose.values_at, supersedes=True, by="poses")
        except (CommandError, NoRadarError, TooManyCommandsError) as error:
            return {"type": "refused", "detail": [str(error)]}
        return {"type": "pose", **command.as_dict()}


def _content(message: Mapping[str, Any]) -> object:
    """The object in a message. Raises CommandError."""
    text, data = message.get("text"), message.get("bytes")
    try:
        return parsed(text) if text is not None else wire.unpack_any(data or b"")
    except (ValueError, RecursionError) as error:
        raise CommandError(f"a pose is an object in JSON or msgpack; this message is not: {str(error)[:100]}") from None

"""The websockets of REST: poses in, the truth as JSON Lines (with --truth alone), and changes of the state of radars."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any, NamedTuple

from fastapi import APIRouter
from starlette.websockets import WebSocket

from radar_service import wire
from radar_service.ports.http.conversation import (
    BAD_REQUEST,
    FORBIDDEN,
    UNAVAILABLE,
    End,
    accepted,
    converse,
    refuse,
    say_bye,
    send_texts,
    until_gone,
)
from radar_service.ports.http.security import ROLE
from radar_service.ports.http.websocket import framed
from radar_service.ports.roles import needs
from radar_service.service.fanout.client_queue import GOING_AWAY, TOO_SLOW
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.poses import PoseReader
from radar_service.service.radio.command_worker import NoRadarError, TooManyCommandsError
from radar_service.service.radio.state_changes import SECRET, StateChange, StateWatch
from radar_service.service.radio.station import Station
from radar_service.service.token_bucket import TokenBucket
from radar_service.strict_json import parsed
from radar_service.world import CommandError

POSES_PATH = "/api/radars/{radar}/poses"
POSES_PER_SECOND, POSES_AT_ONCE = 200.0, 100.0  # of one client: four bodies at 50 Hz
BYTES_PER_POSE = 512  # on average, at most
MAX_ANSWERS = 256  # that wait; the client must read them

Answer = dict[str, Any]
TRUTH_PATH = "/api/radars/{radar}/truth/stream"
CHANGES_PATH = "/api/changes"
MAX_WAITING = 256  # changes; a client that reads no more has to connect again
MAX_CLIENTS = 500
FULL = 4503  # websocket close code, as of the feed

BEHIND = "this client does not read; connect again for the present state"

Waiting = asyncio.Queue[str]


def pose_routes(stations: Mapping[str, Station], refused: Callable[[str], None]) -> APIRouter:
    """Returns the websocket route of poses. refused: is called with the kind of each refusal."""
    router = APIRouter()

    @router.websocket(POSES_PATH)
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
            end = await converse(
                self._socket, self._take(), send_texts(self._socket, self._sent()), self._station.ended.wait()
            )
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

    async def _sent(self) -> AsyncIterator[str]:
        """Yields one answer for each pose, in order."""
        while True:
            yield json.dumps(await (await self._answers.get()), allow_nan=False)

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


def truth_routes(stations: Mapping[str, Station], refused: Callable[[str], None]) -> APIRouter:
    """Returns the websocket route of the truth. refused: is called with the kind of each refusal."""
    router = APIRouter()

    @router.websocket(TRUTH_PATH)
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
            end = await converse(socket, send_texts(socket, station.truth_stream.lines(follower)), until_gone(socket))
        finally:
            station.truth_stream.leave(follower)
        if end:
            follower.end(end[1], end[0])
        if follower.reason:
            await say_bye(socket, follower.code, follower.reason)

    return router


class ChangeFeed:
    """The clients of the changes. Belongs to the event loop; `take` may be called from any thread."""

    def __init__(self, stations: Mapping[str, Station], refused: Callable[[str], None]) -> None:
        """refused: is called with the kind of each refusal."""
        self._stations, self._refused = stations, refused
        self._loop: asyncio.AbstractEventLoop | None = None
        self._clients: dict[Waiting, _Listener] = {}

    def start(self) -> None:
        """Remembers the running event loop."""
        self._loop = asyncio.get_running_loop()

    def take(self, change: StateChange) -> None:
        """Sends a change to all clients that may know it."""
        if self._loop:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(self._publish, change)

    def routes(self) -> APIRouter:
        """Returns the route."""
        router = APIRouter()

        @router.websocket(CHANGES_PATH)
        @needs("read")
        async def follow(socket: WebSocket) -> None:
            await socket.accept()
            if len(self._clients) >= MAX_CLIENTS:
                self._refused("changes full")
                return await say_bye(socket, FULL, f"the service has its {MAX_CLIENTS} clients of changes; try again later")
            await self._serve(socket, _Listener(socket.scope.get(ROLE) == "command", asyncio.Future()))

        return router

    async def _serve(self, socket: WebSocket, client: "_Listener") -> None:
        waiting = Waiting()
        for station in self._stations.values():
            for change in StateWatch(station).changes():  # at the first look all
                if self._is_for(change, client):
                    waiting.put_nowait(json.dumps(change.as_dict()))
        self._clients[waiting] = client._replace(most=waiting.qsize() + MAX_WAITING)
        try:
            end = await converse(socket, send_texts(socket, _taken(waiting)), until_gone(socket), end=client.end)
        finally:
            del self._clients[waiting]
        if end:
            await say_bye(socket, *end)

    def _publish(self, change: StateChange) -> None:
        text = json.dumps(change.as_dict())
        for waiting, client in self._clients.items():
            if not self._is_for(change, client):
                continue
            if waiting.qsize() < client.most:
                waiting.put_nowait(text)
            elif not client.end.done():
                client.end.set_result((TOO_SLOW, BEHIND))

    def _is_for(self, change: StateChange, client: "_Listener") -> bool:
        station = self._stations.get(change.radar)
        return change.kind not in SECRET or client.may_command or (station is not None and station.allow_truth)


class _Listener(NamedTuple):
    """may_command: whether it has the token to command; end: why the server has to end it, once it does; most: changes that may
    wait for it."""

    may_command: bool
    end: "asyncio.Future[End]"
    most: int = MAX_WAITING


async def _taken(waiting: Waiting) -> AsyncIterator[str]:
    while True:
        yield await waiting.get()

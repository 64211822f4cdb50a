"""The websocket of changes: what changes in the state of the radars, in JSON, as it happens."""

import asyncio
import contextlib
import json
from collections.abc import Callable, Mapping
from typing import NamedTuple

from fastapi import APIRouter
from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.ports.http.conversation import End, converse, say_bye, until_gone
from radar_service.ports.http.security import ROLE
from radar_service.ports.roles import needs
from radar_service.service.fanout.client_queue import TOO_SLOW
from radar_service.service.radio.state_changes import SECRET, StateChange, StateWatch
from radar_service.service.radio.station import Station

PATH = "/api/changes"
MAX_WAITING = 256  # changes; a client that reads no more has to connect again
MAX_CLIENTS = 500
FULL = 4503  # websocket close code, as of the feed

BEHIND = "this client does not read; connect again for the present state"

Waiting = asyncio.Queue[str]


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

        @router.websocket(PATH)
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
            end = await converse(socket, _send(socket, waiting), until_gone(socket), end=client.end)
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


async def _send(socket: WebSocket, waiting: Waiting) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket has closed; until_gone returns too
        while True:
            await socket.send_text(await waiting.get())

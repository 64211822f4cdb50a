"""The stream of the Signal K API, JSON by websocket: hello, values and their changes out, subscriptions and controls in."""

import asyncio
import contextlib
import json
from collections.abc import Mapping
from datetime import timedelta
from importlib import metadata
from typing import Any

from fastapi import APIRouter, HTTPException
from fastapi.responses import JSONResponse
from starlette.websockets import WebSocket, WebSocketDisconnect

from radar_service.ports.http.conversation import converse, say_bye
from radar_service.ports.http.security import ROLE
from radar_service.ports.http.websocket import framed
from radar_service.ports.port import Service
from radar_service.ports.roles import needs
from radar_service.ports.signalk.controls import CONTROLS
from radar_service.ports.signalk.radar_routes import STREAM, changed, failure, report
from radar_service.ports.signalk.radars import Radars
from radar_service.ports.signalk.subscriptions import SELF, Path, Subscriber, Subscription, SubscriptionError
from radar_service.ports.signalk.values import Values
from radar_service.strict_json import parsed

MAX_CLIENTS = 500
MAX_ANSWERS = 64  # that wait; a client must read them
MESSAGES_PER_SECOND, MESSAGES_AT_ONCE, BYTES_PER_MESSAGE = 20.0, 100.0, 1024  # of one client: a slider that is drawn
SUBSCRIBE = {"none": (), "self": (Subscription(SELF, "*"),), "all": (Subscription("*", "*"),)}
CACHED = ("true", "false")
FULL = 4503  # websocket close code, as of the feed
SOURCE = "radar-service"


class Streams:
    """The clients of the stream. Belongs to the event loop."""

    def __init__(self, service: Service, radars: Radars) -> None:
        self._service, self.radars = service, radars
        self.values = Values(self._note, self.timestamp)
        self._clients: set[_StreamClient] = set()

    def timestamp(self) -> str:
        """Returns the time of the world of the first radar, as text."""
        station = next(iter(self._service.stations.values()))
        utc = station.start_utc + timedelta(seconds=station.transmitter.state.simulated)
        return utc.isoformat(timespec="milliseconds").replace("+00:00", "Z")

    def routes(self) -> APIRouter:
        """Returns the route."""
        router = APIRouter()

        @router.websocket(STREAM)
        @needs("read")
        async def stream(socket: WebSocket) -> None:
            query = socket.query_params
            subscribe, cached = query.get("subscribe", "self"), query.get("sendCachedValues", "true")
            for name, value, allowed in (("subscribe", subscribe, tuple(SUBSCRIBE)), ("sendCachedValues", cached, CACHED)):
                if value not in allowed:
                    return await _refuse(socket, f"{name}: {value[:20]!r} is not one of {', '.join(allowed)}")
            await socket.accept()
            if len(self._clients) >= MAX_CLIENTS:
                self._service.refused("signalk full")
                return await say_bye(
                    socket, FULL, f"the service has its {MAX_CLIENTS} clients of this stream; try again later"
                )
            await self._serve(socket, SUBSCRIBE[subscribe], cached == "true")

        return router

    async def _serve(self, socket: WebSocket, subscriptions: tuple[Subscription, ...], cached: bool) -> None:
        may_command = self._service.access.may(socket.scope.get(ROLE), "command")
        client = _StreamClient(socket, self, may_command)
        if websocket := framed(socket.scope):
            websocket.widen(MESSAGES_PER_SECOND, MESSAGES_AT_ONCE, BYTES_PER_MESSAGE)
        self.values.keep_radars(self.radars)
        client.subscribe(subscriptions, cached)
        self._clients.add(client)
        try:
            await client.run()
        finally:
            self._clients.discard(client)

    def _note(self, path: Path) -> None:
        for client in self._clients:
            client.note(path)


class _StreamClient:
    """One client of the stream."""

    def __init__(self, socket: WebSocket, streams: Streams, may_command: bool) -> None:
        self._socket, self._streams, self._may_command = socket, streams, may_command
        self._subscriber = Subscriber()
        self._described: set[Path] = set()  # paths whose definition it has
        self._answers: asyncio.Queue[str] = asyncio.Queue(MAX_ANSWERS)
        self._news = asyncio.Event()
        self._now = asyncio.get_running_loop().time

    def note(self, path: Path) -> None:
        """Notes that the value of a path is another one."""
        self._subscriber.note(path, self._now())
        self._news.set()

    def subscribe(self, subscriptions: tuple[Subscription, ...], cached: bool = True) -> None:
        """Adds subscriptions; with `cached` the present values are due. Raises SubscriptionError."""
        known = self._streams.values.paths if cached else []
        self._subscriber.subscribe(subscriptions, known, self._now())
        self._news.set()

    async def run(self) -> None:
        """Serves the client until it leaves."""
        if end := await converse(self._socket, self._send(), self._take()):
            await say_bye(self._socket, *end)

    async def _send(self) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the socket has closed; `_take` returns too
            await self._socket.send_text(json.dumps(hello(self._streams.timestamp())))
            while True:
                await self._wait()
                while not self._answers.empty():
                    await self._socket.send_text(self._answers.get_nowait())
                for delta in self._deltas():
                    await self._socket.send_text(json.dumps(delta, allow_nan=False))

    async def _wait(self) -> None:
        """Waits until something is to be sent."""
        due = self._subscriber.next_due
        if due is None or due > self._now():
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout_at(due):
                    await self._news.wait()
        self._news.clear()

    def _deltas(self) -> list[dict[str, Any]]:
        """What is due, a delta for each context."""
        values = self._streams.values
        due = [path for path in self._subscriber.take(self._now()) if path in values]
        contexts = dict.fromkeys(context for context, _ in due)
        return [self._delta(context, [path for path in due if path[0] == context]) for context in contexts]

    def _delta(self, context: str, due: list[Path]) -> dict[str, Any]:
        values, rows = self._streams.values, dict[str, list[dict[str, Any]]]()
        for path in due:
            rows.setdefault(values.time(path), []).append({"path": path[1], "value": values[path]})
        updates: list[dict[str, Any]] = [
            {"$source": SOURCE, "timestamp": time, "values": rows[time]} for time in sorted(rows)
        ]
        meta = [row for path in due if path not in self._described and (row := self._definition(path))]
        self._described.update(due)
        if meta:
            updates[0]["meta"] = meta
        return {"context": context, "updates": updates}

    def _definition(self, path: Path) -> dict[str, Any] | None:
        """The definition of a control, by its path."""
        parts = path[1].split(".")
        station = self._streams.radars.station(parts[1]) if parts[0] == "radars" else None
        for control in CONTROLS:
            if station is not None and control.identity == parts[-1]:
                return {"path": path[1], "value": control.definition(station.epoch.info.scene)}
        return None

    async def _take(self) -> None:
        """Reads messages, in order."""
        while (message := await self._socket.receive())["type"] != "websocket.disconnect":
            if answer := await self._carried_out(message):
                await self._answers.put(json.dumps(answer))
                self._news.set()

    async def _carried_out(self, message: Mapping[str, Any]) -> dict[str, Any] | None:
        """Carries out a message; returns a report of what failed, or of a request that has an id."""
        content: Any = None
        try:
            content = _content(message)
            await self._carry_out(content)
        except Exception as error:  # those that are no refusals are raised again
            result = report(400, str(error)) if isinstance(error, SubscriptionError) else failure(error)
        else:
            result = report(200)
        identity = content.get("requestId") if isinstance(content, Mapping) else None
        if isinstance(identity, str):
            return {"requestId": identity[:100], **result}
        return result if result["statusCode"] != 200 else None

    async def _carry_out(self, content: Mapping[str, Any]) -> None:
        context = content.get("context", SELF)
        for key in ("unsubscribe", "desubscribe"):
            for row in _rows(content, key):
                gone = Subscription.of(context, row)
                self._subscriber.unsubscribe(gone.context, gone.path)
        if "subscribe" in content:
            self.subscribe(tuple(Subscription.of(context, row) for row in _rows(content, "subscribe")))
        change = content.get("put", content)
        if isinstance(change, Mapping) and "path" in change:
            await self._change(change)
        elif not {"subscribe", "unsubscribe", "desubscribe"} & content.keys():
            raise SubscriptionError("message: it has nothing to do; send subscribe, unsubscribe, or path and value")

    async def _change(self, change: Mapping[str, Any]) -> None:
        """Changes a control: its path, and its value beside it or in an object."""
        parts = str(change["path"])[:200].split(".")
        station = (
            self._streams.radars.station(parts[1]) if len(parts) == 4 and parts[::2] == ["radars", "controls"] else None
        )
        if station is None:
            raise HTTPException(
                404, f'path: there is no "{".".join(parts)}" to change; there are radars.ID.controls.CONTROL'
            )
        if not self._may_command:
            raise HTTPException(403, "token: needed to command; connect with the header Authorization: Bearer TOKEN")
        given = {key: value for key, value in change.items() if key not in ("path", "requestId", "context")}
        await changed(station, parts[3], given)


def hello(timestamp: str) -> dict[str, Any]:
    """Returns the first message of a stream. timestamp: of the world, as text."""
    version = metadata.version("radar-service")
    return {"name": SOURCE, "version": version, "timestamp": timestamp, "self": SELF, "roles": ["master", "main"]}


def _content(message: Mapping[str, Any]) -> Mapping[str, Any]:
    try:
        content = parsed(message.get("text") or (message.get("bytes") or b"").decode())
    except (ValueError, RecursionError) as error:
        raise SubscriptionError(f"message: not JSON: {str(error)[:100]}") from None
    if not isinstance(content, Mapping):
        raise SubscriptionError("message: not an object; send one with subscribe, unsubscribe or path")
    return content


def _rows(content: Mapping[str, Any], key: str) -> list[Any]:
    rows = content.get(key, [])
    if not isinstance(rows, list):
        raise SubscriptionError(f"{key}: not a list of rows; send one")
    return rows


async def _refuse(socket: WebSocket, reason: str) -> None:
    """Refuses a client before it is accepted, with status 400 where the server can say so."""
    if "websocket.http.response" in socket.scope.get("extensions", {}):
        await socket.send_denial_response(JSONResponse(report(400, reason), 400))
    else:
        await socket.close(4400, reason[:120])

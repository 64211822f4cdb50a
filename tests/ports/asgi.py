"""An application driven in process: its life span, REST by httpx, websockets by the ASGI messages themselves. No ports."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import httpx
from fastapi import FastAPI

from radar_service import wire
from radar_service.service.radio.station import Station

PATIENCE = 60.0  # s, for what should take milliseconds


class Closed(Exception):
    """The server closed the websocket. code: 403 where it was refused before it was accepted."""

    def __init__(self, code: int) -> None:
        super().__init__(f"closed with {code}")
        self.code = code


class Socket:
    def __init__(self, app: FastAPI, path: str, headers: dict[str, str]) -> None:
        path, _, query = path.partition("?")
        raw = [(key.lower().encode(), value.encode()) for key, value in ({"host": "radar"} | headers).items()]
        scope = {
            "type": "websocket", "asgi": {"version": "3.0"}, "scheme": "ws", "path": path, "raw_path": path.encode(),
            "query_string": query.encode(), "root_path": "", "headers": raw, "subprotocols": [], "client": ("test", 1),
            "server": ("radar", 80), "extensions": {}, "state": {},
        }  # fmt: skip
        self._inbound: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._outbound: asyncio.Queue[dict[str, Any]] = asyncio.Queue(1)  # a network that holds a single message
        self._task = asyncio.create_task(app(scope, self._inbound.get, self._outbound.put))
        self._inbound.put_nowait({"type": "websocket.connect"})

    async def accepted(self) -> None:
        """Wait for the handshake. Raises Closed where it is refused."""
        message = await self._next()
        if message["type"] == "websocket.close":
            raise Closed(403)
        assert message["type"] == "websocket.accept"

    async def raw(self) -> bytes:
        """The bytes of the next message. Raises Closed."""
        return bytes((await self._received())["bytes"])

    async def text(self) -> str:
        """The text of the next message. Raises Closed."""
        return str((await self._received())["text"])

    async def receive(self) -> dict[str, Any]:
        """The next message of the native feed. Raises Closed."""
        return wire.unpack(await self.raw())

    async def until(self, kind: str) -> dict[str, Any]:
        """The next message of that type; others are passed over."""
        while (message := await self.receive())["type"] != kind:
            pass
        return message

    async def spokes(self, count: int) -> list[dict[str, Any]]:
        """The next `spokes` messages, until they hold so many spokes."""
        got: list[dict[str, Any]] = []
        while sum(m["count"] for m in got) < count:
            got.append(await self.until("spokes"))
        return got

    async def say(self, **message: Any) -> None:
        await self._inbound.put({"type": "websocket.receive"} | message)

    @property
    def ended(self) -> bool:
        return self._task.done()

    @property
    def holds_message(self) -> bool:
        """Whether a message waits to be received."""
        return not self._outbound.empty()

    async def leave(self) -> None:
        """Disconnect, and see the server's side end."""
        await self._inbound.put({"type": "websocket.disconnect", "code": 1001})
        while not self._task.done():
            drained = asyncio.create_task(self._outbound.get())
            await asyncio.wait({self._task, drained}, return_when=asyncio.FIRST_COMPLETED, timeout=PATIENCE)
            drained.cancel()
        self._task.result()

    async def _received(self) -> dict[str, Any]:
        message = await self._next()
        if message["type"] == "websocket.close":
            raise Closed(message["code"])
        return message

    async def _next(self) -> dict[str, Any]:
        return await asyncio.wait_for(self._outbound.get(), PATIENCE)


class Server:
    def __init__(self, app: FastAPI, http: httpx.AsyncClient) -> None:
        self.app, self.http = app, http
        self.stations: list[Station] = []
        self._sockets: list[Socket] = []

    async def feed(self, query: str = "", radar: str = "0", **headers: str) -> Socket:
        """A client of a radar's native feed, accepted."""
        return await self.open(f"/api/radars/{radar}/feed{query}", **headers)

    async def open(self, path: str, **headers: str) -> Socket:
        """A websocket, accepted. Raises Closed where it is refused."""
        socket = Socket(self.app, path, headers)
        self._sockets.append(socket)
        await socket.accepted()
        return socket

    async def step(self, spokes: int) -> None:
        """Lets a paused radar send so many spokes."""
        answer = await self.http.patch("/api/radars/0/controls", json={"pace": {"state": "step", "steps": spokes}})
        assert answer.status_code == 200, answer.text

    async def leave(self) -> None:
        for socket in self._sockets:
            await socket.leave()


@asynccontextmanager
async def running(app: FastAPI) -> AsyncIterator[Server]:
    """The application between start-up and shutdown."""
    transport = httpx.ASGITransport(app)
    async with app.router.lifespan_context(app), httpx.AsyncClient(transport=transport, base_url="http://radar") as http:
        server = Server(app, http)
        try:
            yield server
        finally:
            await server.leave()

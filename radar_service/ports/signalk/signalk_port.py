"""Signal K as a port: routes, the stream, and the pages of others."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import RedirectResponse
from starlette.staticfiles import StaticFiles
from typing_extensions import override

from radar_service.ports.port import Port, Service
from radar_service.ports.roles import needs
from radar_service.ports.signalk.radar_routes import radar_routes
from radar_service.ports.signalk.radars import Radars
from radar_service.ports.signalk.stream import Streams
from radar_service.ports.signalk.subscriptions import Path as ValuePath
from radar_service.ports.signalk.values import OwnShipSink
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.spokes import SpokeSink

# Pages of others generate code for protobuf, and style their elements; what they load comes from here all the same.
POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self' ws: wss:; frame-ancestors 'none'; base-uri 'self'"
)


class SignalKPort(Port):
    """The Signal K Radar API. Its spokes are sent by the feed of each radar, with another codec."""

    name = "signalk"

    def __init__(self, gui: Path | None = None) -> None:
        """gui: folder of a page that is served under /gui/."""
        self._gui = gui
        self._loop: asyncio.AbstractEventLoop | None = None
        self._streams: Streams | None = None
        self._own_ship_of: str | None = None  # radar that tells of own ship: the first one

    @override
    def routes(self, service: Service) -> Sequence[APIRouter]:
        radars = Radars(service.stations)
        self._streams = Streams(service, radars)
        routers = [self._streams.routes(), radar_routes(service, radars)]
        return [*routers, gui_routes(self._gui)] if self._gui else routers

    @override
    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        if self._own_ship_of not in (None, radar):
            return ()
        self._own_ship_of = radar
        return (OwnShipSink(self._put),)

    @override
    async def start(self, service: Service) -> None:
        self._loop = asyncio.get_running_loop()

    @override
    def changed(self, change: StateChange) -> None:
        if change.kind in ("controls", "scene"):
            self._call(self._take)

    def _put(self, values: Mapping[ValuePath, Any]) -> None:
        if self._streams:
            streams = self._streams
            self._call(lambda: streams.values.put(values))

    def _take(self) -> None:
        if self._streams:
            self._streams.values.keep_radars(self._streams.radars)

    def _call(self, function: Callable[[], None]) -> None:
        """Has something done on the event loop. From any thread."""
        if self._loop:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(function)


def gui_routes(folder: Path) -> APIRouter:
    """Returns the routes of the page of another program in a folder, which has a content policy of its own."""
    router = APIRouter(include_in_schema=False)
    files = StaticFiles(directory=str(folder), html=True)

    @router.get("/gui")
    @needs("nothing")
    async def to_page() -> RedirectResponse:
        """Leads to the page."""
        return RedirectResponse("/gui/")

    @router.api_route("/gui/{path:path}", methods=["GET", "HEAD"])
    @needs("nothing")
    async def page(path: str, request: Request) -> Response:
        """Returns a file of the page."""
        response = await files.get_response(path or ".", request.scope)
        response.headers["Content-Security-Policy"] = POLICY
        return response

    return router

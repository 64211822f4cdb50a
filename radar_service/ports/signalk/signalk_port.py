"""Signal K as a port: routes, the stream, and the pages of others."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import RedirectResponse
from starlette.staticfiles import StaticFiles

from radar_service.ports.ais.transponders import Transponders
from radar_service.ports.nmea.own_ship import own_reports
from radar_service.ports.port import Port, Service
from radar_service.ports.roles import needs
from radar_service.ports.signalk.codec import SignalKCodec
from radar_service.ports.signalk.radar_routes import radar_routes, refusal
from radar_service.ports.signalk.radars import Radars
from radar_service.ports.signalk.stream import Streams
from radar_service.ports.signalk.subscriptions import Path as ValuePath
from radar_service.ports.signalk.values import own_ship_values, targets_of, vessel_values
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.radio.station import Station, Stations
from radar_service.spoke_source import SpokeSourceFault, TellsShips

if TYPE_CHECKING:
    from radar_service.ports.signalk.announcement import Announcement

# Pages of others generate code for protobuf, and style their elements; what they load comes from here all the same.
POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self' ws: wss:; frame-ancestors 'none'; base-uri 'self'"
)


REPEAT = 10  # ticks: own ship is told each second, unchanged too, as plotters drop what has grown old


class SignalKPort(Port):
    """The Signal K Radar API. Its spokes are sent by the feed of each radar, with another codec."""

    name, period, tells_ships = "signalk", 0.1, True
    refusals, codecs = MappingProxyType({"/signalk": refusal}), (SignalKCodec(),)

    def __init__(
        self, gui: Path | None = None, tells_truth: bool = False, announcement: "Announcement | None" = None
    ) -> None:  # fmt: skip
        """gui: folder of a page that is served under /gui/. tells_truth: whether bodies in sight are told as targets."""
        self._announcement = announcement
        self._gui, self._tells_truth = gui, tells_truth
        self._stations = Stations()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._streams: Streams | None = None
        self._transponders, self._ticks = Transponders(), Counter[str]()

    def routes(self, service: Service) -> Sequence[APIRouter]:
        """Returns all routes."""
        radars = Radars(service.stations)
        self._streams = Streams(service, radars)
        targets = self._streams.values.targets if self._tells_truth else None
        routers = [self._streams.routes(), radar_routes(service, radars, targets)]
        return [*routers, gui_routes(self._gui)] if self._gui else routers

    async def start(self, service: Service) -> None:
        """Begins to announce."""
        self._loop, self._stations = asyncio.get_running_loop(), service.stations
        if self._announcement is not None:
            await self._announcement.start()

    async def stop(self) -> None:
        """Ends the announcement."""
        if self._announcement is not None:
            await self._announcement.stop()

    def tick(self, radar: str, time: float) -> None:
        """Tells own ship and targets."""
        if (station := self._stations.of(radar)) is None:
            return
        is_repeat = self._ticks[radar] % REPEAT == 0
        self._ticks[radar] += 1
        with contextlib.suppress(SpokeSourceFault):  # its process is being replaced
            if station is self._stations.of(None) and isinstance(station.epoch.spoke_source, TellsShips):
                values = self._ship_values(station, time)
                self._call(lambda streams: streams.values.put(values, is_repeat))
            if self._tells_truth and is_repeat:
                targets = targets_of(station.epoch.spoke_source.truth(time), station.epoch.info.scene.origin)
                self._call(lambda streams: streams.values.put_targets(streams.radars.identity(station), targets))

    def changed(self, change: StateChange) -> None:
        """Takes new values of controls."""
        if change.kind in ("controls", "scene") or change.values.get("state") == "ended":
            self._call(lambda streams: streams.values.keep_radars(streams.radars))

    def _ship_values(self, station: Station, time: float) -> dict[ValuePath, Any]:
        """Own ship at a time [s], and what other ships have reported up to it."""
        (own,) = own_reports(station, [time])
        values = own_ship_values(own)
        for each in self._transponders.due(station, time):
            values |= {} if each.is_own else vessel_values(each)
        return values

    def _call(self, function: Callable[[Streams], None]) -> None:
        """Schedules a call on the event loop, from any thread."""
        if self._loop and self._streams:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                self._loop.call_soon_threadsafe(function, self._streams)


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

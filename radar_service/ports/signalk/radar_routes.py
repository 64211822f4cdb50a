"""The HTTP routes of the Signal K Radar API, and the websocket of spokes. Changes and failures are answered by a report."""

from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from typing import Any, cast

from fastapi import APIRouter, HTTPException, Request, Response
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.websockets import WebSocket

from radar_service.ports.feed.feed_socket import serve
from radar_service.ports.http.security import ROLE
from radar_service.ports.port import Service
from radar_service.ports.rest.answers import LINES, STATUS
from radar_service.ports.rest.bodies import parsed_body
from radar_service.ports.roles import needs
from radar_service.ports.signalk.codec import RadarShape, SignalKCodec
from radar_service.ports.signalk.controls import control_of, own_change
from radar_service.ports.signalk.radars import VERSION, Radars, capabilities, control_values, listed
from radar_service.ports.signalk.subscriptions import SELF
from radar_service.service.controls import ControlError
from radar_service.service.radio.station import Station

BASE = "/signalk/v2/api/vessels/self/radars"
STREAM = "/signalk/v1/stream"
API = "/signalk/v1/api/"  # of values, of which only `self` is there: all others come by the stream
STREAM_VERSION = "1.7.0"  # of the Signal K specification, whose deltas the stream has
NO_TARGETS = "targets: this server tracks none; it is what you test your tracker with"
Targets = Callable[[str], Sequence[Any]]  # those of a radar, by its id in the API


def report(status: int, message: str = "OK", **more: Any) -> dict[str, Any]:
    """Returns the report of a change: COMPLETED where the status (of HTTP) is below 400, or FAILED with the reason."""
    return {"state": "COMPLETED" if status < 400 else "FAILED", "statusCode": status, "message": message, **more}


def answered(status: int, message: str = "OK") -> JSONResponse:
    """Returns the report of a change as an answer."""
    return JSONResponse(report(status, message), status)


def refusal(status: int, reason: str) -> tuple[int, dict[str, Any]]:
    """Returns status and report of a refusal; the API has no 422."""
    status = 400 if status == 422 else status
    return status, report(status, reason)


def failure(error: Exception) -> dict[str, Any]:
    """Returns the report of what was raised for a message of the stream; raises it where it is no refusal."""
    if isinstance(error, StarletteHTTPException):
        return refusal(error.status_code, str(error.detail))[1]
    for kind, status in STATUS.items():
        if isinstance(error, kind):
            return refusal(status, "; ".join(LINES[kind](error)) if kind in LINES else str(error))[1]
    raise error


def radar_routes(service: Service, radars: Radars, targets: Targets | None = None) -> APIRouter:
    """Returns the routes under /signalk, but for the stream. targets: None where none are told."""
    router = APIRouter(tags=["signalk"], include_in_schema=False)
    _add_lists(router, radars)
    _add_controls(router, radars)
    _add_targets(router, radars, targets)
    _add_spokes(router, service, radars)

    @router.get("/signalk/{rest:path}")
    @needs("read")
    async def other(rest: str) -> Response:
        """Answers what is not there."""
        return answered(404, f"path: there is no /signalk/{rest[:60]}; there are /signalk, {BASE} and {STREAM}")

    return router


def _add_lists(router: APIRouter, radars: Radars) -> None:
    @router.get("/signalk")
    @needs("read")
    async def discover(request: Request) -> dict[str, Any]:
        """Returns where the parts of the API are."""
        host = request.url.netloc
        web, socket = ("https", "wss") if request.url.scheme == "https" else ("http", "ws")
        stream = f"{socket}://{host}{STREAM}"
        return {
            "endpoints": {
                "v1": {"version": STREAM_VERSION, "signalk-http": f"{web}://{host}{API}", "signalk-ws": stream},
                "v2": {"version": "v2", "signalk-http": f"{web}://{host}{BASE}", "signalk-ws": stream},
            },
            "server": {"version": metadata.version("radar-service"), "id": "radar-service"},
        }

    @router.get(f"{API}self")
    @needs("read")
    async def get_self() -> str:
        """Returns the context of own ship, which servers that read the stream ask for."""
        return SELF

    @router.api_route(BASE, methods=["GET", "HEAD"])
    @needs("read")
    async def list_radars(request: Request) -> dict[str, Any]:
        """Returns all radars by their ids."""
        address = _address(request)
        return {"version": VERSION, "radars": {identity: listed(station, address) for identity, station in radars}}

    @router.get(f"{BASE}/{{radar}}")
    @needs("read")
    async def get_radar(radar: str, request: Request) -> dict[str, Any]:
        """Returns one radar as the list has it."""
        return listed(_station(radars, radar), _address(request))

    @router.get(f"{BASE}/{{radar}}/capabilities")
    @needs("read")
    async def get_capabilities(radar: str) -> dict[str, Any]:
        """Returns what does not change while a radar has its id."""
        return capabilities(_station(radars, radar))


def _add_controls(router: APIRouter, radars: Radars) -> None:
    @router.get(f"{BASE}/{{radar}}/controls")
    @needs("read")
    async def get_controls(radar: str) -> dict[str, Any]:
        """Returns the values of all controls."""
        return control_values(_station(radars, radar))

    @router.get(f"{BASE}/{{radar}}/controls/{{control}}")
    @needs("read")
    async def get_control(radar: str, control: str) -> dict[str, Any]:
        """Returns the value of one control."""
        return control_values(_station(radars, radar))[control_of(control).identity]

    @router.put(f"{BASE}/{{radar}}/controls/{{control}}")
    @needs("command")
    async def change_control(radar: str, control: str, request: Request) -> Response:
        """Changes one control."""
        await changed(_station(radars, radar), control, await _content(request))
        return answered(200)

    @router.put(f"{BASE}/{{radar}}/controls")
    @needs("command")
    async def change_controls(radar: str, request: Request) -> Response:
        """Changes several controls in the order of their numbers; none where one of them is not known."""
        station, requested = _station(radars, radar), await _content(request)
        if not isinstance(requested, Mapping):
            raise HTTPException(400, "body: not an object with values of controls by their ids; send one")
        by_number = sorted(requested, key=lambda name: control_of(name).number)
        failures = []
        for name in by_number:
            try:
                await changed(station, name, requested[name])
            except ControlError as error:
                failures.append(str(error))
        return answered(400, "; ".join(failures)) if failures else answered(200)


def _add_targets(router: APIRouter, radars: Radars, targets: Targets | None) -> None:
    @router.get(f"{BASE}/{{radar}}/targets")
    @needs("read")
    async def get_targets(radar: str) -> Any:
        """Returns the truth as targets, where it is told."""
        _station(radars, radar)
        return answered(501, NO_TARGETS) if targets is None else targets(radar)

    async def no_targets(radar: str) -> Response:
        """Answers that nothing is tracked."""
        _station(radars, radar)
        return answered(501, NO_TARGETS)

    for path, methods in (("targets", ["POST"]), ("targets/acquire", ["POST"]), ("targets/{target}", ["DELETE"])):
        router.api_route(f"{BASE}/{{radar}}/{path}", methods=methods)(needs("read")(no_targets))


def _add_spokes(router: APIRouter, service: Service, radars: Radars) -> None:
    codec = SignalKCodec()

    @router.websocket(codec.path)
    @needs("read")
    async def spokes(socket: WebSocket, radar: str) -> None:
        station = radars.station(radar)
        request = None if station is None else RadarShape.of(station.epoch.info).request
        may_command = service.access.may(socket.scope.get(ROLE), "command")
        await serve(socket, codec, station, may_command, service.refused, request)


async def changed(station: Station, control: str, given: Any) -> None:
    """Changes a control of a radar by its id in the API. Raises what `own_change` and Station.change raise."""
    await station.change(own_change(control, given, station.epoch.info.scene))


def _station(radars: Radars, identity: str) -> Station:
    station = radars.station(identity)
    if station is None:
        raise HTTPException(404, f'radar: there is no "{identity[:40]}"; there are {", ".join(name for name, _ in radars)}')
    return station


def _address(request: Request) -> str:
    server = cast(tuple[str, int] | None, request.scope.get("server"))
    return server[0] if server else "127.0.0.1"


async def _content(request: Request) -> Any:
    """The JSON of a body. Raises HTTPException."""
    content, refusal = parsed_body(await request.body())
    if refusal:
        raise HTTPException(400, "; ".join(refusal[1]))
    return content

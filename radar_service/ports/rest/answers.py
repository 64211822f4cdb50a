"""Answers to requests that are refused: their description in OpenAPI, and the exceptions that become them."""

import errno
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from fastapi import APIRouter, FastAPI, HTTPException, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.requests import ClientDisconnect

from radar_service.plug_ins import PlugInError
from radar_service.ports.http.security import ROLE
from radar_service.ports.rest import schemas
from radar_service.ports.rest.scene_store import Conflict
from radar_service.ports.rest.schemas import problem_lines
from radar_service.processes.call import ProcessFault
from radar_service.processes.limits import MachineBusyError
from radar_service.service.controls import ControlError
from radar_service.service.jobs import RETRY_SECONDS, Busy, Cancelled, DuplicateJob
from radar_service.service.radio.command_worker import NoRadarError, TooManyCommandsError
from radar_service.service.radio.station import Station
from radar_service.spoke_source import BusyFault, SpokeSourceFault
from radar_service.world import CommandError, NotSteerableError, SceneError, UnknownBodyError

Answers = dict[int | str, dict[str, Any]]

REFUSED: Answers = {422: {"model": schemas.Problem, "description": "refused; `detail` says why"}}
# The others name the schema that REFUSED brings: a model anew for each answer of each route is half the time to make an app.
PROBLEM = {"content": {"application/json": {"schema": {"$ref": f"#/components/schemas/{schemas.Problem.__name__}"}}}}
UNKNOWN: Answers = {404: {"description": "there is no such radar or scene", **PROBLEM}}
FORBIDDEN: Answers = {403: {"description": "this server does not give it", **PROBLEM}}
CONFLICT: Answers = {409: {"description": "the present state does not allow it", **PROBLEM}}
UNREADABLE: Answers = {
    400: {"description": "the body cannot be read", **PROBLEM},
    413: {"description": "the body is too long", **PROBLEM},
}
STORED: Answers = {507: {"description": "the server's disk has no room for the body", **PROBLEM}}
BUSY: Answers = {503: {"description": "too much is being done; Retry-After says when to try again", **PROBLEM}}
PROTECTED: Answers = {
    401: {"description": "a token is needed", **PROBLEM},
    421: {"description": "the server does not have that host name", **PROBLEM},
}


NO_ROOM, NO_DESCRIPTORS = (errno.ENOSPC, errno.EDQUOT), (errno.EMFILE, errno.ENFILE)
STATUS: dict[type[Exception], int] = {
    SceneError: 422, PlugInError: 422, ControlError: 422, CommandError: 422, SpokeSourceFault: 422, RequestValidationError: 422,
    ClientDisconnect: 400, UnknownBodyError: 404,
    NotSteerableError: 409, NoRadarError: 409, Conflict: 409, Cancelled: 409, DuplicateJob: 409,
    ProcessFault: 503, TooManyCommandsError: 503, Busy: 503, MachineBusyError: 503, BusyFault: 503,
}  # fmt: skip
LINES: dict[type[Exception], Callable[[Any], Sequence[str]]] = {  # of the others: what they say
    SceneError: lambda error: error.problems,
    PlugInError: lambda error: [f"scene: {error}"],
    SpokeSourceFault: lambda error: [f"scene: {error}"],
    RequestValidationError: lambda error: problem_lines(error.errors()),
    ClientDisconnect: lambda error: ["body: it ended too early; send it whole"],
}
FOR_NOW = (TooManyCommandsError, Busy, MachineBusyError, BusyFault)  # the answer says when to try again
RETRY = {"Retry-After": str(RETRY_SECONDS)}


def api_router(tag: str, kind: type[APIRoute] = APIRoute) -> APIRouter:
    """Returns a router of paths under /api, whose answers where a token or a host is refused OpenAPI knows."""
    return APIRouter(prefix="/api", tags=[tag], route_class=kind, responses=PROTECTED)


def add_exception_handlers(app: FastAPI) -> None:
    """Makes the application answer refusals with a list of lines under `detail`."""
    for kind, status in STATUS.items():
        lines = LINES.get(kind, lambda error: [str(error)])
        app.add_exception_handler(kind, partial(_refused, status, lines, RETRY if kind in FOR_NOW else None))
    app.add_exception_handler(OSError, _system_error)
    app.add_exception_handler(StarletteHTTPException, _http_error)


async def _refused(
    status: int, lines: Callable[[Any], Sequence[str]], headers: Mapping[str, str] | None, _: Request, error: Exception
) -> JSONResponse:
    return JSONResponse({"detail": list(lines(error))}, status, headers)


async def _system_error(_: Request, error: Any) -> JSONResponse:
    if error.errno in NO_ROOM:
        return JSONResponse({"detail": ["body: the server's disk is full; try again later"]}, 507)
    if error.errno in NO_DESCRIPTORS:
        lines = ["request: the server has no file descriptors left; close clients, or raise its limit (ulimit -n)"]
        return JSONResponse({"detail": lines}, 503, RETRY)
    raise error


async def _http_error(_: Request, error: Any) -> JSONResponse:
    detail = error.detail  # this service gives lists of lines, the framework gives text
    return JSONResponse({"detail": detail if isinstance(detail, list) else [str(detail)]}, error.status_code, error.headers)


def knows_truth(request: Request, station: Station) -> bool:
    """Returns whether a client may know what the scene does: on a server with --truth, or with the token to command."""
    return station.allow_truth or request.scope.get(ROLE) == "command"


def check_knows_truth(request: Request, station: Station, what: str) -> None:
    """Raises HTTPException, 403, for a client that may not know the truth. what: is requested."""
    if not knows_truth(request, station):
        raise HTTPException(
            403, [f"{what}: readers are not told; send the token to command, or start the server with --truth"]
        )


def station_of(stations: Mapping[str, Station], radar: str) -> Station:
    """Returns a radar by its id. Raises HTTPException, 404, where there is none."""
    if radar not in stations:
        raise HTTPException(404, [f'radar: there is no "{radar[:40]}"; there are {", ".join(stations)}'])
    return stations[radar]

"""Answers to requests that are refused: their description in OpenAPI, and the exceptions that become them."""

import errno
from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import FastAPI, HTTPException, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException as StarletteHTTPException
from starlette.requests import ClientDisconnect

from radar_service.ports.http.security import ROLE
from radar_service.ports.rest import schemas
from radar_service.ports.rest.scene_store import Conflict
from radar_service.ports.rest.schemas import problem_lines
from radar_service.processes.call import ProcessFault
from radar_service.processes.limits import MachineBusyError
from radar_service.service.controls import ControlError
from radar_service.service.jobs import RETRY_SECONDS, Busy, Cancelled, DuplicateJob
from radar_service.service.radio.command_worker import NoRadarError, TooManyCommandsError
from radar_service.service.radio.prefetch import BusyFault, SpokeSourceFault
from radar_service.service.radio.station import Station
from radar_service.world.commands import CommandError, NotSteerableError, UnknownBodyError
from radar_service.world.error import SceneError

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
COMMAND_STATUS: dict[type, int] = {UnknownBodyError: 404, NotSteerableError: 409}  # other commands: 422


def add_exception_handlers(app: FastAPI) -> None:
    """Makes the application answer refusals with a list of lines under `detail`."""

    def refuse(status: int, lines: Sequence[str]) -> JSONResponse:
        return JSONResponse({"detail": list(lines)}, status)

    @app.exception_handler(SceneError)
    async def scene_error(_: Request, error: SceneError) -> JSONResponse:
        return refuse(422, error.problems)

    @app.exception_handler(ControlError)
    async def control_error(_: Request, error: ControlError) -> JSONResponse:
        return refuse(422, [str(error)])

    @app.exception_handler(CommandError)
    async def command_error(_: Request, error: CommandError) -> JSONResponse:
        return refuse(COMMAND_STATUS.get(type(error), 422), [str(error)])

    @app.exception_handler(SpokeSourceFault)
    async def spoke_source_fault(_: Request, error: SpokeSourceFault) -> JSONResponse:
        return refuse(422, [f"scene: {error}"])

    @app.exception_handler(OSError)
    async def system_error(_: Request, error: OSError) -> JSONResponse:
        if error.errno in NO_ROOM:
            return refuse(507, ["body: the server's disk is full; try again later"])
        if error.errno in NO_DESCRIPTORS:
            lines = ["request: the server has no file descriptors left; close clients, or raise its limit (ulimit -n)"]
            return JSONResponse({"detail": lines}, 503, {"Retry-After": str(RETRY_SECONDS)})
        raise error

    @app.exception_handler(NoRadarError)
    @app.exception_handler(Conflict)
    @app.exception_handler(Cancelled)
    @app.exception_handler(DuplicateJob)
    async def conflict(_: Request, error: Exception) -> JSONResponse:
        return refuse(409, [str(error)])

    @app.exception_handler(TooManyCommandsError)
    @app.exception_handler(Busy)
    @app.exception_handler(MachineBusyError)
    @app.exception_handler(BusyFault)
    async def busy(_: Request, error: Exception) -> JSONResponse:
        return JSONResponse({"detail": [str(error)]}, 503, {"Retry-After": str(RETRY_SECONDS)})

    @app.exception_handler(ProcessFault)
    async def process_fault(_: Request, error: ProcessFault) -> JSONResponse:
        return refuse(503, [str(error)])

    @app.exception_handler(RequestValidationError)
    async def invalid(_: Request, error: RequestValidationError) -> JSONResponse:
        return refuse(422, problem_lines(error.errors()))

    @app.exception_handler(ClientDisconnect)
    async def disconnected(_: Request, error: ClientDisconnect) -> JSONResponse:
        return refuse(400, ["body: it ended too early; send it whole"])

    @app.exception_handler(StarletteHTTPException)
    async def http_error(_: Request, error: StarletteHTTPException) -> JSONResponse:
        detail: object = error.detail  # this service gives lists of lines, the framework gives text
        lines = detail if isinstance(detail, list) else [str(detail)]
        return JSONResponse({"detail": lines}, error.status_code, error.headers)


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

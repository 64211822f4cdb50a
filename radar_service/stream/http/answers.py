"""Answers to requests that are refused: their description in OpenAPI, and the exceptions that become them."""

from collections.abc import Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from radar_service.scene.error import SceneError
from radar_service.stream.controls import ControlError
from radar_service.stream.http import schemas
from radar_service.stream.http.scene_store import Conflict
from radar_service.stream.radio.prefetch import EngineFault

Answers = dict[int | str, dict[str, Any]]

REFUSED: Answers = {422: {"model": schemas.Problem, "description": "refused; `detail` says why"}}
UNKNOWN: Answers = {404: {"model": schemas.Problem, "description": "there is no such radar or scene"}}
FORBIDDEN: Answers = {403: {"model": schemas.Problem, "description": "this server does not give it"}}
CONFLICT: Answers = {409: {"model": schemas.Problem, "description": "the present state does not allow it"}}
UNREADABLE: Answers = {
    400: {"model": schemas.Problem, "description": "the body cannot be read"},
    413: {"model": schemas.Problem, "description": "the body is too long"},
}
PROTECTED: Answers = {
    401: {"model": schemas.Problem, "description": "a token is needed"},
    421: {"model": schemas.Problem, "description": "the server does not have that host name"},
}


def problem_lines(errors: Sequence[Any]) -> list[str]:
    """Returns one line for each of pydantic's errors: the key, the value where it is short, the problem."""
    lines = []
    for error in errors[:20]:
        key = ".".join(str(step) for step in error["loc"] if step not in ("body", "query", "path")) or "body"
        value = repr(error.get("input"))
        shown = f" {value};" if len(value) <= 80 else ""
        lines.append(f"{key}:{shown} {error['msg']}")
    return lines


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

    @app.exception_handler(EngineFault)
    async def engine_fault(_: Request, error: EngineFault) -> JSONResponse:
        return refuse(422, [f"scene: {error}"])

    @app.exception_handler(Conflict)
    async def conflict(_: Request, error: Conflict) -> JSONResponse:
        return refuse(409, [str(error)])

    @app.exception_handler(RequestValidationError)
    async def invalid(_: Request, error: RequestValidationError) -> JSONResponse:
        return refuse(422, problem_lines(error.errors()))

    @app.exception_handler(ClientDisconnect)
    async def disconnected(_: Request, error: ClientDisconnect) -> JSONResponse:
        return refuse(400, ["body: it ended too early; send it whole"])

    @app.exception_handler(HTTPException)
    async def http_error(_: Request, error: HTTPException) -> JSONResponse:
        detail: object = error.detail  # this service gives lists of lines, the framework gives text
        lines = detail if isinstance(detail, list) else [str(detail)]
        return JSONResponse({"detail": lines}, error.status_code, error.headers)

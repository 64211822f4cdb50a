"""Answers of the Signal K API: every change and every failure has `state`, `statusCode` and `message`."""

from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import Request, Response
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException as StarletteHTTPException

from radar_service.ports.rest.answers import LINES, STATUS
from radar_service.ports.signalk.controls import UnknownControlError


def report(status: int, message: str = "OK", **more: Any) -> dict[str, Any]:
    """Returns the report of a change: COMPLETED where the status (of HTTP) is below 400, or FAILED with the reason."""
    return {"state": "COMPLETED" if status < 400 else "FAILED", "statusCode": status, "message": message, **more}


def answered(status: int, message: str = "OK") -> JSONResponse:
    """Returns the report of a change as an answer."""
    return JSONResponse(report(status, message), status)


def problem(error: Exception) -> tuple[int, str]:
    """Returns status and reason of what was raised for a request; raises it where it is no refusal."""
    if isinstance(error, UnknownControlError):
        return 404, str(error)
    if isinstance(error, StarletteHTTPException):
        detail: Any = error.detail  # the framework's is text
        return _of_api(error.status_code), "; ".join(detail) if isinstance(detail, list) else str(detail)
    for kind, status in STATUS.items():
        if isinstance(error, kind):
            return _of_api(status), "; ".join(LINES[kind](error)) if kind in LINES else str(error)
    raise error


def _of_api(status: int) -> int:
    return 400 if status == 422 else status  # the API has no 422


class SignalKRoute(APIRoute):
    """A route whose refusals have the shape of the API."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Returns the route's handler with such answers."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            try:
                return await handler(request)
            except Exception as error:  # those that are no refusals are raised again
                return answered(*problem(error))

        return handle

"""Answers of the Signal K API: every change and every failure has `state`, `statusCode` and `message`."""

from typing import Any

from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException as StarletteHTTPException

from radar_service.ports.rest.answers import LINES, STATUS


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

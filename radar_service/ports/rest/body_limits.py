"""Bounds the body of every request before anything reads it, whatever the framework does.

A length that the client states is checked at once; a body that comes in chunks is counted.
"""

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from radar_service.ports.rest.bodies import MAX_JSON_BYTES, SMALL
from radar_service.ports.rest.scene_store import MAX_UPLOAD_BYTES

STATUS = 413


class BodyLimitMiddleware:
    """Answers 413 to a request with a body that is too long."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        maximum, length = max_body(scope), Headers(scope=scope).get("content-length", "")
        if length.isdecimal() and int(length[:20]) > maximum:
            return await JSONResponse({"detail": _lines(maximum)}, STATUS)(scope, receive, send)
        await self._app(scope, _counted(receive, maximum), send)


def max_body(scope: Scope) -> int:
    """Returns the bytes that the body of a request may have: many only where a scene is expected."""
    path = tuple(scope["path"].strip("/").split("/"))
    match scope["method"], path:
        case "POST", ("api", "scenes"):
            is_form = Headers(scope=scope).get("content-type", "").lower().startswith("multipart/")
            return MAX_UPLOAD_BYTES if is_form else MAX_JSON_BYTES
        case "PUT", ("api", "radars", _, "scene"):
            return MAX_JSON_BYTES
    return SMALL


def _counted(receive: Receive, maximum: int) -> Receive:
    """Returns a receiver that raises HTTPException where the body exceeds its maximum [bytes]."""
    size = 0

    async def receive_counted() -> Message:
        nonlocal size
        message = await receive()
        size += len(message.get("body", b""))
        if size > maximum:
            raise HTTPException(STATUS, _lines(maximum))  # type: ignore[arg-type]  # as answers.py takes it
        return message

    return receive_counted


def _lines(maximum: int) -> list[str]:
    return [f"body: more than {maximum} bytes; this request may have no more"]

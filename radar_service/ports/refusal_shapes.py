"""Refusals in the terms of a protocol, also of host, origin, token, method and size, before its port is asked.

All refusals are `{"detail": [...]}` in JSON; below the paths of such a protocol they are written anew.
"""

import json
from collections.abc import Callable, Mapping
from typing import Any

from starlette.datastructures import MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

Shape = Callable[[int, str], tuple[int, Mapping[str, Any]]]  # from a status of HTTP and a reason those of the answer


class RefusalShapesMiddleware:
    """Writes refusals anew. shapes: by the beginning of the paths that have them."""

    def __init__(self, app: ASGIApp, shapes: Mapping[str, Shape]) -> None:
        self._app, self._shapes = app, shapes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        shape = self._shape(scope["path"]) if scope["type"] == "http" else None
        await self._app(scope, receive, send if shape is None else _reshaping(send, shape))

    def _shape(self, path: str) -> Shape | None:
        return next((shape for begin, shape in self._shapes.items() if path == begin or path.startswith(begin + "/")), None)


def _reshaping(send: Send, shape: Shape) -> Send:
    """Returns a sender of one answer that keeps a refusal until its body is whole."""
    refusal: Message | None = None  # its start
    body = b""

    async def send_reshaped(message: Message) -> None:
        nonlocal refusal, body
        if message["type"] == "http.response.start" and message["status"] >= 400:
            refusal = message
        elif refusal is None:
            await send(message)
        else:
            body += message.get("body", b"")
            if not message.get("more_body", False):
                status, content = _reshaped(refusal["status"], body, shape)
                MutableHeaders(scope=refusal)["content-length"] = str(len(content))
                await send({**refusal, "status": status})
                await send({"type": "http.response.body", "body": content})

    return send_reshaped


def _reshaped(status: int, body: bytes, shape: Shape) -> tuple[int, bytes]:
    """Status and body of a refusal in another shape; one that has no `detail` has a shape of its own already."""
    try:
        detail = json.loads(body)["detail"]
    except (ValueError, KeyError, TypeError):
        return status, body
    status, content = shape(status, "; ".join(map(str, detail)) if isinstance(detail, list) else str(detail))
    return status, bytes(JSONResponse(content).body)

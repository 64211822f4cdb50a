"""Refusals in the terms of a protocol, also of what is refused before its port is asked: host, origin, token, method, size.

Whatever refuses a request answers `{"detail": [...]}` in JSON. Below the paths of a protocol that has a shape of its own, this is
written anew on its way out.
"""

import json
from collections.abc import Callable, Mapping
from typing import Any

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

Shape = Callable[[int, str], Mapping[str, Any]]  # from a status of HTTP and a reason, the body of an answer


class RefusalShapesMiddleware:
    """Writes refusals anew. shapes: by the beginning of the paths that have them."""

    def __init__(self, app: ASGIApp, shapes: Mapping[str, Shape]) -> None:
        self._app, self._shapes = app, shapes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        shape = self._shape(scope["path"]) if scope["type"] == "http" else None
        await self._app(scope, receive, send if shape is None else _Answer(shape, send))

    def _shape(self, path: str) -> Shape | None:
        return next((shape for begin, shape in self._shapes.items() if path == begin or path.startswith(begin + "/")), None)


class _Answer:
    """Sends one answer on, a refusal in another shape."""

    def __init__(self, shape: Shape, send: Send) -> None:
        self._shape, self._send = shape, send
        self._start: Message | None = None  # of a refusal, until its body is whole
        self._body = b""

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start" and message["status"] >= 400:
            self._start = message
        elif self._start is None:
            await self._send(message)
        else:
            self._body += message.get("body", b"")
            if not message.get("more_body", False):
                await self._finish(self._start)

    async def _finish(self, start: Message) -> None:
        body = _reshaped(self._body, start["status"], self._shape)
        MutableHeaders(scope=start)["content-length"] = str(len(body))
        await self._send(start)
        await self._send({"type": "http.response.body", "body": body})


def _reshaped(body: bytes, status: int, shape: Shape) -> bytes:
    """The body of a refusal in another shape; one that has no `detail` has a shape of its own already."""
    try:
        detail = json.loads(body)["detail"]
    except (ValueError, KeyError, TypeError):
        return body
    return json.dumps(shape(status, "; ".join(map(str, detail)) if isinstance(detail, list) else str(detail))).encode()

"""What stands before the application: the names it answers to, whose pages and tokens pass, how long a body may take."""

import asyncio
import time
from collections.abc import Callable
from urllib.parse import parse_qs, urlsplit

from fastapi.responses import JSONResponse
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from radar_service.stream.access import Access, Rank

SECURITY_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'self'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
}
SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
GUARDED = ("/api/", "/metrics")  # the page itself holds nothing that is not public
OPEN = ("/api/health/alive", "/api/health/ready")  # for whoever restarts the process
TICKETS = "/api/tickets"
BODY_SECONDS = 20.0  # between two pieces of a body
RANK = "radar.rank"  # key of the scope under which the caller's rank travels

Refusal = tuple[int, str]


class Guard:
    """Refuses what may not pass, before anything is read; every answer carries the security headers.

    A browser names the page's origin; programs name none and pass. Plain requests that change nothing pass too: without
    leave by CORS, which is never given, a foreign page cannot read the answers. refused: told the reason in a word.
    """

    def __init__(
        self, app: ASGIApp, access: Access, refused: Callable[[str], None] = lambda _: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._app, self._access, self._refused, self._clock = app, access, refused, clock

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        sending = _adding_headers(send) if scope["type"] == "http" else send
        refusal = self._judged(scope)
        if refusal:
            self._refused(refusal[1].partition(":")[0])
            return await _refuse(scope, receive, sending, refusal)
        await self._app(scope, _in_time(receive) if scope["type"] == "http" else receive, sending)

    def _judged(self, scope: Scope) -> Refusal | None:
        headers, is_command = Headers(scope=scope), scope["type"] == "http" and scope["method"] not in SAFE_METHODS
        if not self._access.answers_to(headers.get("host", "")):
            return 421, "host: this server does not go by that name; start it with --allow-host NAME, or use its address"
        if (is_command or scope["type"] == "websocket") and _foreign(headers):
            return 403, "origin: this page belongs to another site"
        scope[RANK] = rank = self._rank(scope, headers)
        path = scope["path"]
        if not path.startswith(GUARDED) or path in OPEN:
            return None
        wanted: Rank = "command" if is_command and path != TICKETS else "read"
        if self._access.may(rank, wanted):
            return None
        return 401, f"token: needed to {wanted}; send the header Authorization: Bearer TOKEN"

    def _rank(self, scope: Scope, headers: Headers) -> Rank | None:
        rank = self._access.rank(headers.get("authorization", ""))
        if rank is None and scope["type"] == "websocket":
            tickets = parse_qs(scope["query_string"].decode("latin-1")).get("ticket", [])
            rank = self._access.redeem(tickets[0], self._clock) if len(tickets) == 1 else None
        return rank


async def _refuse(scope: Scope, receive: Receive, send: Send, refusal: Refusal) -> None:
    status, reason = refusal
    headers = {"WWW-Authenticate": "Bearer"} if status == 401 else None
    answer = JSONResponse({"detail": [reason]}, status, headers)
    if scope["type"] == "websocket" and "websocket.http.response" not in scope.get("extensions", {}):
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": reason[:120]})  # before accept: HTTP 403
    else:
        await answer(scope, receive, send)


def _in_time(receive: Receive) -> Receive:
    """A body whose next piece does not come in BODY_SECONDS counts as one whose sender has gone."""
    more = True

    async def receiving() -> Message:
        nonlocal more
        if not more:
            return await receive()
        try:
            message = await asyncio.wait_for(receive(), BODY_SECONDS)
        except TimeoutError:
            return {"type": "http.disconnect"}
        more = bool(message.get("more_body", False))
        return message

    return receiving


def _adding_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(SECURITY_HEADERS)
        await send(message)

    return sending


def _foreign(headers: Headers) -> bool:
    origin = headers.get("origin")
    return origin is not None and urlsplit(origin).netloc.lower() != headers.get("host", "").lower()

"""The checks before the application: host name, origin, token, and the time that a body may take."""

import asyncio
from collections.abc import Callable
from urllib.parse import parse_qs, urlsplit

from fastapi.responses import JSONResponse
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from radar_service.ports.roles import SAFE_METHODS, Roles
from radar_service.service.access import Access, Role, Tickets

SECURITY_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; base-uri 'self'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
}
BODY_SECONDS = 20.0  # between two pieces of a body
ROLE = "radar.role"  # key of the ASGI scope that holds the client's role

Refusal = tuple[int, str]


class SecurityMiddleware:
    """Refuses what is not allowed before anything is read, and adds the security headers that an answer has not itself.

    A browser sends the origin of its page; programs send none and pass. Requests that change nothing pass from any origin:
    this server never sends CORS headers, so a foreign page cannot read the answers.
    """

    def __init__(
        self, app: ASGIApp, access: Access, tickets: Tickets, roles: Roles, refused: Callable[[str], None] = lambda _: None
    ) -> None:
        """roles: of the routes; refused: is called with a word that names the reason of each refusal."""
        self._app, self._access, self._tickets, self._roles, self._refused = app, access, tickets, roles, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        send_with_headers = _adding_headers(send) if scope["type"] == "http" else send
        refusal = self._refusal(scope)
        if refusal:
            self._refused(refusal[1].partition(":")[0])
            return await _refuse(scope, receive, send_with_headers, refusal)
        await self._app(scope, _limited(receive) if scope["type"] == "http" else receive, send_with_headers)

    def _refusal(self, scope: Scope) -> Refusal | None:
        """Returns status and reason where the request is refused; puts the client's role into the scope."""
        headers, is_websocket = Headers(scope=scope), scope["type"] == "websocket"
        is_command = not is_websocket and scope["method"] not in SAFE_METHODS
        if not self._access.answers_to(headers.get("host", "")):
            return 421, "host: this server does not have that name; start it with --allow-host NAME, or use its address"
        if (is_command or is_websocket) and _is_foreign(headers):
            return 403, "origin: this page belongs to another site"
        scope[ROLE] = role = self._role(scope, headers)
        needed = self._roles.needed(scope)
        if needed == "nothing" or self._access.may(role, needed):
            return None
        return 401, f"token: needed to {needed}; send the header Authorization: Bearer TOKEN"

    def _role(self, scope: Scope, headers: Headers) -> Role | None:
        role = self._access.role(headers.get("authorization", ""))
        if role is None and scope["type"] == "websocket":
            tickets = parse_qs(scope["query_string"].decode("latin-1")).get("ticket", [])
            role = self._tickets.redeem(tickets[0]) if len(tickets) == 1 else None
        return role


async def _refuse(scope: Scope, receive: Receive, send: Send, refusal: Refusal) -> None:
    status, reason = refusal
    headers = {"WWW-Authenticate": "Bearer"} if status == 401 else None
    answer = JSONResponse({"detail": [reason]}, status, headers)
    if scope["type"] == "websocket" and "websocket.http.response" not in scope.get("extensions", {}):
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": reason[:120]})  # before accept: HTTP 403
    else:
        await answer(scope, receive, send)


def _limited(receive: Receive) -> Receive:
    """Returns a receiver that reports a disconnect where the next piece of the body does not come in BODY_SECONDS."""
    more = True

    async def receive_in_time() -> Message:
        nonlocal more
        if not more:
            return await receive()
        try:
            message = await asyncio.wait_for(receive(), BODY_SECONDS)
        except TimeoutError:
            return {"type": "http.disconnect"}
        more = bool(message.get("more_body", False))
        return message

    return receive_in_time


def _adding_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


def _is_foreign(headers: Headers) -> bool:
    origin = headers.get("origin")
    return origin is not None and urlsplit(origin).netloc.lower() != headers.get("host", "").lower()

"""Which role a route needs: each endpoint declares its own, and an application with an endpoint that does not is not started."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Literal, NamedTuple, TypeVar

import fastapi.routing
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute, compile_path
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from radar_service.service.access import Role

Needed = Role | Literal["nothing"]
Endpoint = TypeVar("Endpoint")

SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
WEBSOCKET = "WEBSOCKET"  # in place of a method
_DECLARED = "needed_role"  # attribute of an endpoint


class UndeclaredRoleError(ValueError):
    """A route that does not say which role it needs. The text names it."""


def needs(role: Needed) -> Callable[[Endpoint], Endpoint]:
    """Declares which role an endpoint needs: "command" to change something, "read" to see it, or "nothing".

    A decorator of the endpoint itself, below that of its route. What is mounted declares its own, which also holds for those of
    its routes that declare none.
    """

    def declare(endpoint: Endpoint) -> Endpoint:
        setattr(endpoint, _DECLARED, role)
        return endpoint

    return declare


class _Address(NamedTuple):
    """Where an endpoint is. methods: WEBSOCKET among them; None for all."""

    path: str
    pattern: re.Pattern[str]
    methods: frozenset[str] | None
    role: Needed


class Roles:
    """The roles that the routes of an application need. Where no route answers, changing needs "command" and all else "read".

    A folder at "/" takes all that no other route answers, but for addresses that begin like one that needs a role.
    """

    def __init__(self, routes: Sequence[BaseRoute]) -> None:
        """Raises UndeclaredRoleError."""
        self._addresses = list(_addresses(routes))
        self._guarded = {_first_part(address.path) for address in self._addresses if address.role != "nothing"}

    def needed(self, scope: Scope) -> Needed:
        """Returns what a request (an ASGI scope of a method, or of a websocket) needs."""
        path, method = scope["path"], WEBSOCKET if scope["type"] == "websocket" else scope["method"]
        for address in self._addresses:
            takes_method = address.methods is None or method in address.methods
            if takes_method and address.pattern.match(path) and not self._is_of_another(address, path):
                return address.role
        return "read" if method in (*SAFE_METHODS, WEBSOCKET) else "command"

    def _is_of_another(self, address: _Address, path: str) -> bool:
        return not address.path and _first_part(path) in self._guarded


def _addresses(routes: Iterable[Any], prefix: str = "", inherited: Needed | None = None) -> Iterator[_Address]:
    """The addresses of routes, in the order in which they answer. prefix, inherited: path and role of what holds them."""
    for route in _flat(routes):
        kind = getattr(route, "original_route", route)
        path = prefix + str(getattr(route, "path", route))
        endpoint = kind.app if isinstance(kind, Mount) else getattr(route, "endpoint", None)
        role = getattr(endpoint, _DECLARED, inherited)
        if role is None or not isinstance(kind, Route | WebSocketRoute | Mount):
            raise UndeclaredRoleError(
                f'{path}: this route does not declare the role that it needs; put @needs("read"), @needs("command") or '
                '@needs("nothing") above its function'
            )
        if isinstance(kind, Mount):
            yield from _addresses(kind.routes or (), path, role)
            methods = frozenset(SAFE_METHODS) if isinstance(kind.app, StaticFiles) else None
            yield _Address(path, compile_path(f"{path}/{{path:path}}")[0], methods, role)
        else:
            given = {WEBSOCKET} if isinstance(kind, WebSocketRoute) else getattr(route, "methods", None)
            yield _Address(path, compile_path(path)[0], None if given is None else frozenset(given), role)


def _flat(routes: Iterable[Any]) -> Iterable[Any]:
    """The routes of an application, those of its routers too, which newer frameworks keep apart."""
    iterate = getattr(fastapi.routing, "iter_route_contexts", None)
    return routes if iterate is None else iterate(list(routes))


def _first_part(path: str) -> str:
    return path.split("/")[1] if path.count("/") else path

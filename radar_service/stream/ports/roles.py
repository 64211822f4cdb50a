"""Which role a route needs: each endpoint declares its own, and an application with an endpoint that does not is not started."""

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal, NamedTuple, TypeVar

import fastapi.routing
from starlette.routing import BaseRoute, Mount, compile_path
from starlette.types import Scope

from radar_service.stream.access import Role

Needed = Role | Literal["nothing"]
Endpoint = TypeVar("Endpoint")

SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
WEBSOCKET = "WEBSOCKET"  # in place of a method
_DECLARED = "needed_role"  # attribute of an endpoint


class UndeclaredRoleError(ValueError):
    """A route that does not say which role it needs. The text names it."""


def needs(role: Needed) -> Callable[[Endpoint], Endpoint]:
    """Declares which role an endpoint needs: "command" to change something, "read" to see it, or "nothing".

    A decorator of the endpoint itself, below that of its route.
    """

    def declare(endpoint: Endpoint) -> Endpoint:
        setattr(endpoint, _DECLARED, role)
        return endpoint

    return declare


class _Address(NamedTuple):
    """Where an endpoint is. methods: WEBSOCKET among them."""

    path: str
    pattern: re.Pattern[str]
    methods: frozenset[str]
    role: Needed


class Roles:
    """The roles that the routes of an application need. Where no route answers, changing needs "command" and all else "read".

    A folder at "/" takes all that no other route answers, but for addresses that begin like one that needs a role.
    """

    def __init__(self, routes: Sequence[BaseRoute]) -> None:
        """Raises UndeclaredRoleError."""
        self._addresses = [_address(route) for route in _flat(routes)]
        self._guarded = {_first_part(address.path) for address in self._addresses if address.role != "nothing"}

    def needed(self, scope: Scope) -> Needed:
        """Returns what a request (an ASGI scope of a method, or of a websocket) needs."""
        path, method = scope["path"], WEBSOCKET if scope["type"] == "websocket" else scope["method"]
        for address in self._addresses:
            if method in address.methods and address.pattern.match(path) and not self._is_of_another(address, path):
                return address.role
        return "read" if method in (*SAFE_METHODS, WEBSOCKET) else "command"

    def _is_of_another(self, address: _Address, path: str) -> bool:
        return not address.path and _first_part(path) in self._guarded


def _flat(routes: Sequence[BaseRoute]) -> Iterable[Any]:
    """The routes of an application, those of its routers too, which newer frameworks keep apart."""
    iterate = getattr(fastapi.routing, "iter_route_contexts", None)
    return (
        routes
        if iterate is None
        else [route.route if isinstance(route.route, Mount) else route for route in iterate(routes)]
    )


def _address(route: Any) -> _Address:
    is_folder = isinstance(route, Mount)
    role = getattr(route.app if is_folder else route.endpoint, _DECLARED, None)
    if role is None:
        raise UndeclaredRoleError(
            f'{route.path}: this route does not declare the role that it needs; put @needs("read"), @needs("command") or '
            '@needs("nothing") above its function'
        )
    methods = SAFE_METHODS if is_folder else getattr(route, "methods", None) or (WEBSOCKET,)
    pattern = compile_path(f"{route.path}/{{path:path}}" if is_folder else route.path)[0]
    return _Address(route.path, pattern, frozenset(methods), role)


def _first_part(path: str) -> str:
    return path.split("/")[1] if path.count("/") else path

"""Each route says which role it needs, and one that does not stops the start."""

from typing import Any

import pytest
from fastapi import APIRouter, FastAPI
from starlette.applications import Starlette
from starlette.endpoints import HTTPEndpoint
from starlette.routing import Host, Route
from starlette.staticfiles import StaticFiles

from radar_service.ports.app import create_app
from radar_service.ports.roles import Roles, UndeclaredRoleError, needs
from tests.ports.playing import station


def endpoint() -> Any:
    """An endpoint that does nothing, and declares nothing yet."""

    async def answer() -> None:
        """Does nothing."""

    return answer


def app() -> FastAPI:
    made = FastAPI(openapi_url=None)

    def answering(path: str, role: Any, method: str) -> None:
        async def answer() -> None:
            """Does nothing."""

        made.add_api_route(path, needs(role)(answer), methods=[method])

    answering("/radar/seen", "read", "GET")
    answering("/radar/seen", "command", "PUT")
    answering("/radar/asked", "read", "POST")
    answering("/radar/open", "nothing", "GET")
    answering("/open", "nothing", "GET")

    async def listen() -> None:
        """Does nothing."""

    async def steer() -> None:
        """Does nothing."""

    made.add_api_websocket_route("/radar/listen", needs("read")(listen))
    made.add_api_websocket_route("/radar/{radar}/steer", needs("command")(steer))
    made.mount("/", needs("nothing")(StaticFiles(directory=".")))
    return made


def test_what_a_request_needs() -> None:
    made = app()
    for kind, path, needed in (
        ("GET", "/radar/seen", "read"), ("HEAD", "/radar/seen", "read"), ("PUT", "/radar/seen", "command"),
        ("DELETE", "/radar/seen", "command"), ("POST", "/radar/asked", "read"), ("GET", "/radar/open", "nothing"),
        ("PUT", "/radar/open", "command"), ("PUT", "/page.js", "command"), ("GET", "/radar/none", "read"),
        ("POST", "/radar/none", "command"), ("GET", "/open", "nothing"), ("GET", "/", "nothing"),
        ("GET", "/page.js", "nothing"), ("websocket", "/radar/listen", "read"), ("websocket", "/radar/0/steer", "command"),
        ("websocket", "/page.js", "read"), ("websocket", "/open", "read"),
    ):  # fmt: skip
        assert role_of(made, path, kind) == needed, (kind, path)


def test_a_route_without_a_role_stops_the_start() -> None:
    made = app()
    made.add_api_route("/forgotten/{name}", endpoint())
    with pytest.raises(UndeclaredRoleError, match=r"^/forgotten/\{name\}: this route does not declare the role"):
        Roles(made.routes)
    bare = Starlette()
    bare.mount("/files", StaticFiles(directory="."))
    with pytest.raises(UndeclaredRoleError, match="^/files: "):
        Roles(bare.routes)


def test_every_route_of_the_service_declares_its_role() -> None:
    assert Roles(create_app([station()]).routes)


def role_of(made: Any, path: str, kind: str = "GET") -> str:
    scope = {"type": "websocket" if kind == "websocket" else "http", "method": kind, "path": path, "root_path": ""}
    return Roles(made.routes).needed(scope)


def test_what_is_mounted_in_a_router_with_a_prefix_keeps_its_role() -> None:
    inner, outer, made = APIRouter(), APIRouter(prefix="/x"), FastAPI(openapi_url=None)
    inner.mount("/m", needs("command")(Starlette()))
    outer.include_router(inner, prefix="/y")
    made.include_router(outer)
    made.mount("/", needs("nothing")(StaticFiles(directory=".")))
    for kind in ("GET", "POST", "websocket"):
        assert role_of(made, "/x/y/m/a", kind) == "command"


def test_routes_within_what_is_mounted_have_the_role_of_their_own_or_of_the_mount() -> None:
    inner = Starlette(routes=[Route("/own", needs("command")(endpoint())), Route("/none", endpoint())])
    made = FastAPI(openapi_url=None)
    made.mount("/m", needs("nothing")(inner))
    assert role_of(made, "/m/own") == "command" and role_of(made, "/m/none") == "nothing"


def test_an_endpoint_that_is_a_class_takes_every_method() -> None:
    class Answering(HTTPEndpoint):
        """Does nothing."""

    made = Starlette(routes=[Route("/class", needs("command")(Answering))])
    assert [role_of(made, "/class", kind) for kind in ("GET", "HEAD", "DELETE")] == ["command"] * 3


def test_a_route_of_an_unknown_kind_stops_the_start() -> None:
    with pytest.raises(UndeclaredRoleError, match="does not declare"):
        Roles([Host("elsewhere", Starlette())])

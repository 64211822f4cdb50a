"""Each route says which role it needs, and one that does not stops the start."""

from typing import Any

import pytest
from fastapi import FastAPI
from starlette.applications import Starlette
from starlette.staticfiles import StaticFiles

from radar_service.stream.http.app import create_app
from radar_service.stream.ports.roles import Roles, UndeclaredRoleError, needs
from tests.stream.http.playing import station


async def endpoint() -> None:
    """Does nothing."""


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


@pytest.mark.parametrize(
    ("kind", "path", "needed"),
    [
        ("GET", "/radar/seen", "read"), ("HEAD", "/radar/seen", "read"), ("PUT", "/radar/seen", "command"),
        ("DELETE", "/radar/seen", "command"), ("POST", "/radar/asked", "read"), ("GET", "/radar/open", "nothing"),
        ("PUT", "/radar/open", "command"), ("PUT", "/page.js", "command"), ("GET", "/radar/none", "read"),
        ("POST", "/radar/none", "command"), ("GET", "/open", "nothing"), ("GET", "/", "nothing"),
        ("GET", "/page.js", "nothing"), ("websocket", "/radar/listen", "read"), ("websocket", "/radar/0/steer", "command"),
        ("websocket", "/page.js", "read"), ("websocket", "/open", "read"),
    ],
)  # fmt: skip
def test_what_a_request_needs(kind: str, path: str, needed: str) -> None:
    scope = {"type": "websocket" if kind == "websocket" else "http", "method": kind, "path": path, "root_path": ""}
    assert Roles(app().routes).needed(scope) == needed


def test_a_route_without_a_role_stops_the_start() -> None:
    made = app()
    made.add_api_route("/forgotten/{name}", endpoint)
    with pytest.raises(UndeclaredRoleError, match=r"^/forgotten/\{name\}: this route does not declare the role"):
        Roles(made.routes)
    bare = Starlette()
    bare.mount("/files", StaticFiles(directory="."))
    with pytest.raises(UndeclaredRoleError, match="^/files: "):
        Roles(bare.routes)


def test_every_route_of_the_service_declares_its_role() -> None:
    assert Roles(create_app([station()]).routes)

"""The short modules of ports, each under its name."""

import asyncio
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fastapi import APIRouter, FastAPI
from starlette.applications import Starlette
from starlette.endpoints import HTTPEndpoint
from starlette.responses import JSONResponse, Response
from starlette.routing import Host, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from radar_service import plug_ins
from radar_service.commands.command_line import parser
from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.ports.recorder.recorder_port import RecorderPort
from radar_service.ports.refusal_shapes import RefusalShapesMiddleware
from radar_service.ports.registry import opened
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.roles import Roles, UndeclaredRoleError, needs
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.settings import Settings
from radar_service.terminal.arguments import UsageError
from tests.ports.asgi import running
from tests.ports.nmea.test_senders import free_port
from tests.ports.playing import playing, station


# app: the whole application: the page.
async def test_the_page_is_served() -> None:
    async with playing() as server:
        answer = await server.http.get("/")
        assert answer.status_code == 200 and "text/html" in answer.headers["content-type"]
        assert (await server.http.get("/../pyproject.toml")).status_code == 404


# port: a port overrides what it has: one that overrides nothing has nothing, and a service runs with it.
class Bare(Port):
    name = "bare"


async def test_a_port_that_overrides_nothing_does_nothing() -> None:
    host = PortHost((FeedPort(), bare := Bare()))
    assert host.sources == SourceRequest() and host.sinks("0") == []
    async with running(create_app([station(settings=Settings(), wait_for=1)], host)) as server:
        assert (await (await server.feed()).spokes(5))[0]["first"] == 0
        assert (await server.http.get("/api/radars")).status_code == 404  # where REST does not take part
    bare.close()
    thread = host.threads[bare]
    assert (thread.name, thread.faults, thread.dropped) == ("bare", 0, 0)


# refusal_shapes: refusals in the shape of a protocol: below its paths alone, and only what has no shape of its own.
def answer(app: ASGIApp, path: str) -> tuple[int, bytes]:
    """Status and body of an answer, whose length must be that of its head."""
    sent: list[Any] = []

    async def whole() -> None:
        async def send(message: Any) -> None:
            sent.append(message)

        shaped = RefusalShapesMiddleware(
            app, {"/other": lambda status, reason: (status + 1, {"code": status, "why": reason})}
        )
        await shaped({"type": "http", "path": path}, None, send)  # type: ignore[arg-type]

    asyncio.run(whole())
    body = b"".join(message.get("body", b"") for message in sent[1:])
    assert int(dict(sent[0]["headers"])[b"content-length"]) == len(body)
    return sent[0]["status"], body


@pytest.mark.parametrize(("detail", "reason"), [(["a", "b"], "a; b"), ("Not Found", "Not Found"), ([], "")])
def test_a_refusal_is_written_anew(detail: Any, reason: str) -> None:
    status, body = answer(JSONResponse({"detail": detail}, 404), "/other/x")
    assert status == 405 and json.loads(body) == {"code": 404, "why": reason}


@pytest.mark.parametrize("path", ["/otherwise", "/", "/api/other"])
def test_other_paths_keep_theirs(path: str) -> None:
    assert json.loads(answer(JSONResponse({"detail": ["a"]}, 404), path)[1]) == {"detail": ["a"]}


@pytest.mark.parametrize(
    "response", [JSONResponse({"detail": ["a"]}, 200), JSONResponse({"state": "FAILED"}, 400), Response(b"text", 500)]
)
def test_what_is_no_refusal_or_has_a_shape_is_not_changed(response: Response) -> None:
    assert answer(response, "/other") == (response.status_code, response.body)


# roles: each route says which role it needs, and one that does not stops the start.
def endpoint() -> Any:
    async def answer() -> None:
        """Does nothing."""

    return answer


def routed() -> FastAPI:
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
    made = routed()
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
    made = routed()
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


# registry: the ports that the options of `serve` ask for.
def names(*arguments: str) -> list[str]:
    with opened(parser().parse_args(["serve", *arguments])) as ports:
        return [port.name for port in ports]


def test_a_port_is_there_where_an_option_asks_for_it(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    assert names() == ["feed", "rest"] and not path.exists()
    assert names("--record", str(path)) == ["feed", "recorder", "rest"] and path.exists()
    with pytest.raises(FileExistsError):
        names("--record", str(path))
    with opened(parser().parse_args(["replay", str(path)])) as ports:
        assert [port.name for port in ports] == ["feed", "rest"]


def test_options_reach_their_ports(tmp_path: Path) -> None:
    record = ["--record", str(tmp_path / "a.mcap"), "--labels", "--powers", "1,257"]
    options = parser().parse_args(["serve", "--sandbox-all", "--scene-folder", str(tmp_path), *record])
    (tmp_path / "mine.toml").write_text('name = "mine"\n')
    with opened(options) as (_, recorder, rest):
        assert isinstance(rest, RestPort) and isinstance(recorder, RecorderPort)
        assert rest.store.scene_request("mine").sandboxed
        assert recorder.sources.labels and recorder.sources.powers == (1, 257)


def test_what_goes_with_a_recording_needs_one() -> None:
    for option in (["--labels"], ["--powers", "all"]):
        with pytest.raises(UsageError, match=rf"^{option[0]}: goes with --record FILE\.mcap"):
            names(*option)


def test_a_port_that_cannot_open_closes_those_before_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed = []
    monkeypatch.setattr(FeedPort, "close", lambda self: closed.append(self.name))
    with pytest.raises(FileNotFoundError):
        names("--record", "/proc/none/a.mcap")
    assert closed == ["feed"]


def test_sockets_are_open_while_their_ports_are() -> None:
    given = {f"--{name}": str(free_port()) for name in ("nmea-tcp", "ais-tcp", "nmea-in-tcp", "nmea-in-udp")}
    words, free = [word for option in given.items() for word in option], str(free_port())
    with opened(parser().parse_args(["serve", *words, "--nmea-udp", "9", "--ais-udp", "9"])) as ports:
        assert [port.name for port in ports] == ["ais", "feed", "nmea", "nmea-in", "rest"]
        for option, port in given.items():
            with pytest.raises(UsageError, match=f"{option}: 127.0.0.1:{port} cannot be opened"):
                names("--nmea-tcp", free, option, port)
    assert len(names(*words)) == len(names("--nmea-tcp", free)) + 2 == 5  # all were closed


@pytest.mark.parametrize(
    "option", [*(f"{name}-{by}" for name in ("nmea", "ais", "nmea-in") for by in ("tcp", "udp")), "asterix", "asterix-plots"]
)
def test_beyond_this_machine_no_option_opens_a_port_alone(option: str) -> None:
    others_come = "-in-" in option or option.endswith("tcp")
    allow = "--asterix-allow" if option.startswith("asterix") else "--nmea-allow"
    needs = f"--{option}: .* beyond this machine, and nothing asks for a login.*{allow}"
    where = f"{'0.0.0.0' if others_come else '10.0.0.2'}:{free_port()}"
    for token in ([], ["--token-file", "t"]):
        with pytest.raises(UsageError, match=needs):
            names(f"--{option}", where, *token)
    for also in (["--nmea-allow", "10.0.0.2"], ["--insecure"]) if others_come else ():
        assert len(names(f"--{option}", where, *also)) == 3


def test_options_of_ports_cost_no_command_the_import_of_a_server() -> None:
    code = "import sys; from radar_service.commands.command_line import parser; parser('serve'); print(*sys.modules)"
    imported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    packages = {plug_ins.entry("ports", name).module for name in plug_ins.names("ports")}
    assert packages <= set(imported) and not {"numpy", "fastapi", "uvicorn", "mcap", "trimesh"} & set(imported)

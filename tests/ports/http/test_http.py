"""The short modules of HTTP, each under its name."""

import ast
import asyncio
import contextlib
import inspect
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import httpx
import pytest
import uvicorn
from websockets.protocol import State
from websockets.server import ServerProtocol

from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.http.conversation import close_reason, until_first_ends
from radar_service.ports.http.server import LimitedProtocol, Requests, Server
from radar_service.ports.http.websocket import OPEN, FramedWebSocket
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.signalk.signalk_port import SignalKPort
from radar_service.processes.call import Progress
from radar_service.service.access import Access
from radar_service.service.scene_request import SceneRequest
from tests.clients.chromium import CHROMIUM, Browser
from tests.ports.asgi import Closed, running
from tests.ports.playing import playing, station
from tests.ports.rest.test_rest_port import Slow
from tests.ports.serving import served
from tests.service.fake import FakeEngine


# docs: the documentation page: whole, from this server alone, and within its content security policy.
async def test_every_file_of_the_page_comes_from_this_server_and_no_other_file_does() -> None:
    """The policy has no 'unsafe-inline': a browser would not run inline scripts and styles."""
    async with playing() as server:
        page = await server.http.get("/docs")
        assert page.status_code == 200 and page.headers["content-security-policy"].startswith("default-src 'self'")
        links = re.findall(r'(?:src|href)="([^"]+)"', page.text)
        assert len(links) == 4
        for link in links:
            assert not re.match(r"[a-z]+:|//", link)
            answer = await server.http.get(f"/{link}")
            assert answer.status_code == 200 and answer.content, link
        assert "SwaggerUIBundle" in (await server.http.get("/docs/files/swagger-ui-bundle.js")).text
        assert (await server.http.get("/docs/start.js")).headers["content-type"].startswith("text/javascript")
        assert "<style" not in page.text and " style=" not in page.text
        assert re.findall(r"<script[^>]*>([^<]*)</script>", page.text) == ["", ""]
        for path in ("../../pyproject.toml", "%2e%2e/core.py", "nothing"):
            assert (await server.http.get(f"/docs/files/{path}")).status_code == 404
        paths = (await server.http.get("/api/openapi.json")).json()["paths"]
        assert all(path.startswith("/api/") for path in paths)  # the page is no part of the interface that it shows


@pytest.mark.browser
@pytest.mark.skipif(not CHROMIUM.exists(), reason="needs Chromium")
def test_a_browser_shows_every_operation_without_breaking_the_policy(tmp_path: Path) -> None:
    """The page asks for the token once, and keeps it for the tab as the radar's page does."""
    browser, token = Browser(tmp_path), "reading-" * 3
    app = create_app([only := station()], access=Access("command-" * 3, token))
    with contextlib.closing(browser), served(app, [only]) as (host, port):
        page = browser.open(f"http://{host}:{port}/docs", first=f'window.prompt = () => "{token}";')
        page.wait("document.querySelectorAll('.opblock').length === 24")
        text = page.ask("document.body.innerText")
        assert "/api/radars/{radar}/controls" in text and "Change Controls" in text
        assert [fault for fault in page.faults() if "401" not in fault] == []


# conversation: conversations by websocket: their parts end together, and reasons fit a close frame.
async def test_the_first_part_that_ends_ends_the_others() -> None:
    ended = []

    async def part(name: str, event: asyncio.Event) -> None:
        try:
            await event.wait()
        finally:
            ended.append(name)

    first, never = asyncio.Event(), asyncio.Event()
    first.set()
    await asyncio.wait_for(until_first_ends(part("reads", never), part("writes", first)), 10)
    assert ended == ["writes", "reads"]


def test_a_reason_fits_a_close_frame_whatever_its_letters() -> None:
    """A control frame holds 125 bytes, two of them the close code (RFC 6455, section 5.5)."""
    assert close_reason("range: 5 m") == "range: 5 m"
    for letter in ("x", "é", "日", "🚢"):
        reason = close_reason(letter * 200)
        assert 116 < len(reason.encode()) <= 123 and set(reason) == {letter}


@pytest.mark.parametrize("path", ["poses", "truth/stream?radiometric=2"])
async def test_an_unknown_radar_is_refused_with_a_reason_and_counted(path: str) -> None:
    async with playing() as server:
        socket = await server.open(f"/api/radars/{'7' * 50}/{path}")
        bye = json.loads(await socket.text())
        assert bye == {"type": "bye", "reason": f'radar: there is no "{"7" * 40}"; see /api/radars'}
        with pytest.raises(Closed) as closed:
            await socket.text()
        assert closed.value.code == 4404
        assert 'reason="feed radar"} 1' in (await server.http.get("/metrics")).text


async def test_other_refusals_have_codes_of_their_own() -> None:
    async with playing() as server:
        socket = await server.open("/api/radars/0/truth/stream")
        assert "start it with --truth" in json.loads(await socket.text())["reason"]
        with pytest.raises(Closed) as closed:
            await socket.text()
        assert closed.value.code == 4403


@pytest.mark.parametrize(
    ("path", "most"),
    [
        ("/api/radars/0/truth/stream", "service.radio.truth_stream.MAX_FOLLOWERS"),
        ("/api/changes", "ports.rest.websockets.MAX_CLIENTS"), ("/signalk/v1/stream", "ports.signalk.stream.MAX_CLIENTS"),
    ],
)  # fmt: skip
async def test_too_many_clients_are_refused_until_one_leaves(path: str, most: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f"radar_service.{most}", 1)
    host = PortHost((RestPort(), FeedPort(), SignalKPort(None, False)))
    async with playing(station(allow_truth=True, sinks=host.sinks("0")), ports=host) as server:
        first = await server.open(path)
        await first.text()
        second = await server.open(path)
        assert "its 1 clients" in json.loads(await second.text())["reason"]
        with pytest.raises(Closed) as closed:
            await second.text()
        assert closed.value.code == 4503
        await first.leave()
        assert "reason" not in json.loads(await (await server.open(path)).text())


# server: requests that are in progress when the server stops: each gets an answer.
@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("PUT", "/api/radars/0/scene", {"scene": {"name": "x"}}),
        ("POST", "/api/scenes", {"name": "x", "scene": {"name": "x"}}),
        ("PATCH", "/api/radars/0/controls", {"rpm": 48}),
    ],
)
def test_a_request_that_waits_for_a_job_is_told_that_it_was_cancelled(method: str, path: str, body: Any) -> None:
    slow, requests = Slow(), Requests()

    async def test() -> httpx.Response:
        async with running(create_app([station(make=slow)], requests=requests)) as server:
            request = asyncio.create_task(server.http.request(method, path, json=body))
            await slow.begun()
            await requests.end()
            return await request

    answer = asyncio.run(asyncio.wait_for(test(), 60))
    assert (answer.status_code, answer.json()["detail"][0].split(": ")[1]) == (409, "the job was cancelled")


def test_a_request_that_nothing_ends_is_told_that_the_server_stops(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its body does not come any more."""
    monkeypatch.setattr("radar_service.ports.http.server.ANSWER_SECONDS", 0.01)
    requests, begun = Requests(), asyncio.Event()

    async def body() -> Any:
        yield b'{"name"'
        begun.set()
        await asyncio.Event().wait()

    async def test() -> httpx.Response:
        async with running(create_app([station()], requests=requests)) as server:
            json = {"content-type": "application/json"}
            request = asyncio.create_task(server.http.post("/api/scenes", content=body(), headers=json))
            await begun.wait()
            await requests.end()
            return await request

    answer = asyncio.run(asyncio.wait_for(test(), 60))
    assert answer.status_code == 503 and answer.json()["detail"] == ["the server is stopping; try again when it runs"]


def test_an_answer_that_has_begun_is_not_begun_again() -> None:
    requests, sent = Requests(), list[str]()

    async def receive() -> Any:
        raise AssertionError

    async def send(message: Any) -> None:
        sent.append(message["type"])

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "http.response.start", "status": 200})
        await requests.end()
        await asyncio.sleep(0)
        await send({"type": "http.response.body"})

    asyncio.run(asyncio.wait_for(requests.follow(app, {"type": "http"}, receive, send), 60))
    assert sent == ["http.response.start", "http.response.body"]


def refuse(order: SceneRequest, progress: Progress) -> FakeEngine:
    raise TimeoutError("of the scene")


async def test_a_timeout_of_the_application_is_its_own() -> None:
    async with running(create_app([station(make=refuse)])) as server:
        with pytest.raises(TimeoutError, match="of the scene"):
            await server.http.put("/api/radars/0/scene", json={"scene": {"name": "x"}})


# uvicorn: uvicorn promises none of its internals: what the service uses of its classes is there, and the version is bounded.
PYPROJECT = Path(__file__).parents[3] / "pyproject.toml"


def of_self(kind: type, *contexts: type[ast.expr_context]) -> set[str]:
    """Attributes of `self` that the source of one class loads or stores."""
    tree = ast.parse(inspect.getsource(kind))
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self"
        and isinstance(node.ctx, contexts)
    }  # fmt: skip


def names(kind: type) -> set[str]:
    """Attributes that a class itself gives its instances."""
    return of_self(kind, ast.Store) | set(vars(kind))


def overridden(kind: type) -> set[str]:
    """Methods of its parent that the class calls by `super()`."""
    tree = ast.parse(inspect.getsource(kind))
    return {
        node.attr for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "super()" and node.attr != "__init__"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "some"),
    [
        (
            FramedWebSocket,
            {"writable", "disconnected", "close_sent", "conn", "transport", "scope", "run_asgi", "handle_events"},
        ),
        (
            LimitedProtocol,
            {"connections", "client", "conn", "flow", "loop", "transport", "connection_made", "data_received"},
        ),
        (Server, {"servers", "should_exit", "startup", "shutdown"}),
    ],
)
def test_uvicorn_has_what_is_used_of_it(kind: type, some: set[str]) -> None:
    parent = kind.__mro__[1]
    assert parent.__module__.startswith("uvicorn.")
    used = (of_self(kind, ast.Load, ast.Store) - names(kind)) | (of_self(kind, ast.Store) & names(parent)) | overridden(kind)
    assert some <= used, "the test no longer sees what the service uses"
    assert used <= names(parent), f"uvicorn {uvicorn.__version__} has no {parent.__name__}.{used - names(parent)}"


def test_a_connection_that_is_open_has_the_state_that_frames_are_written_in() -> None:
    assert State.OPEN.value == OPEN


def test_a_protocol_keeps_its_frames_as_events_until_they_are_fetched() -> None:
    protocol = ServerProtocol(state=State.OPEN)
    protocol.receive_data(b"\x89\x80abcd\x89\x80abcd")
    assert len(protocol.events) == 2 == len(protocol.events_received()) and not protocol.events


def test_the_version_of_uvicorn_is_the_tested_one() -> None:
    (needed,) = (line for line in tomllib.loads(PYPROJECT.read_text())["project"]["dependencies"] if "uvicorn" in line)
    assert needed == "uvicorn>=0.54,<0.55" and uvicorn.__version__.startswith("0.54.")

"""The short modules of ports, each under its name."""

import asyncio
import json
from typing import Any

import pytest
from starlette.responses import JSONResponse, Response
from starlette.types import ASGIApp

from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.ports.refusal_shapes import RefusalShapesMiddleware
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.settings import Settings
from tests.ports.asgi import running
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

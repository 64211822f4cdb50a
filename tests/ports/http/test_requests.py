"""Requests that are in progress when the server stops: each gets an answer."""

import asyncio
from typing import Any

import httpx
import pytest

from radar_service.ports.app import create_app
from radar_service.ports.http.server import Requests
from radar_service.processes.call import Progress
from radar_service.service.scene_request import SceneRequest
from tests.ports.asgi import running
from tests.ports.playing import station
from tests.ports.rest.test_rest_port import Slow
from tests.service.fake import FakeEngine


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

"""The whole application: the page, its headers, its limits."""

import json

import pytest

from tests.ports.playing import playing


async def test_a_body_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.ports.rest.body_limits.MAX_JSON_BYTES", 1000)
    async with playing() as server:
        body = json.dumps({"name": "a", "scene": {"name": "x" * 2000}})
        answer = await server.http.post("/api/scenes", content=body, headers={"content-type": "application/json"})
        assert answer.status_code == 413


async def test_the_page_is_served() -> None:
    async with playing() as server:
        answer = await server.http.get("/")
        assert answer.status_code == 200 and "text/html" in answer.headers["content-type"]
        assert (await server.http.get("/../pyproject.toml")).status_code == 404

"""The store of scenes: bounded, and gone with the server."""

from pathlib import Path
from typing import Any

import pytest

from radar_service.stream.http import scene_store
from tests.stream.asgi import Server
from tests.stream.http.playing import play


def test_the_number_of_uploads_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_store, "MAX_UPLOADS", 1)

    async def test(server: Server) -> None:
        for name, status in (("a", 201), ("a", 201), ("b", 409)):
            assert (await server.http.post("/api/scenes", json={"name": name, "scene": {}})).status_code == status

    play(test)


def test_uploads_go_with_the_server() -> None:
    kept: list[Path] = []

    async def test(server: Server) -> None:
        await server.http.post("/api/scenes", json={"name": "mine", "scene": {}})

    make = scene_store.SceneStore.__init__

    def noting(store: Any, *arguments: Any) -> None:
        make(store, *arguments)
        kept.append(store.home)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene_store.SceneStore, "__init__", noting)
        play(test)
    assert kept and not kept[0].exists()

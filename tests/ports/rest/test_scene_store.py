"""The store of scenes: bounded, and gone with the server."""

import json
from pathlib import Path

import pytest

from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest import scene_store
from radar_service.ports.rest.rest_port import RestPort
from tests.ports.playing import playing
from tests.scenes import TWO_RADARS


async def test_the_number_of_uploads_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_store, "MAX_UPLOADS", 1)
    async with playing() as server:
        for name, status in (("a", 201), ("a", 201), ("b", 409)):
            assert (await server.http.post("/api/scenes", json={"name": name, "scene": {"name": "s"}})).status_code == status


async def test_uploads_go_with_the_server() -> None:
    async with playing(ports=PortHost((rest := RestPort(), FeedPort()))) as server:
        await server.http.post("/api/scenes", json={"name": "mine", "scene": {"name": "s"}})
    assert not rest.store.home.exists()


async def test_a_scene_of_several_radars_is_summed_up_by_its_first(tmp_path: Path) -> None:
    (tmp_path / "two.json").write_text(json.dumps(TWO_RADARS))
    async with playing(ports=PortHost((RestPort([tmp_path]), FeedPort()))) as server:
        await server.http.post("/api/scenes", json={"name": "mine", "scene": TWO_RADARS})
        listed = {scene["name"]: scene["summary"] for scene in (await server.http.get("/api/scenes")).json()}
        assert listed["two"] == "2 radars, the first: 2 bodies, 600 m, 60 rpm"
        assert listed["mine"] == "2 radars, the first: 1 bodies, 600 m, 60 rpm"  # of those that it sees
        assert listed["harbour"].count("radar") == 0

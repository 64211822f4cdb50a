"""REST as a port: alone it serves all but the feed."""

import asyncio
from pathlib import Path

import pytest

from radar_service.ports.app import create_app
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from tests.ports.asgi import Closed, running
from tests.ports.playing import station


def test_alone_it_serves_all_but_the_feed(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('name = "mine"\n')
    port = RestPort([tmp_path])
    home = port.store.home

    async def whole() -> None:
        async with running(create_app([station()], PortHost((port,)))) as server:
            assert home.is_dir()
            for path in ("/api/radars/0", "/api/health", "/metrics", "/docs"):
                assert (await server.http.get(path)).status_code == 200
            assert "mine" in {entry["name"] for entry in (await server.http.get("/api/scenes")).json()}
            assert '"kind"' in await (await server.open("/api/changes")).text()
            with pytest.raises((Closed, AssertionError)):
                await server.feed()

    asyncio.run(asyncio.wait_for(whole(), 60))
    assert not home.exists()

"""The native feed as a port: alone it serves spokes and nothing else."""

import asyncio

from radar_service.stream.http.app import create_app
from radar_service.stream.http.feed_port import FeedPort
from radar_service.stream.ports.port_host import PortHost
from radar_service.stream.settings import Settings
from tests.stream.asgi import running
from tests.stream.http.playing import station


def test_alone_it_serves_spokes_and_nothing_else() -> None:
    async def whole() -> None:
        host = PortHost((FeedPort(),))
        async with running(create_app([station(settings=Settings(), wait_for=1)], host)) as server:
            assert (await (await server.feed()).spokes(5))[0]["first"] == 0
            assert (await server.http.get("/api/radars")).status_code == 404

    asyncio.run(asyncio.wait_for(whole(), 30))

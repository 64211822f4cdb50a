"""A port overrides what it has: one that overrides nothing has nothing, and a service runs with it."""

from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.settings import Settings
from tests.ports.asgi import running
from tests.ports.playing import station


class Bare(Port):
    name = "bare"


async def test_a_port_that_overrides_nothing_does_nothing() -> None:
    host = PortHost((FeedPort(), bare := Bare()))
    assert host.sources == SourceRequest() and host.sinks("0") == []
    async with running(create_app([station(settings=Settings(), wait_for=1)], host)) as server:
        assert (await (await server.feed()).spokes(5))[0]["first"] == 0
    bare.close()
    thread = host.threads[bare]
    assert (thread.name, thread.faults, thread.dropped) == ("bare", 0, 0)

"""Services driven in process, with radars that compute nothing."""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from typing import Any

from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port import Port
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.service.access import Access
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from radar_service.world.scene import Scene
from tests.ports.asgi import Server, running
from tests.service.fake import FakeEngine, factory, scene, steerable_scene

PAUSED, FLAT_OUT = Settings(pace=Pace("pause")), Settings(pace=Pace("run", math.inf))


def station(of: Scene | FakeEngine | None = None, identity: str = "0", **options: Any) -> Station:
    """A radar, by default paused and of the test scene."""
    engine = of if isinstance(of, FakeEngine) else FakeEngine(of or scene())
    options = {"make": factory(), "settings": PAUSED} | options
    return Station(identity, engine, options.pop("make"), **options)


@contextlib.asynccontextmanager
async def playing(*stations: Station, **options: Any) -> AsyncIterator[Server]:
    """A service with these radars, or with a paused one; further options are those of the app."""
    stations = stations or (station(),)
    async with running(create_app(stations, **options)) as server:
        server.stations = list(stations)
        yield server


@contextlib.asynccontextmanager
async def joined(
    *ports: Port, scenes: Sequence[Scene] = (), access: Access | None = None, **options: Any
) -> AsyncIterator[tuple[Server, PortHost]]:
    """A service with ports beside REST and the feed, and the host of all; options are those of each radar."""
    host = PortHost((RestPort(), FeedPort(), *ports))
    radars = [station(of, str(k), sinks=host.sinks(str(k)), **options) for k, of in enumerate(scenes or (scene(),))]
    try:
        async with playing(*radars, ports=host, access=access) as server:
            yield server, host
    finally:
        for port in ports:
            port.close()


def play(
    ports: Port | Sequence[Port], test: Callable[[Server], Awaitable[None]], settings: Settings = PAUSED, **options: Any
) -> PortHost:
    """Plays a test with ports beside REST and the feed, on a radar that may be steered; returns the host of the ports."""

    async def whole() -> PortHost:
        given = [ports] if isinstance(ports, Port) else ports
        async with joined(*given, scenes=[steerable_scene()], settings=settings, **options) as (server, host):
            await test(server)
        return host

    return asyncio.run(asyncio.wait_for(whole(), 60))

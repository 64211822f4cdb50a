"""A service with the Signal K port, driven in process."""

import contextlib
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from radar_service.ports.app import create_app
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.signalk.signalk_port import SignalKPort
from radar_service.service.access import Access
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from radar_service.world.scene import Scene
from tests.ports.asgi import Server, Socket, running
from tests.service.fake import FakeEngine, factory, scene

BASE = "/signalk/v2/api/vessels/self/radars"
PAUSED = Settings(pace=Pace("pause"))
FLAT_OUT = Settings(pace=Pace("run", float("inf")))


@contextlib.asynccontextmanager
async def playing(
    *scenes: Scene, settings: Settings = PAUSED, access: Access | None = None,
    gui: Path | None = None, wait_for: int = 0, tells_truth: bool = False,
) -> AsyncIterator[Server]:  # fmt: skip
    """A service with radars of these scenes, by default of the test scene."""
    host = PortHost((RestPort(), FeedPort(), SignalKPort(gui, tells_truth)))
    stations = [
        Station(str(number), FakeEngine(of), factory(), settings=settings, sinks=host.sinks(str(number)), wait_for=wait_for)
        for number, of in enumerate(scenes or (scene(),))
    ]
    async with running(create_app(stations, host, access=access)) as server:
        server.stations = stations
        yield server


async def heard(socket: Socket) -> dict[str, Any]:
    """The next message of a stream."""
    message: dict[str, Any] = json.loads(await socket.text())
    return message


def values_of(delta: dict[str, Any]) -> dict[str, Any]:
    """The values of a delta by their paths."""
    return {row["path"]: row["value"] for update in delta["updates"] for row in update["values"]}


async def until(socket: Socket, path: str) -> Any:
    """The next value of a path."""
    while path not in (values := values_of(await heard(socket))):
        pass
    return values[path]

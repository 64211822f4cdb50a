"""REST driven in process, on a radar that computes nothing."""

import contextlib
from collections.abc import AsyncIterator
from typing import Any

from radar_service.ports.app import create_app
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server, running
from tests.service.fake import FakeEngine, factory, scene


def station(**options: Any) -> Station:
    settings = options.pop("settings", Settings(pace=Pace("pause")))
    return Station("0", FakeEngine(scene()), options.pop("make", factory()), settings=settings, **options)


@contextlib.asynccontextmanager
async def playing(*stations: Station, **options: Any) -> AsyncIterator[Server]:
    """A service with these radars, or with a paused one; further options are those of the app."""
    stations = stations or (station(),)
    async with running(create_app(stations, **options)) as server:
        server.stations = list(stations)
        yield server

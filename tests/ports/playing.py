"""REST driven in process, on a radar that computes nothing."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from radar_service.ports.app import create_app
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server, running
from tests.service.fake import FakeEngine, factory, scene


def station(**options: Any) -> Station:
    settings = options.pop("settings", Settings(pace=Pace("pause")))
    return Station("0", FakeEngine(scene()), options.pop("make", factory()), settings=settings, **options)


def play(test: Callable[[Server], Awaitable[None]], only: Station | None = None, **options: Any) -> None:
    async def body() -> None:
        async with running(create_app([only or station()], **options)) as server:
            await test(server)

    asyncio.run(asyncio.wait_for(body(), 60))

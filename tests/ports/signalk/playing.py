"""A service with the Signal K port, driven in process."""

import contextlib
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from radar_service.ports.signalk.signalk_port import SignalKPort
from radar_service.world.scene import Scene
from tests.ports.asgi import Server, Socket
from tests.ports.playing import joined

BASE = "/signalk/v2/api/vessels/self/radars"


@contextlib.asynccontextmanager
async def playing(
    *scenes: Scene, gui: Path | None = None, tells_truth: bool = False, **options: Any
) -> AsyncIterator[Server]:
    """A service with radars of these scenes, by default of the test scene."""
    async with joined(SignalKPort(gui, tells_truth), scenes=scenes, **options) as (server, _):
        yield server


async def heard(socket: Socket) -> dict[str, Any]:
    message: dict[str, Any] = json.loads(await socket.text())
    return message


def values_of(delta: dict[str, Any]) -> dict[str, Any]:
    return {row["path"]: row["value"] for update in delta["updates"] for row in update["values"]}


async def until(socket: Socket, path: str) -> Any:
    while path not in (values := values_of(await heard(socket))):
        pass
    return values[path]

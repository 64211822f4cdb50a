"""How long a service takes to start."""

import asyncio
import subprocess
import sys
import time

from clients.ppi.client import FeedClient


def seconds_to_first_spoke(scene: str) -> float:
    """From the command that serves a scene to the first spoke at a client, on the clock [s]."""
    began = time.monotonic()
    command = [sys.executable, "-m", "radar_service", "serve", scene, "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        assert service.stdout is not None
        port = int(service.stdout.readline().rpartition(":")[2].strip(" /\n"))
        asyncio.run(asyncio.wait_for(_first_spoke(f"ws://127.0.0.1:{port}"), 60))
        took = time.monotonic() - began
        service.terminate()
    return took


async def _first_spoke(url: str) -> None:
    async with FeedClient(url) as radar:
        await anext(aiter(radar.spokes()))

"""A service that is killed and started again: a new epoch, soon, and clients that come back by themselves."""

import asyncio
import contextlib
import json
import random
import signal
import socket
import subprocess
import sys
from pathlib import Path

from clients.ppi.client import FeedClient

SCENE = {
    "name": "one target",
    "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "body": [{"name": "p", "shape": "point", "position_m": [0, 300, 10], "rcs_dbsm": 10}],
}


def started(scene: Path, port: int) -> subprocess.Popen[str]:
    """A service that has said that it is on the air."""
    command = [sys.executable, "-m", "radar_service", "serve", str(scene), "--port", str(port), "--pace", "10"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline().startswith("radar on the air")
    return process


def free_port() -> int:
    """A port below those that systems give away themselves: no other program gets it while no service has it."""
    for port in random.sample(range(20_000, 30_000), 100):
        with socket.socket() as free, contextlib.suppress(OSError):
            free.bind(("127.0.0.1", port))
            return port
    raise AssertionError("100 ports are taken")


def test_after_kill_9_clients_come_back_and_no_number_comes_twice(tmp_path: Path) -> None:
    (tmp_path / "one.json").write_text(json.dumps(SCENE))
    port = free_port()
    services: list[subprocess.Popen[str]] = []

    async def follow() -> tuple[list[tuple[str, int]], int]:
        got: list[tuple[str, int]] = []
        services.append(await asyncio.to_thread(started, tmp_path / "one.json", port))
        async with FeedClient(f"ws://127.0.0.1:{port}", reconnect=True, backoff=(0.05, 0.1)) as radar:
            async for spoke in radar.spokes():
                got.append((spoke.epoch, spoke.number))
                if len(got) == 100:
                    services[0].send_signal(signal.SIGKILL)
                    services[0].communicate()
                    services.append(await asyncio.to_thread(started, tmp_path / "one.json", port))
                if len(got) == 400:
                    return got, radar.sequence.lost
        raise AssertionError

    try:
        got, lost = asyncio.run(asyncio.wait_for(follow(), 60))
    finally:
        for service in services:
            service.kill()
            service.communicate()
    epochs = list(dict.fromkeys(epoch for epoch, _ in got))
    assert len(epochs) == 2
    for epoch in epochs:
        numbers = [number for name, number in got if name == epoch]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert numbers[0] == lost  # what the new epoch had sent before the client was back is a gap

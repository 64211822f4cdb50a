"""The feed under load, each process its own: pytest -m bench tests/bench/test_feed_load.py -s prints the figures."""

import asyncio
import contextlib
import gc
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from radar_service.stream import wire
from radar_service.stream.hub import Batch, Hub
from radar_service.stream.mailbox import Client, View

pytestmark = pytest.mark.bench
SECONDS = 20.0
SOAK_SPOKES = 24 * 3600 * 1638  # a day


@pytest.fixture(autouse=True)
def _asked_for(request: pytest.FixtureRequest) -> None:
    if "bench" not in str(request.config.option.markexpr):
        pytest.skip("opt-in: -m bench")


@contextlib.contextmanager
def replaying(azimuths: int, bins: int, told: dict[str, Any]) -> Iterator[tuple[str, str, int]]:
    """Host, port and process of a replaying radar; afterwards `told` has its processor time [s]."""
    command = [sys.executable, "-m", "tests.bench.replay", str(azimuths), str(bins)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        host, _, port = process.stdout.readline().split("open http://")[1].strip(" /\n").partition(":")
        try:
            yield host, port, process.pid
        finally:
            process.send_signal(signal.SIGTERM)
            out, _ = process.communicate(timeout=30)
            told |= json.loads(out.splitlines()[-1])


def memory(process: int) -> int:
    """Resident bytes of a process."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.parametrize(
    ("clients", "azimuths", "bins", "stalled", "p99_ms"),
    [(100, 4096, 1024, 0, 10.0), (100, 8192, 4096, 0, 20.0), (500, 2048, 1024, 0, 30.0), (100, 4096, 1024, 10, 10.0)],
)
def test_clients_are_served_in_time(clients: int, azimuths: int, bins: int, stalled: int, p99_ms: float) -> None:
    told: dict[str, Any] = {}
    with replaying(azimuths, bins, told) as (host, port, process):
        before = memory(process)
        began = time.monotonic()
        query = f"encoding=u8&bins={bins}"
        command = [sys.executable, "-m", "tests.bench.load", host, port, str(clients), str(SECONDS), str(stalled), query]
        result = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        grown, wall = memory(process) - before, time.monotonic() - began
    result |= {"cores": round(told["processor_s"] / wall, 2), "grown_mib": round(grown / 2**20, 1)}
    print(json.dumps({"spokes_per_s": round(azimuths * 0.4), "bins": bins, "load_average": os.getloadavg()[0]} | result))
    assert result["holes"] == 0 and result["lost"] == 0
    assert result["p99_ms"] < p99_ms


def test_a_day_of_spokes_through_the_hub_grows_nothing() -> None:
    """142 million spokes in batches of 32, to four clients that read and one that does not; numbers exact to the end."""
    view = View("u8")
    data = {view: wire.pack({"type": "spokes", "epoch": "e", "data": bytes(1024)})}

    async def soak() -> list[tuple[int, int, int]]:
        hub, held = Hub(time.monotonic), []
        hub.open_epoch("e", lambda view, mode: b"")
        readers, deaf = [Client(view) for _ in range(4)], Client(view)
        for client in [*readers, deaf]:
            hub.join(client)
        seen = [0] * 4
        for k in range(SOAK_SPOKES // 32):
            await hub.publish(Batch("e", 32 * k, 32, data))
            for n, reader in enumerate(readers):
                while reader._queue or reader._backlog:
                    item = await reader.get()
                    assert item is not None and item.first in (0, seen[n])
                    seen[n] = item.first + item.count
            if k % (SOAK_SPOKES // 32 // 8) == 0:
                gc.collect()
                held.append((memory(os.getpid()), len(asyncio.all_tasks()), len(os.listdir("/proc/self/fd"))))
        assert seen == [SOAK_SPOKES // 32 * 32] * 4 == [hub.next] * 4
        assert deaf.lost + deaf._droppable * 32 == hub.next
        return held

    held = asyncio.run(soak())
    print([(round(size / 2**20, 1), tasks, files) for size, tasks, files in held])
    assert held[-1][0] - held[2][0] < 2 * 2**20 and len({entry[1:] for entry in held}) == 1

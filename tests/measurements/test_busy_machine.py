"""Uploads and other scenes beside eight programs that take all processor time they get, and the lag of the feed meanwhile.

`pytest -m bench -s tests/measurements/test_busy_machine.py` prints the figures of docs/accuracy.md#a-busy-machine.
"""

import asyncio
import contextlib
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from websockets.asyncio.client import connect

from radar_service import wire
from radar_service.scene_file.document import packaged_folder

pytestmark = pytest.mark.bench
PROGRAMS, SECONDS = 8, 120.0  # after which they end by themselves
AIM, LAG_AIM = 15.0, 1.0  # s
LOOP = "import sys, time\nend = time.monotonic() + float(sys.argv[1])\nwhile time.monotonic() < end: pass"


@pytest.fixture
def service() -> Iterator[str]:
    command = [sys.executable, "-m", "radar_service", "serve", "harbour", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield process.stdout.readline().split()[-1]
    process.terminate()
    process.communicate(timeout=60)


@contextlib.contextmanager
def busy_programs(count: int, sessions: int) -> Iterator[None]:
    """So many programs that compute, in so many sessions: Linux shares processors among sessions first."""
    loop = f"{sys.executable} -c {shlex.quote(LOOP)} {SECONDS} & "
    command = ["bash", "-c", count // sessions * loop + "wait"]
    programs = [subprocess.Popen(command, start_new_session=True) for _ in range(sessions)]
    try:
        yield
    finally:
        for program in programs:
            os.killpg(program.pid, signal.SIGKILL)
            program.wait()


def form(name: str, folder: Path) -> tuple[dict[str, str], list[tuple[str, tuple[str, bytes]]]]:
    """The harbour with its meshes, as the page sends it."""
    meshes = [("files", (path.name, path.read_bytes())) for path in folder.glob("*.obj")]
    height_maps = [("files", (path.name, path.read_bytes())) for path in folder.glob("*.png")]
    return {"name": name}, [("scene", ("harbour.toml", (folder / "harbour.toml").read_bytes())), *meshes, *height_maps]


async def lags(address: str, end: asyncio.Event) -> list[float]:
    """How far a client of the feed is behind the schedule of the radar [s], several times a second."""
    late, newest = list[float](), {"epoch": "", "time": 0.0}

    async def read() -> None:
        async with connect(f"{address.replace('http', 'ws')}api/radars/0/feed?bins=128", proxy=None) as feed:
            while not end.is_set():
                message = wire.unpack(await feed.recv())
                if message["type"] == "spokes":
                    newest.update(epoch=message["epoch"], time=message["time"][-1])

    reading = asyncio.create_task(read())
    async with httpx.AsyncClient(base_url=address, timeout=600) as http:
        while not end.is_set():
            (radar,) = (await http.get("api/health")).json()["radars"]
            if radar["epoch"] == newest["epoch"]:
                late.append(radar["lag_s"] + radar["simulated_s"] - newest["time"])
            await asyncio.sleep(0.2)
    await reading
    return late


async def measured(address: str, name: str) -> tuple[float, float, float]:
    """Seconds of an upload and of a change of scene, and the longest lag of the feed meanwhile [s]."""
    end = asyncio.Event()
    following = asyncio.create_task(lags(address, end))
    async with httpx.AsyncClient(base_url=address, timeout=600) as http:
        fields, files = form(name, packaged_folder("scenes"))
        began = time.monotonic()
        (await http.post("api/scenes", data=fields, files=files)).raise_for_status()
        uploaded = time.monotonic()
        (await http.put("api/radars/0/scene", json={"scene": "harbour"})).raise_for_status()
        changed = time.monotonic()
    end.set()
    return uploaded - began, changed - uploaded, max(await following)


def test_uploads_beside_busy_programs(service: str) -> None:
    """Of one session, as from one shell, within the aim; of as many sessions an upload has the share of any other program."""
    for words, sessions in (
        ("alone", 0),
        (f"beside {PROGRAMS} of one session", 1),
        (f"beside {PROGRAMS} sessions", PROGRAMS),
    ):
        with busy_programs(PROGRAMS, sessions) if sessions else contextlib.nullcontext():
            upload, change, lag = asyncio.run(measured(service, f"a{sessions}"))
        print(f"{words:24s} upload {upload:5.1f} s, another scene {change:5.1f} s, lag of the feed {lag:5.2f} s")
        assert lag <= LAG_AIM and (sessions > 1 or max(upload, change) <= AIM)

"""Pictures: drawn once for all who request the same, a few a second, in a process."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest

from radar_service.ports.rest import pictures
from radar_service.ports.rest.pictures import Pictures
from radar_service.processes.call import ProcessFault
from radar_service.processes.fork_server import ForkServer
from radar_service.service.jobs import Busy
from radar_service.service.settings import Pace, Settings
from tests.ports.playing import station


@contextlib.asynccontextmanager
async def playing(fork_server: ForkServer, pauses: list[float] | None = None) -> AsyncIterator[Pictures]:
    drawing = Pictures(fork_server, [].append if pauses is None else pauses.append)
    try:
        yield drawing
    finally:
        drawing.close()


async def test_equal_pictures_are_drawn_once(fork_server: ForkServer) -> None:
    radar = station()
    async with playing(fork_server) as drawing:
        both = await asyncio.gather(*(drawing.png(radar, 64, None) for _ in range(8)))
        assert len(set(both)) == 1 and both[0].startswith(b"\x89PNG")
        assert await drawing.png(radar, 64, None) is both[0]
        assert await drawing.png(radar, 65, None) != both[0]


def test_a_running_radar_has_a_picture_for_each_revolution_and_a_paused_one_for_each_spoke() -> None:
    paused, running = station(), station(settings=Settings(pace=Pace()))
    for radar, moments in ((paused, 3), (running, 2)):
        seen = set()
        for spokes in (1, 2, 24):
            seen.add(pictures.moment(radar, replace(radar.last_scan.read(), next=spokes)))
        assert len(seen) == moments


async def test_different_ones_are_drawn_at_a_bounded_rate_and_too_many_are_refused(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    radar, pauses, begun = station(), list[float](), threading.Event()
    monkeypatch.setattr(pictures, "call_in_process", lambda *_: b"drawn" if begun.wait(10) else b"")
    async with playing(fork_server, pauses) as drawing:
        tasks = [asyncio.create_task(drawing.png(radar, 64 + n, None)) for n in range(6)]
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)  # the one that is refused
        begun.set()
        answers = await asyncio.gather(*tasks, return_exceptions=True)
        assert [isinstance(answer, Busy) for answer in answers] == [False] * 5 + [True]  # one is drawn, four wait
    assert pauses[0] == 0.0 and all(0.0 <= pause <= 1 / pictures.MAX_PER_SECOND for pause in pauses) and len(pauses) == 5


async def test_a_picture_that_fails_is_drawn_again(fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch) -> None:
    radar, times = station(), list[int]()

    def fail_once(*_: object) -> bytes:
        times.append(1)
        if len(times) == 1:
            raise ProcessFault("it crashed")
        return b"drawn"

    monkeypatch.setattr(pictures, "call_in_process", fail_once)
    async with playing(fork_server) as drawing:
        with pytest.raises(ProcessFault):
            await drawing.png(radar, 64, None)
        assert await drawing.png(radar, 64, None) == b"drawn"

"""What keeps the service from working makes it unready, and says so."""

import asyncio
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from radar_service.ports.rest import metrics
from radar_service.ports.rest.metrics import Vitals
from radar_service.service.jobs import JobQueue
from radar_service.service.radio.radio_state import Failed, Looked
from radar_service.service.radio.scene_process import SpokeWorker
from tests.ports.playing import playing, station

READY = "/api/health/ready"


async def test_a_working_server_has_no_problems() -> None:
    async with playing() as server:
        answer = await server.http.get(READY)
        assert answer.status_code == 200 and answer.json() == {"yes": True}


class CountingPool(ThreadPoolExecutor):
    """Two threads, and how many tasks they were given."""

    def __init__(self) -> None:
        super().__init__(2)
        self.tasks = 0

    def submit(self, *task: Any, **more: Any) -> Any:
        self.tasks += 1
        return super().submit(*task, **more)


async def test_a_stuck_pool_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "POOL_SECONDS", 0.05)
    release = threading.Event()
    async with playing() as server:
        asyncio.get_running_loop().set_default_executor(pool := CountingPool())
        held = [asyncio.create_task(asyncio.to_thread(release.wait, 10)) for _ in range(2)]
        await asyncio.sleep(0)
        for _ in range(3):
            answer = await server.http.get(READY)
            assert answer.status_code == 503 and answer.json()["problems"] == ["threads: none was free for 0.05 s"]
        assert pool.tasks == 3  # probes do not pile up
        release.set()
        await asyncio.gather(*held)
        monkeypatch.setattr(metrics, "POOL_SECONDS", 10.0)
        assert (await server.http.get(READY)).status_code == 200


async def test_a_full_disk_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    async with playing() as server:
        monkeypatch.setattr(metrics, "MIN_FREE_BYTES", 2**80)
        answer = await server.http.get(READY)
        assert answer.status_code == 503 and answer.json()["problems"][0].startswith("disk: less than")


async def test_a_dead_worker_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    async with playing(station()) as server:
        monkeypatch.setattr(SpokeWorker, "is_alive", False)
        answer = await server.http.get(READY)
        assert answer.status_code == 503 and answer.json()["problems"] == ["radar 0: its worker has died"]


async def test_a_radar_whose_engine_is_made_anew_or_that_has_failed_lacks_no_worker(tmp_path: Path) -> None:
    watched, only = Vitals(JobQueue(), tmp_path), station()
    state, dead = only.transmitter.state, ["radar 0: its worker has died"]
    problems = [await watched.problems([only])]
    look = Looked(0.0, only.transmitter.pacer.run_control())
    for events in (4 * [Failed("it broke", 0.0)], [look]):
        for event in events:
            state.handle(event)
        problems.append(await watched.problems([only]))
    assert problems == [dead, [], []]


async def test_a_job_that_does_not_end_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "JOB_SECONDS", -1.0)
    started, release = threading.Event(), threading.Event()
    queue = JobQueue()
    watched = Vitals(queue, tmp_path)
    assert await watched.problems(()) == []
    job = asyncio.create_task(queue.run("test", lambda _: (started.set(), release.wait(10))))
    await asyncio.to_thread(started.wait, 10)
    assert await watched.problems(()) == ["jobs: one has taken more than -1 s"]
    assert watched.job_states == {"waiting": 0, "running": 1}
    release.set()
    await job
    queue.close()


async def test_a_blocked_event_loop_shows_as_lag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(metrics, "LAG_PERIOD", 0.01)
    watched = Vitals(JobQueue(), tmp_path)
    assert watched.lag == 0.0
    watched.start()
    until = time.monotonic() + 0.2
    while time.monotonic() < until:  # blocks the loop
        continue
    while watched.lag == 0.0:
        await asyncio.sleep(0.001)
    assert 0.18 < watched.lag < 60.0  # s: 0.2 less the period, and what else the machine does
    watched.close()


async def test_a_task_that_is_left_behind_is_counted(tmp_path: Path) -> None:
    watched = Vitals(JobQueue(), tmp_path)
    before = watched.tasks
    left = asyncio.create_task(asyncio.Event().wait())
    assert watched.tasks == before + 1
    left.cancel()

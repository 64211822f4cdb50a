"""The queue of jobs: bounded, cancelled, never stuck."""

import asyncio
import contextlib
import threading
import weakref
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import pytest

from radar_service.service.jobs import MAX_FINISHED, Busy, Cancelled, DuplicateJob, JobQueue, WatchedJob


@contextlib.asynccontextmanager
async def playing(workers: int = 1, waiting: int = 1) -> AsyncIterator[JobQueue]:
    queue = JobQueue(workers, waiting)
    try:
        yield queue
    finally:
        queue.close()


class Gate:
    """Work that waits until it is let go, or ended as a process is."""

    def __init__(self) -> None:
        self.began, self.open = threading.Event(), threading.Event()

    def __call__(self, job: WatchedJob) -> str:
        job.ends_with(self.open.set)
        job.stage("in the middle")
        self.began.set()
        assert self.open.wait(60)
        return "result"

    async def begun(self) -> None:
        while not self.began.is_set():
            await asyncio.sleep(0.001)


async def test_a_job_tells_its_stages() -> None:
    async with playing() as queue:
        gate = Gate()
        running = asyncio.create_task(queue.run("scene", gate, "mine"))
        await gate.begun()
        told = queue.job("mine").as_dict()
        assert (told["id"], told["kind"], told["state"], told["doing"]) == ("mine", "scene", "running", "in the middle")
        gate.open.set()
        assert await running == "result"
        told = queue.job("mine").as_dict()
        assert (told["state"], told["doing"]) == ("done", "") and told["seconds"] == queue.job("mine").as_dict()["seconds"]


async def test_no_more_wait_than_may_and_names_are_unique_while_they_run() -> None:
    async with playing() as queue:
        gate = Gate()
        first = asyncio.create_task(queue.run("scene", gate, "a"))
        await gate.begun()
        with pytest.raises(DuplicateJob):
            await queue.run("scene", Gate(), "a")
        second = asyncio.create_task(queue.run("scene", Gate(), "b"))
        await asyncio.sleep(0)
        with pytest.raises(Busy):
            await queue.run("scene", Gate())
        queue.job("b").cancel()  # before its turn
        gate.open.set()
        assert await first == "result"
        with pytest.raises(Cancelled):
            await second
        open_gate = Gate()
        open_gate.open.set()
        assert await queue.run("scene", open_gate, "a") == "result"  # a name may be used again


@pytest.mark.parametrize("workers", [1, 2])
async def test_many_at_once_all_end(workers: int) -> None:
    """Jobs never wait for one another, so six on two workers end, or on one."""
    async with playing(workers, 6) as queue:
        assert await asyncio.gather(*(queue.run("upload", lambda job, n=n: n) for n in range(6))) == list(range(6))


async def test_who_waits_for_a_cancelled_job_is_told_before_its_work_has_ended() -> None:
    """A process that ends slowly on a busy machine delays no answer; the worker is free again when it has ended."""
    ended = threading.Event()

    class Slow(Gate):
        def __call__(self, job: WatchedJob) -> str:
            super().__call__(job)
            assert ended.wait(60)
            return "too late"

    async with playing() as queue:
        slow, next_one = Slow(), Gate()
        running = asyncio.create_task(queue.run("scene", slow, "a"))
        await slow.begun()
        queue.job("a").cancel()
        with pytest.raises(Cancelled):
            await running
        waiting = asyncio.create_task(queue.run("scene", next_one, "b"))
        await asyncio.sleep(0)
        assert queue.job("b").state == "waiting"
        ended.set()
        next_one.open.set()
        assert await waiting == "result" and queue.job("a").state == "cancelled"


async def test_a_job_that_is_listed_keeps_no_result() -> None:
    async with playing() as queue:
        made = weakref.ref(await queue.run("scene", lambda job: Scene(), "a"))
        await queue.run("scene", lambda job: None, "b")  # the only thread holds the first result until it works again
        assert queue.job("a").state == "done" and made() is None


async def test_an_error_of_the_work_is_raised_and_noted() -> None:
    def fail(job: WatchedJob) -> None:
        raise ValueError("it broke")

    async with playing() as queue:
        with pytest.raises(ValueError, match="it broke"):
            await queue.run("scene", fail, "a")
        assert queue.job("a").state == "failed"


async def test_a_request_that_goes_away_ends_its_job() -> None:
    async with playing() as queue:
        gate = Gate()
        running = asyncio.create_task(queue.run("scene", gate, "a"))
        await gate.begun()
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running
        assert queue.job("a").state == "cancelled" and gate.open.is_set()


async def test_only_the_last_jobs_are_remembered_and_a_closed_queue_takes_none() -> None:
    async with playing() as queue:
        for number in range(MAX_FINISHED + 5):
            await queue.run("scene", lambda job: None, str(number))
        assert [job.name for job in queue.jobs] == [str(n) for n in range(5, MAX_FINISHED + 5)]
        queue.close()
        with pytest.raises(Busy):
            await queue.run("scene", lambda job: None)


class Scene:
    """What a job makes."""

    def close(self) -> None:
        pass


@pytest.mark.parametrize("end", ["done", "failed", "cancelled", "cancelled before its turn"])
def test_a_job_that_has_ended_keeps_nothing_that_it_has_made(end: str) -> None:
    made = list[weakref.ref[Scene]]()

    def work(job: WatchedJob) -> None:
        scene = Scene()
        made.append(weakref.ref(scene))
        if end == "cancelled before its turn":
            job.cancel()
        job.ends_with(scene.close)
        if end == "failed":
            raise ValueError
        if end == "cancelled":
            job.cancel()

    job = WatchedJob("a", "scene")
    with contextlib.suppress(ValueError, Cancelled):
        job.perform(work)
        job.succeed()
    assert job.is_over and made[0]() is None


class AtOnce(ThreadPoolExecutor):
    """Threads as fast as can be: work has ended before anyone waits for it."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        ended = Future[Any]()
        ended.set_result(fn(*args, **kwargs))
        return ended


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.service.jobs.ThreadPoolExecutor", AtOnce)


async def test_a_job_that_is_cancelled_before_anyone_waits_for_it_returns_nothing(at_once: None) -> None:
    closed = threading.Event()
    async with playing() as queue:

        def work(job: WatchedJob) -> str:
            job.cancel()
            job.ends_with(closed.set)
            return "too late"

        with pytest.raises(Cancelled):
            await queue.run("scene", work, "a")
        assert queue.job("a").state == "cancelled" and closed.is_set()


@pytest.mark.parametrize("passes", range(1, 4))
@pytest.mark.parametrize("who", ["request", "job"])
async def test_what_was_made_is_closed_or_returned_whenever_it_is_cancelled(who: str, passes: int, at_once: None) -> None:
    """The result takes a few passes of the event loop from the thread to the request; the end comes at each of them."""
    closed = threading.Event()
    async with playing() as queue:
        running = asyncio.create_task(queue.run("scene", lambda job: job.ends_with(closed.set), "a"))
        for _ in range(passes):
            await asyncio.sleep(0)
        if who == "request":
            running.cancel()
        else:
            queue.job("a").cancel()
        (outcome,) = await asyncio.gather(running, return_exceptions=True)
        assert closed.is_set() == (outcome is not None) == (queue.job("a").state == "cancelled")


class Preempted(contextlib.AbstractContextManager[None]):
    """A lock whose first owner comes just after something else has happened."""

    def __init__(self, happens: Callable[[], None]) -> None:
        self._happens, self._lock = [happens], threading.RLock()

    def __enter__(self) -> None:
        if self._happens:
            self._happens.pop()()
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()


def test_a_job_that_is_cancelled_just_before_it_begins_does_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    job, began = WatchedJob("a", "scene"), threading.Event()
    monkeypatch.setattr(job, "_ending", Preempted(job.cancel))
    with pytest.raises(Cancelled):
        job.perform(lambda job: began.set())
    assert job.state == "cancelled" and not began.is_set()


def test_work_that_tells_how_it_ends_just_before_it_is_cancelled_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    job, closed = WatchedJob("a", "scene"), threading.Event()
    monkeypatch.setattr(job, "_ending", Preempted(lambda: job.ends_with(closed.set)))
    job.cancel()
    assert job.state == "cancelled" and closed.is_set()

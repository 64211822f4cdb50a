"""Scenes are prepared once: an upload waits for the radar that runs it, but not for ever."""

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from radar_service.stream.radio import preparation
from radar_service.stream.radio.preparation import Preparations
from radar_service.stream.source import Progress, SceneOrder
from tests.stream.fake import FakeEngine, factory, scene

FIRST, SECOND = SceneOrder({"name": "first"}), SceneOrder({"name": "second"})
made: list[FakeEngine] = []


def make(order: SceneOrder, progress: Progress) -> FakeEngine:
    engine = factory()(order, progress)
    made.append(engine)
    return engine


def play(test: Callable[[Preparations], Awaitable[None]]) -> None:
    async def body() -> None:
        made.clear()
        preparations = Preparations()
        try:
            await test(preparations)
        finally:
            preparations.close()
        assert all(engine.closed for engine in made)

    asyncio.run(asyncio.wait_for(body(), 20))


def test_an_upload_that_is_run_next_is_prepared_once() -> None:
    async def test(preparations: Preparations) -> None:
        preparations.keep(await preparations.source(make, FIRST))
        worker = await preparations.worker(make, FIRST)
        assert len(made) == 1 and worker.engine is made[0] and not made[0].closed
        again = await preparations.worker(make, FIRST)  # it is no longer kept
        assert len(made) == 2 and again.engine is made[1]
        for one in (worker, again):
            one.stop()

    play(test)


def test_only_the_newest_is_kept_and_only_until_it_is_dropped() -> None:
    async def test(preparations: Preparations) -> None:
        for order in (FIRST, SECOND):
            preparations.keep(await preparations.source(make, order))
        assert [engine.closed for engine in made] == [True, False]
        preparations.drop(FIRST)
        assert not made[1].closed
        preparations.drop(SECOND)
        assert made[1].closed

    play(test)


def test_it_is_kept_for_a_time_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preparation, "KEPT_SECONDS", 0.0)

    async def test(preparations: Preparations) -> None:
        preparations.keep(await preparations.source(make, FIRST))
        while not made[0].closed:
            await asyncio.sleep(0)

    play(test)


def test_a_kept_scene_that_has_died_is_made_anew() -> None:
    async def test(preparations: Preparations) -> None:
        dead = FakeEngine(scene(), dies_at=0)
        dead.order = FIRST
        preparations.keep(dead)
        worker = await preparations.worker(make, FIRST)
        assert dead.closed and worker.engine is made[0]
        worker.stop()

    play(test)

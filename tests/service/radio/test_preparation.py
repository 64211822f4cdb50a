"""Scenes are prepared once: an upload waits for the radar that runs it, but not for ever."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest

from radar_service.processes.call import Progress
from radar_service.service.jobs import Cancelled
from radar_service.service.radio import preparation
from radar_service.service.radio.preparation import Preparations
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.transmitter import SceneChanged
from radar_service.service.scene_request import SceneRequest, SceneSpokeSource
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world.commands import Command
from radar_service.world.scene import SceneOutline
from tests.service.fake import FakeEngine, factory, scene, steerable_scene

FIRST, SECOND = SceneRequest({"name": "first"}), SceneRequest({"name": "second"})
made: list[FakeEngine] = []


def make(order: SceneRequest, progress: Progress) -> FakeEngine:
    engine = factory()(order, progress)
    made.append(engine)
    return engine


@contextlib.asynccontextmanager
async def playing() -> AsyncIterator[Preparations]:
    made.clear()
    preparations = Preparations()
    try:
        yield preparations
    finally:
        preparations.close()
    assert all(engine.closed for engine in made)


async def only(preparations: Preparations, order: SceneRequest) -> SpokeWorker:
    """The worker of a scene with one radar."""
    return (await preparations.workers(make, {"0": order}))["0"]


async def test_an_upload_that_is_run_next_is_prepared_once() -> None:
    async with playing() as preparations:
        preparations.keep(await preparations.spoke_source(make, FIRST))
        worker = await only(preparations, FIRST)
        assert len(made) == 1 and worker.spoke_source is made[0] and not made[0].closed
        again = await only(preparations, FIRST)  # it is no longer kept
        assert len(made) == 2 and again.spoke_source is made[1]
        for one in (worker, again):
            one.stop()


async def test_only_the_newest_is_kept_and_only_until_it_is_dropped() -> None:
    async with playing() as preparations:
        for order in (FIRST, SECOND):
            preparations.keep(await preparations.spoke_source(make, order))
        assert [engine.closed for engine in made] == [True, False]
        preparations.drop(FIRST)
        assert not made[1].closed
        preparations.drop(SECOND)
        assert made[1].closed


async def test_it_is_kept_for_a_time_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(preparation, "KEPT_SECONDS", 0.0)
    async with playing() as preparations:
        preparations.keep(await preparations.spoke_source(make, FIRST))
        while not made[0].closed:
            await asyncio.sleep(0.001)


async def test_a_kept_scene_that_has_died_is_made_anew() -> None:
    async with playing() as preparations:
        dead = FakeEngine(scene(), dies_at=0)
        dead.scene_request = FIRST
        preparations.keep(dead)
        worker = await only(preparations, FIRST)
        assert dead.closed and worker.spoke_source is made[0]
        worker.stop()


def refusing(scene: SceneOutline) -> dict[str, SceneRequest]:
    raise ValueError(f"not {scene.name}")


@pytest.mark.parametrize("kept", [False, True])
async def test_a_scene_that_is_refused_is_ended_before_its_first_spokes(kept: bool) -> None:
    async with playing() as preparations:
        if kept:
            preparations.keep(await preparations.spoke_source(make, FIRST))
        with pytest.raises(ValueError, match="not first"):
            await preparations.workers(make, {"0": FIRST}, others=refusing)
        assert [engine.blocks_made for engine in made] == [0] and made[0].closed


async def test_the_first_radar_of_a_scene_tells_which_others_there_are() -> None:
    async with playing() as preparations:
        workers = await preparations.workers(make, {"": FIRST}, others=lambda scene: {"a": SECOND, "b": FIRST})
        assert [worker.spoke_source.scene_request for worker in workers.values()] == [FIRST, SECOND, FIRST]
        assert list(workers) == ["", "a", "b"] and len(made) == 3
        for worker in workers.values():
            worker.stop()


async def test_where_one_radar_of_a_scene_fails_the_others_are_ended() -> None:
    def second_fails(order: SceneRequest, progress: Progress) -> FakeEngine:
        if order is SECOND:
            raise SpokeSourceFault("no memory")
        return make(order, progress)

    async with playing() as preparations:
        with pytest.raises(SpokeSourceFault, match="no memory"):
            await preparations.workers(second_fails, {"a": FIRST, "b": SECOND})
        assert len(made) == 1 and made[0].closed


async def test_a_cancelled_preparation_ends_all_radars() -> None:
    """The job is cancelled while the second radar is made, which ends well all the same, later than the job."""
    async with playing() as preparations:
        loop = asyncio.get_running_loop()

        async def cancel() -> None:
            preparations.jobs.job("mine").cancel()

        def cancels(order: SceneRequest, progress: Progress) -> FakeEngine:
            engine = make(order, progress)
            if order is SECOND:
                asyncio.run_coroutine_threadsafe(cancel(), loop).result(20)
            return engine

        with pytest.raises(Cancelled):
            await preparations.workers(cancels, {"a": FIRST, "b": SECOND}, "mine")
        while not all(engine.closed for engine in made):
            await asyncio.sleep(0.001)
        assert len(made) == 2


async def test_the_first_spokes_follow_the_scan_and_the_commands_that_are_chosen_when_it_is_prepared() -> None:
    of = steerable_scene()
    given = [Command(3, 3 * 2.5 / 24, "buoy", speed_kn=5.0)]
    async with playing() as preparations:
        orders = {"0": SceneRequest(of, rpm=48)}
        agreed = preparations.workers(make, orders, begin=lambda engine: (1, given))
        (worker,) = (await agreed).values()
        block = worker.take(1.0)
        worker.stop()
        assert list(worker.commands) == given and block is not None and (block.first, block.commands) == (24, 1)


async def test_a_scene_that_has_nothing_to_go_on_from_is_ended() -> None:
    def refuse(engine: SceneSpokeSource) -> tuple[int, list[Command]]:
        raise SceneChanged

    async with playing() as preparations:
        with pytest.raises(SceneChanged):
            await preparations.workers(make, {"0": SceneRequest(scene(), rpm=48)}, begin=refuse)
        assert made[0].closed and not made[0].blocks_made

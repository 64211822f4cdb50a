"""Prepares scenes for all radars of a server, and keeps the newest upload prepared for a while."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from radar_service.processes.call import Progress
from radar_service.radar.parameters import Origin
from radar_service.service.jobs import Job, JobQueue
from radar_service.service.radio.prefetch import EngineFault, EngineWorker, prepared
from radar_service.service.source import MakeSource, OrderedSource, SceneOrder
from radar_service.spoke_source import Continuing
from radar_service.world.commands import Command
from radar_service.world.outline import SceneOutline

Check = Callable[[SceneOutline], None]
Agree = Callable[[], tuple[Origin, Sequence[Command]]]
KEPT_SECONDS = 60.0  # that an uploaded scene stays prepared for a radar to run it


class Preparations:
    """The queue of preparations, and one prepared upload. Belongs to the event loop."""

    def __init__(self, jobs: JobQueue | None = None) -> None:
        self.jobs = jobs or JobQueue()
        self._kept: OrderedSource | None = None
        self._timer: asyncio.TimerHandle | None = None

    async def source(self, make: MakeSource, order: SceneOrder, job: str | None = None) -> OrderedSource:
        """Returns a prepared scene. job: its name in the queue. Raises what JobQueue.run and `make` raise."""
        return await self.jobs.run("upload", lambda progress: make(order, progress), job)

    async def workers(
        self, make: MakeSource, orders: Mapping[str, SceneOrder], job: str | None = None, check: Check = lambda scene: None,
        agree: Agree | None = None,
    ) -> dict[str, EngineWorker]:  # fmt: skip
        """Returns the radars of a scene, by their ids, which have computed their first spokes.

        check: refuses scenes, before their first spokes; agree: tells, in the job's thread, where a scene goes on that is
        prepared but for that, and the commands that it follows. Raises as `source`, `check` and `agree`, and EngineFault.
        """
        kept = {name: source for name, order in orders.items() if (source := self._taken(order))}

        def prepare(progress: Job) -> dict[str, EngineWorker]:
            workers: dict[str, EngineWorker] = {}
            with contextlib.ExitStack() as on_failure:
                for name, order in orders.items():
                    workers[name] = _worker(kept.get(name), partial(make, order), check, progress, agree)
                    on_failure.callback(workers[name].stop)
                progress.ends_with(partial(_stop, workers))  # a cancelled job returns none of them
                on_failure.pop_all()
            return workers

        try:
            return await self.jobs.run("scene", prepare, job)
        except BaseException:
            for source in kept.values():
                source.close()
            raise

    def keep(self, source: OrderedSource) -> None:
        """Keeps a prepared scene for KEPT_SECONDS, in place of the one that was kept before."""
        self.drop()
        self._kept = source
        self._timer = asyncio.get_running_loop().call_later(KEPT_SECONDS, self.drop)

    def drop(self, order: SceneOrder | None = None) -> None:
        """Ends the scene that is kept; with `order` only where it is that one."""
        if self._kept and order in (None, self._kept.order):
            self._kept.close()
            self._forget()

    def close(self) -> None:
        """Ends all preparations."""
        self.drop()
        self.jobs.close()

    def _taken(self, order: SceneOrder) -> OrderedSource | None:
        """Returns the scene that is kept, where it is this one; it is then no longer kept."""
        kept = self._kept
        if kept is None or kept.order != order:
            return None
        self._forget()
        return kept

    def _forget(self) -> None:
        self._kept = None
        if self._timer:
            self._timer.cancel()


def _worker(
    kept: OrderedSource | None, make: Callable[[Progress], OrderedSource], check: Check, progress: Progress, agree: Agree | None
) -> EngineWorker:  # fmt: skip
    """Returns a scene that has computed its first spokes: the one that was kept, or where that has died meanwhile another."""
    if kept:
        progress.ends_with(kept.close)
        check(kept.info.scene)
        with contextlib.suppress(EngineFault):
            return _first_spokes(kept, progress)
    source = make(progress)
    try:
        check(source.info.scene)
        commands: Sequence[Command] = ()
        if agree:
            assert isinstance(source, Continuing)  # one that cannot go on is not made for an agreement
            origin, earlier = agree()
            source.begin_at(origin)
            commands = [command.after_change_of_rpm(source.info.radar) for command in earlier]
    except BaseException:
        source.close()
        raise
    return _first_spokes(source, progress, commands)


def _stop(workers: Mapping[str, EngineWorker]) -> None:
    for worker in workers.values():
        worker.stop()


def _first_spokes(source: OrderedSource, progress: Progress, commands: Sequence[Command] = ()) -> EngineWorker:
    progress.stage("computing the first spokes")
    return prepared(source, commands=commands)

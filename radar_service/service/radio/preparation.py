"""Prepares scenes for all radars of a server, and keeps the newest upload prepared for a while."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from radar_service.processes.call import Progress
from radar_service.service.jobs import JobQueue, WatchedJob
from radar_service.service.radio.scene_process import SpokeWorker, end, prepared
from radar_service.service.scene_request import MakeSpokeSource, SceneRequest, SceneSpokeSource
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world import Command, SceneOutline

Others = Callable[[SceneOutline], Mapping[str, SceneRequest]]
Begin = Callable[[SceneSpokeSource], tuple[int, Sequence[Command]]]
KEPT_SECONDS = 60.0  # that an uploaded scene stays prepared for a radar to run it


class Preparations:
    """The queue of preparations, and one prepared upload. Belongs to the event loop."""

    def __init__(self) -> None:
        self.jobs = JobQueue()
        self._kept: SceneSpokeSource | None = None
        self._timer: asyncio.TimerHandle | None = None

    async def spoke_source(
        self, make: MakeSpokeSource, scene_request: SceneRequest, job: str | None = None
    ) -> SceneSpokeSource:
        """Returns a prepared scene. job: its name in the queue. Raises what JobQueue.run and `make` raise."""
        return await self.jobs.run("upload", lambda progress: make(scene_request, progress), job)

    async def workers(
        self, make: MakeSpokeSource, scene_requests: Mapping[str, SceneRequest], job: str | None = None,
        others: Others = lambda scene: {}, begin: Begin = lambda spoke_source: (0, ()),
    ) -> dict[str, SpokeWorker]:  # fmt: skip
        """Returns the radars of a scene, by the names of their requests, which have computed their first spokes.

        others: returns the further requests of a scene, or refuses it, before its first spokes; begin: returns, in the job's
        thread, the first scan of a prepared scene, and the commands that it follows. Raises as `spoke_source`, `others` and
        `begin`, and SpokeSourceFault.
        """
        kept = {
            name: spoke_source
            for name, scene_request in scene_requests.items()
            if (spoke_source := self._taken(scene_request))
        }

        def prepare(progress: WatchedJob) -> dict[str, SpokeWorker]:
            workers, requests = dict[str, SpokeWorker](), dict(scene_requests)
            with contextlib.ExitStack() as on_failure:
                while missing := [name for name in requests if name not in workers]:
                    name, note = missing[0], lambda scene: requests.update(others(scene))
                    workers[name] = _worker(kept.get(name), partial(make, requests[name]), note, progress, begin)
                    on_failure.callback(workers[name].stop)
                progress.ends_with(partial(end, workers))  # a cancelled job returns none of them
                on_failure.pop_all()
            return workers

        try:
            return await self.jobs.run("scene", prepare, job)
        except BaseException:
            for spoke_source in kept.values():
                spoke_source.close()
            raise

    def keep(self, spoke_source: SceneSpokeSource) -> None:
        """Keeps a prepared scene for KEPT_SECONDS, in place of the one that was kept before."""
        self.drop()
        self._kept = spoke_source
        self._timer = asyncio.get_running_loop().call_later(KEPT_SECONDS, self.drop)

    def drop(self, scene_request: SceneRequest | None = None) -> None:
        """Ends the scene that is kept; with `scene_request` only where it is that one."""
        if self._kept and scene_request in (None, self._kept.scene_request):
            self._kept.close()
            self._forget()

    def close(self) -> None:
        """Ends all preparations."""
        self.drop()
        self.jobs.close()

    def _taken(self, scene_request: SceneRequest) -> SceneSpokeSource | None:
        """Returns the scene that is kept, where it is this one; it is then no longer kept."""
        kept = self._kept
        if kept is None or kept.scene_request != scene_request:
            return None
        self._forget()
        return kept

    def _forget(self) -> None:
        self._kept = None
        if self._timer:
            self._timer.cancel()


def _worker(
    kept: SceneSpokeSource | None, make: Callable[[Progress], SceneSpokeSource], note: Callable[[SceneOutline], None],
    progress: Progress, begin: Begin,
) -> SpokeWorker:  # fmt: skip
    """Returns a scene that has computed its first spokes: the one that was kept, or where that has died meanwhile another."""
    if kept:
        progress.ends_with(kept.close)
        note(kept.info.scene)
        with contextlib.suppress(SpokeSourceFault):
            return _first_spokes(kept, progress, begin)
    spoke_source = make(progress)
    try:
        note(spoke_source.info.scene)
        return _first_spokes(spoke_source, progress, begin)
    except BaseException:
        spoke_source.close()
        raise


def _first_spokes(spoke_source: SceneSpokeSource, progress: Progress, begin: Begin) -> SpokeWorker:
    progress.stage("computing the first spokes")
    scan, commands = begin(spoke_source)
    return prepared(spoke_source, scan, commands=commands)

"""Selects the spoke source that runs: the present one, the one that replaces it, and a new one after a failure."""

import contextlib
import math
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

from radar_service.processes.call import Progress
from radar_service.service.radio.scene_process import SpokeWorker, prepared
from radar_service.service.scene_request import MakeSpokeSource, SceneRequest, SceneSpokeSource, Spared
from radar_service.service.spokes import new_epoch_name
from radar_service.spoke_source import SpokeSourceFault

SPARE_TIMEOUT = 5.0  # s that a spare may take to its first spokes; it takes a tenth


class WorkerSupervisor:
    """The worker that runs, the worker that replaces it next, and the restart of a failed spoke source.

    switch_to, pending, pending_spoke_source and stop may be called from any thread, the rest from the transmitter's. `worker` is
    replaced by the transmitter's thread alone.
    """

    def __init__(
        self, source: SceneSpokeSource | SpokeWorker, make_spoke_source: MakeSpokeSource,
        lock: AbstractContextManager[Any] | None = None,
    ) -> None:  # fmt: skip
        """lock: guards the pending worker and the replacement of `worker`. It is reentrant; commands are carried out under it."""
        self.worker = source if isinstance(source, SpokeWorker) else SpokeWorker(source)
        self._make_spoke_source = make_spoke_source
        self._lock = lock or threading.RLock()
        self._pending: tuple[str, SpokeWorker] | None = None

    @property
    def pending(self) -> SpokeWorker | None:
        """The worker that waits to take over; None without one."""
        pending = self._pending
        return pending[1] if pending else None

    @property
    def due(self) -> float:
        """Time from which the spokes are those of a worker that waits and goes on with the scene [s]; inf without one."""
        pending = self.pending
        return pending.begins if pending and pending.spoke_source.scene_request.goes_on else math.inf

    @property
    def pending_spoke_source(self) -> SceneSpokeSource:
        """The spoke source that runs next; where none is pending the one that runs."""
        pending = self._pending
        return pending[1].spoke_source if pending else self.worker.spoke_source

    def start(self) -> None:
        """Starts the first spoke source."""
        self.worker.start()

    def stop(self, timeout: float = 0.0) -> None:
        """Ends all spoke sources, and waits for the running one at most `timeout` [s]."""
        pending = self._pending
        if pending:
            pending[1].stop()
        self.worker.stop(timeout)

    def switch_to(self, worker: SpokeWorker) -> str:
        """Lets a prepared spoke source take over next and returns the name of its epoch. The last call wins."""
        with self._lock:
            replaced, self._pending = self._pending, (new_epoch_name(), worker)
            name = self._pending[0]
        if replaced:
            replaced[1].stop()
        return name

    def keep_scene_of(self, scene_request: SceneRequest) -> bool:
        """Whether the running spoke source and the next one are of the same scene as a scene request, at any rate of rotation."""
        return all(
            spoke_source.scene_request.scene_input is scene_request.scene_input
            for spoke_source in (self.worker.spoke_source, self.pending_spoke_source)
        )

    def take_over(self, begin: Callable[[SpokeWorker], None] = lambda worker: None) -> str:
        """Makes the pending spoke source, which there must be, the running one; returns the name of its epoch.

        One that goes on with the scene follows the commands that came while it was prepared. begin: is called with the
        worker, with the lock held.
        """
        with self._lock:
            assert self._pending
            (name, worker), self._pending = self._pending, None
            old = self._replace(worker, follows=worker.spoke_source.scene_request.goes_on)
            begin(worker)
        old.stop()
        worker.tell()
        return name

    def _replace(self, worker: SpokeWorker, follows: bool) -> SpokeWorker:
        """Makes a worker the running one; returns the one before, whose commands it follows or not."""
        with self._lock:
            if follows:
                worker.follow(self.worker.commands)
            old, self.worker = self.worker, worker
        return old

    def restart(self, scan: int) -> None:
        """Replaces a failed spoke source by another one of the same scene, which begins with `scan`. Raises SpokeSourceFault
        where none can be made, or the new one fails, too."""
        source = self.worker.spoke_source
        spare = source.spare() if isinstance(source, Spared) else None
        self.worker.stop()
        try:
            self._replace(self._another(spare, scan), follows=True)
            self.worker.tell()
        except Exception as error:
            raise SpokeSourceFault(str(error)) from error

    def _another(self, spare: SceneSpokeSource | None, scan: int) -> SpokeWorker:
        """Returns a worker of the same scene: of the failed spoke source's spare where that delivers, otherwise of a new
        spoke source."""
        failed = self.worker
        if spare:
            with contextlib.suppress(SpokeSourceFault):
                return prepared(spare, scan, SPARE_TIMEOUT, failed.commands)
        return prepared(self._remade(failed.spoke_source), scan, commands=failed.commands)

    def _remade(self, failed: SceneSpokeSource) -> SceneSpokeSource:
        """Returns another spoke source of the same scene, with its plan. Raises SpokeSourceFault where its file has another
        radar now."""
        spoke_source = self._make_spoke_source(replace(failed.scene_request, plan=failed.info.plan), Progress())
        if spoke_source.info.radar != failed.info.radar:
            spoke_source.close()
            raise SpokeSourceFault("the radar in the scene's file has changed; give the radar the scene again")
        return spoke_source

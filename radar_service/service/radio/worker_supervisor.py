"""Selects the spoke source that runs: the present one, the one that replaces it, and a new one after a failure."""

import contextlib
import math
import threading
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

from radar_service.processes.call import Progress
from radar_service.service.radio.prefetch import SpokeSourceFault, SpokeWorker, prepared
from radar_service.service.scene_request import MakeSpokeSource, SceneRequest, SceneSpokeSource, Spared
from radar_service.service.spokes import new_epoch_name

RESTARTS = 3  # allowed within RESTART_WINDOW
SPARE_TIMEOUT = 5.0  # s that a spare may take to its first spokes; it takes a tenth
RESTART_WINDOW = 60.0  # s: a spoke source that fails more often will fail again


class RestartLimiter:
    """Allows up to `limit` restarts within RESTART_WINDOW."""

    def __init__(self, limit: int, clock: Callable[[], float]) -> None:
        self._limit, self._clock = limit, clock
        self._times: deque[float] = deque()

    def allow(self) -> bool:
        """Counts one more failure; returns whether another spoke source may be started."""
        now = self._clock()
        while self._times and now - self._times[0] > RESTART_WINDOW:
            self._times.popleft()
        self._times.append(now)
        return len(self._times) <= self._limit


class WorkerSupervisor:
    """The worker that runs, the worker that replaces it next, and the restart of a failed spoke source.

    switch_to, pending, pending_spoke_source and stop may be called from any thread, the rest from the transmitter's. `worker` is
    replaced by the transmitter's thread alone.

    restarts: attempts so far to replace a failed spoke source.
    """

    def __init__(
        self, source: SceneSpokeSource | SpokeWorker, make_spoke_source: MakeSpokeSource, limiter: RestartLimiter,
        lock: AbstractContextManager[Any] | None = None,
    ) -> None:  # fmt: skip
        """lock: guards the pending worker and the replacement of `worker`. It is reentrant; commands are carried out under it."""
        self.worker = source if isinstance(source, SpokeWorker) else SpokeWorker(source)
        self.restarts = 0
        self._make_spoke_source, self._limiter = make_spoke_source, limiter
        self._lock = lock or threading.RLock()
        self._pending: tuple[str, SpokeWorker] | None = None
        self._stopping = False

    @property
    def has_pending(self) -> bool:
        """Whether another spoke source waits to take over."""
        return self._pending is not None

    @property
    def pending(self) -> SpokeWorker | None:
        """The worker that waits to take over."""
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
        self._stopping = True
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

    def take_over(self, begin: Callable[[SpokeWorker], None] = lambda worker: None) -> str | None:
        """Makes the pending spoke source the running one; returns the name of its epoch, None where there is none.

        One that goes on with the scene follows the commands that came while it was prepared. begin: is called with the
        worker, with the lock held.
        """
        with self._lock:
            if self._pending is None:
                return None
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

    def restart(self, reason: str, scan: int, report: Callable[[str], None]) -> str | None:
        """Replaces a failed spoke source by another one of the same scene, which begins with `scan`.

        Returns the reason of the last failure; None where the limiter allows no more, another scene is pending or the
        radar stops. report: is called with the reason before each attempt.
        """
        unused = self._spare()
        self.worker.stop()
        try:
            while self._limiter.allow() and not self._stopping and not self.has_pending:
                report(reason)
                self.restarts += 1
                try:
                    spare, unused = unused, None
                    self._replace(self._another(spare, scan), follows=True)
                    self.worker.tell()
                    return reason
                except Exception as error:  # a spoke source that cannot even be made counts as another failure
                    reason = str(error)
            return None
        finally:
            if unused:
                unused.close()

    def _spare(self) -> SceneSpokeSource | None:
        """The spare of the running spoke source, where it has one."""
        spoke_source = self.worker.spoke_source
        return spoke_source.spare() if isinstance(spoke_source, Spared) else None

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

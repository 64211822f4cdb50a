"""Selects the engine that runs: the present one, the one that replaces it, and a new one after a failure."""

import contextlib
import threading
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

from radar_service.processes.call import UNFOLLOWED
from radar_service.service.radio.prefetch import EngineFault, EngineWorker, prepared
from radar_service.service.source import MakeSource, OrderedSource, SceneOrder, Spared
from radar_service.service.spokes import new_epoch_name

RESTARTS = 3  # allowed within RESTART_WINDOW
SPARE_TIMEOUT = 5.0  # s that a spare may take to its first spokes; it takes a tenth
RESTART_WINDOW = 60.0  # s: an engine that fails more often will fail again


class RestartLimiter:
    """Allows up to `limit` restarts within RESTART_WINDOW."""

    def __init__(self, limit: int, clock: Callable[[], float]) -> None:
        self._limit, self._clock = limit, clock
        self._times: deque[float] = deque()

    def allow(self) -> bool:
        """Counts one more failure; returns whether another engine may be started."""
        now = self._clock()
        while self._times and now - self._times[0] > RESTART_WINDOW:
            self._times.popleft()
        self._times.append(now)
        return len(self._times) <= self._limit


class EngineSupervisor:
    """The worker that runs, the worker that replaces it next, and the restart of a failed engine.

    switch_to, pending, pending_engine and stop may be called from any thread, the rest from the transmitter's. `worker` is
    replaced by the transmitter's thread alone.

    restarts: attempts so far to replace a failed engine.
    """

    def __init__(
        self, engine: OrderedSource, make_engine: MakeSource, limiter: RestartLimiter,
        lock: AbstractContextManager[Any] | None = None,
    ) -> None:  # fmt: skip
        """lock: guards the pending worker and the replacement of `worker`. It is reentrant; commands are carried out under it."""
        self.worker = EngineWorker(engine)
        self.restarts = 0
        self._make_engine, self._limiter = make_engine, limiter
        self._lock = lock or threading.RLock()
        self._pending: tuple[str, EngineWorker] | None = None
        self._stopping = False

    @property
    def has_pending(self) -> bool:
        """Whether another engine waits to take over."""
        return self._pending is not None

    @property
    def pending(self) -> EngineWorker | None:
        """The worker that waits to take over."""
        pending = self._pending
        return pending[1] if pending else None

    @property
    def pending_engine(self) -> OrderedSource:
        """The engine that runs next; where none is pending the one that runs."""
        pending = self._pending
        return pending[1].engine if pending else self.worker.engine

    def start(self) -> None:
        """Starts the first engine."""
        self.worker.start()

    def stop(self, timeout: float = 0.0) -> None:
        """Ends all engines, and waits for the running one at most `timeout` [s]."""
        self._stopping = True
        pending = self._pending
        if pending:
            pending[1].stop()
        self.worker.stop(timeout)

    def switch_to(self, worker: EngineWorker) -> str:
        """Lets a prepared engine take over next and returns the name of its epoch. The last call wins."""
        with self._lock:
            replaced, self._pending = self._pending, (new_epoch_name(), worker)
            name = self._pending[0]
        if replaced:
            replaced[1].stop()
        return name

    def keep_scene_of(self, order: SceneOrder) -> bool:
        """Whether the running engine and the next one are of the same scene as an order, at any rate of rotation."""
        return all(engine.order.source is order.source for engine in (self.worker.engine, self.pending_engine))

    def drop_pending(self) -> None:
        """Ends the pending engine, where there is one."""
        with self._lock:
            dropped, self._pending = self._pending, None
        if dropped:
            dropped[1].stop()

    def take_over(self, begin: Callable[[OrderedSource], None] = lambda engine: None) -> str | None:
        """Makes the pending engine the running one; returns the name of its epoch, None where there is none.

        One that goes on with the scene follows the commands that came while it was prepared. begin: is called with the engine,
        with the lock held.
        """
        with self._lock:
            if self._pending is None:
                return None
            (name, worker), self._pending = self._pending, None
            old = self._replace(worker, follows=worker.engine.order.goes_on)
            begin(worker.engine)
        old.stop()
        worker.tell()
        return name

    def _replace(self, worker: EngineWorker, follows: bool) -> EngineWorker:
        """Makes a worker the running one; returns the one before, whose commands it follows or not."""
        with self._lock:
            if follows:
                worker.follow(self.worker.commands)
            old, self.worker = self.worker, worker
        return old

    def restart(self, reason: str, scan: int, report: Callable[[str], None]) -> str | None:
        """Replaces a failed engine by another one of the same scene, which begins with `scan`.

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
                except Exception as error:  # an engine that cannot even be made counts as another failure
                    reason = str(error)
            return None
        finally:
            if unused:
                unused.close()

    def _spare(self) -> OrderedSource | None:
        """The spare of the running engine, where it has one."""
        engine = self.worker.engine
        return engine.spare() if isinstance(engine, Spared) else None

    def _another(self, spare: OrderedSource | None, scan: int) -> EngineWorker:
        """Returns a worker of the same scene: of the failed engine's spare where that delivers, otherwise of a new engine."""
        failed = self.worker
        if spare:
            with contextlib.suppress(EngineFault):
                return prepared(spare, scan, SPARE_TIMEOUT, failed.commands)
        return prepared(self._remade(failed.engine), scan, commands=failed.commands)

    def _remade(self, failed: OrderedSource) -> OrderedSource:
        """Returns another engine of the same scene, with its plan. Raises EngineFault where its file has another radar now."""
        engine = self._make_engine(replace(failed.order, plan=failed.info.plan), UNFOLLOWED)
        if engine.info.radar != failed.info.radar:
            engine.close()
            raise EngineFault("the radar in the scene's file has changed; give the radar the scene again")
        return engine

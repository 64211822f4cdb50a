"""An engine that computes a bounded number of azimuths ahead, in its own thread."""

import threading
from collections import deque
from collections.abc import Callable

from radar_service.records import SpokeBlock
from radar_service.stream.messages import Engine

AZIMUTHS_AHEAD = 128  # under half a second at 24 rpm and 720 azimuths: hides a slow block, and a new scene is not late
BLOCK = 32  # spokes; the most that one message can hold


PREPARE_TIMEOUT = 120.0  # s that an engine may take to its first spokes
RESTARTS = 3  # within
RESTART_WINDOW = 60.0  # s: an engine that dies more often will not do better the next time


class EngineFault(Exception):
    """The engine died. Its text says of what."""


class Ahead:
    """The blocks of one engine, computed ahead of who takes them."""

    def __init__(self, engine: Engine, azimuths: int = AZIMUTHS_AHEAD) -> None:
        self.engine = engine
        self._azimuths = azimuths
        self._blocks: deque[SpokeBlock] = deque()
        self._changed = threading.Condition()
        self._stopping = False
        self._fault: str | None = None
        self._thread = threading.Thread(target=self._run, name="radar engine", daemon=True)

    def start(self) -> None:
        """Begin to compute."""
        self._thread.start()

    def stop(self, timeout: float = 0.0) -> None:
        """Ask the thread to end after the block that it is at, and wait that long for it [s]."""
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        if timeout and self._thread.is_alive():
            self._thread.join(timeout)

    def ready(self, timeout: float | None = None) -> bool:
        """Wait until there is a block to take; False when `timeout` [s] passed. Raises EngineFault when none will come."""
        with self._changed:
            self._changed.wait_for(lambda: self._blocks or self._fault or self._stopping, timeout)
            if self._fault and not self._blocks:
                raise EngineFault(self._fault)
            return bool(self._blocks)

    def take(self, timeout: float) -> SpokeBlock | None:
        """The next block, or None when none came in time [s]. Raises EngineFault after the last one of a dead engine."""
        if not self.ready(timeout):
            return None
        with self._changed:
            block = self._blocks.popleft()
            self._changed.notify_all()
        return block

    def _run(self) -> None:
        try:
            for block in self.engine.blocks(size=BLOCK):
                if not self._hand_over(block):
                    return
            self._fail("the engine ended its stream of spokes")
        except Exception as fault:  # whatever it is, the station must be told
            self._fail(f"{type(fault).__name__}: {fault}")

    def _hand_over(self, block: SpokeBlock) -> bool:
        with self._changed:
            self._blocks.append(block)
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._stopping or sum(map(len, self._blocks)) < self._azimuths)
            return not self._stopping

    def _fail(self, reason: str) -> None:
        with self._changed:
            self._fault = reason
            self._changed.notify_all()


def prepared(engine: Engine, scan: int = 0) -> Ahead:
    """An engine with its first spokes computed, those of `scan`. Raises EngineFault where they do not come."""
    engine.skip_to(scan)
    ahead = Ahead(engine)
    ahead.start()
    if not ahead.ready(PREPARE_TIMEOUT):
        ahead.stop()
        raise EngineFault(f"no spokes after {PREPARE_TIMEOUT:g} s; the scene is too heavy for this machine")
    return ahead


class Deaths:
    """How often engines died lately: up to `limit` times in RESTART_WINDOW is bearable."""

    def __init__(self, limit: int, clock: Callable[[], float]) -> None:
        self._limit, self._clock = limit, clock
        self._times: deque[float] = deque()

    def bearable(self) -> bool:
        """Count one more; whether another engine is worth its while."""
        now = self._clock()
        while self._times and now - self._times[0] > RESTART_WINDOW:
            self._times.popleft()
        self._times.append(now)
        return len(self._times) <= self._limit

"""An engine that computes a bounded number of azimuths ahead, in its own thread."""

import threading
from collections import deque
from collections.abc import Mapping
from typing import Any

from radar_service.cell_sources import SourceRequest
from radar_service.records import SpokeBlock
from radar_service.scene.commands import Command
from radar_service.stream.source import SpokeSource

AZIMUTHS_AHEAD = 128  # under half a second at 24 rpm and 720 azimuths: covers a slow block, and a new scene is not late
BLOCK = 32  # spokes; a message holds no more
PREPARE_TIMEOUT = 120.0  # s that an engine may take to its first spokes


class EngineFault(Exception):
    """The engine failed. The text says why."""


class EngineWorker:
    """Runs one engine in a thread and queues its blocks, at most `azimuths` spokes ahead.

    All methods may be called from any thread. `_changed` guards the queue, the fault and the request to stop.
    """

    def __init__(self, engine: SpokeSource, azimuths: int = AZIMUTHS_AHEAD) -> None:
        self.engine = engine
        self._azimuths = azimuths
        self._blocks: deque[SpokeBlock] = deque()
        self._changed = threading.Condition()
        self._stopping = False
        self._fault: str | None = None
        self.requested = SourceRequest()  # what the spokes are to tell of their sources
        self._requests = self._needed = 0  # how many there were; the last one that a block must follow
        self._thread = threading.Thread(target=self._run, name="radar engine", daemon=True)

    @property
    def is_alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Starts to compute."""
        self._thread.start()

    def stop(self, timeout: float = 0.0) -> None:
        """Ends the engine and its thread, and waits for the thread at most `timeout` [s]."""
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        self.engine.close()
        if timeout and self._thread.is_alive():
            self._thread.join(timeout)

    def wait_until_ready(self, timeout: float | None = None) -> bool:
        """Waits for a block; returns False after `timeout` [s]. Raises EngineFault when none will come."""
        with self._changed:
            self._changed.wait_for(lambda: self._blocks or self._fault or self._stopping, timeout)
            if self._fault and not self._blocks:
                raise EngineFault(self._fault)
            return bool(self._blocks)

    def take(self, timeout: float) -> SpokeBlock | None:
        """Returns the next block, None after `timeout` [s]. Raises EngineFault after the last block of a failed engine."""
        if not self.wait_until_ready(timeout):
            return None
        with self._changed:
            block = self._blocks.popleft()
            self._changed.notify_all()
        return block

    def command(self, spoke: int, body: str | None, values: Mapping[str, Any]) -> Command:
        """Commands the engine from a spoke on; blocks that do not know the command are dropped. Raises CommandError."""
        with self._changed:
            command = self.engine.command(spoke, body, values)
            self._blocks.clear()
            self._changed.notify_all()
        return command

    def request_sources(self, request: SourceRequest, spoke: int) -> bool:
        """Changes what the spokes tell of their sources; returns whether that is more than before.

        All from `spoke` on then come again.
        """
        with self._changed:
            is_more = request | self.requested != self.requested
            self.engine.request_sources(request, spoke if is_more else None)
            self.requested, self._requests = request, self._requests + 1
            if is_more:
                self._needed = self._requests
                self._blocks.clear()
                self._changed.notify_all()
        return is_more

    def _run(self) -> None:
        try:
            for block in self.engine.blocks(size=BLOCK):
                if not self._queue_block(block):
                    return
            self._fail("the engine ended its stream of spokes")
        except EngineFault as error:
            self._fail(str(error))
        except Exception as error:  # of any kind: the transmitter must be notified
            self._fail(f"{type(error).__name__}: {error}")

    def _queue_block(self, block: SpokeBlock) -> bool:
        """Queues a block and waits for room; returns whether to go on."""
        with self._changed:
            if block.commands < len(self.engine.commands) or block.requests < self._needed:
                return not self._stopping  # it comes again
            self._blocks.append(block)
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._stopping or sum(map(len, self._blocks)) < self._azimuths)
            return not self._stopping

    def _fail(self, reason: str) -> None:
        with self._changed:
            self._fault = reason
            self._changed.notify_all()


def prepared(engine: SpokeSource, scan: int = 0, timeout: float = PREPARE_TIMEOUT) -> EngineWorker:
    """Returns a worker that has computed the first spokes of `scan`. Raises EngineFault after `timeout` [s]."""
    engine.skip_to(scan)
    worker = EngineWorker(engine)
    worker.start()
    try:
        if worker.wait_until_ready(timeout):
            return worker
        raise EngineFault(f"no spokes after {timeout:g} s; the scene is too heavy for this machine")
    except EngineFault:
        worker.stop()
        raise

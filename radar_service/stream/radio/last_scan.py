"""The memory of the last scan, from which still pictures are drawn."""

import threading
from collections import deque

import numpy as np
from numpy.typing import NDArray

from radar_service.stream.source import SpokeSource
from radar_service.stream.spokes import Epoch, SpokeBatch

Rows = tuple[NDArray[np.intp], NDArray[np.float32]]


class LastScan:
    """A sink that keeps row numbers and power [W] of the newest revolution. `_lock` guards engine and rows together."""

    def __init__(self, engine: SpokeSource) -> None:
        self._lock = threading.Lock()
        self._engine = engine
        self._rows: deque[Rows] = deque()

    def read(self) -> tuple[SpokeSource, list[Rows]]:
        """Returns the engine, and the rows of its last revolution, oldest first."""
        with self._lock:
            return self._engine, list(self._rows)

    def open_epoch(self, epoch: Epoch) -> None:
        """Drops the rows of another engine; another display range keeps them."""
        with self._lock:
            if epoch.engine is not self._engine:
                self._engine = epoch.engine
                self._rows.clear()

    def send(self, batch: SpokeBatch) -> None:
        """Keeps a batch, and drops what is older than one revolution."""
        block, azimuths = batch.block, batch.epoch.engine.scene.radar.azimuths
        with self._lock:
            self._engine = batch.epoch.engine
            self._rows.append((np.arange(block.index, block.index + len(block)), block.power))
            kept = sum(len(rows) for rows, _ in self._rows)
            while kept - len(self._rows[0][0]) >= azimuths:
                kept -= len(self._rows.popleft()[0])

    def skip(self, epoch: str, count: int, reason: str) -> None:
        """Keeps the rows: older echoes stay in the picture."""

    def close(self, reason: str) -> None:
        """Keeps the rows: the picture stays."""

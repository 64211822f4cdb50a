"""The true readings of the newest spokes, for sensors with latency, where the motion of own ship itself is not known."""

import numpy as np

from radar_service.numerics.types import Floats, Indices
from radar_service.records.reports import Readings

NEVER = -1


class ReadingsHistory:
    """Keeps the readings of the newest `size` spokes. Spokes are added in the order of their numbers."""

    def __init__(self, size: int) -> None:
        self._number = np.full(size, NEVER, dtype=np.int64)
        self._table = np.empty((size, 6))

    def add(self, first: int, readings: Readings) -> None:
        """Keeps the readings of consecutive spokes."""
        number = first + np.arange(len(readings.azimuth))
        rows = number % len(self._number)
        azimuth, heading, position, course, speed = readings
        self._number[rows] = number
        self._table[rows] = np.column_stack([azimuth, heading, position, course, speed])

    def readings(self, number: Indices) -> Readings:
        """Returns the readings of spokes of these numbers (K,); for one that is not kept, of the newest kept before it, or else
        of the oldest kept. At least one is kept."""
        rows = number % len(self._number)
        if not np.array_equal(self._number[rows], number):
            order = np.argsort(self._number, kind="stable")
            kept = order[np.count_nonzero(self._number == NEVER) :]
            rows = kept[np.maximum(np.searchsorted(self._number[kept], number, side="right") - 1, 0)]
        return _readings(self._table[rows])


def _readings(table: Floats) -> Readings:
    return Readings(table[:, 0], table[:, 1], table[:, 2:4], table[:, 4], table[:, 5])

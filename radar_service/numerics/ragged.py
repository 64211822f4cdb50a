"""Rows of unequal lengths in flat arrays."""

from collections.abc import Iterator

import numpy as np

from radar_service.numerics.types import Indices


def spans(first: Indices, last: Indices) -> tuple[Indices, Indices]:
    """Whole numbers from `first` to `last` (exclusive) of each row (N,), one row after the other: row (P,) and number (P,)."""
    count = np.maximum(last - first, 0)
    row = np.repeat(np.arange(len(count)), count)
    return row, np.arange(len(row)) + (first - np.cumsum(count) + count)[row]


def batches(count: Indices, limit: int) -> Iterator[slice]:
    """Runs of rows whose counts (N,) sum to at most `limit`, or of one row that has more."""
    end, begin = np.cumsum(count), 0
    while begin < len(count):
        before = end[begin] - count[begin]
        stop = max(begin + 1, int(np.searchsorted(end, before + limit, side="right")))
        yield slice(begin, stop)
        begin = stop

"""A search among detections that skips most of them: boxes about neighbours, boxes about boxes, and the strongest of each."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Flags, Indices
from radar_service.plots.detections import Detections

FANOUT = 8  # detections in a box, and boxes in a larger one
STRIPE = 256  # spokes whose detections are sorted by range together: sidelobes reach farther in azimuth than in range
TOGETHER = 2048  # queries that search at once, which bounds the memory


@dataclass(frozen=True)
class Boxes:
    """Boxes (B,) about detections. spoke, cell: from and to (2, B); strongest: number of the strongest detection in each."""

    spoke: Indices
    cell: Indices
    strongest: Indices


May = Callable[[Indices, Boxes, Indices], Flags]  # queries (P,), boxes, number of the box of each query (P,)
Does = Callable[[Indices, Indices], Flags]  # queries (P,), a detection for each (P,)


class DetectionTree:
    """Detections, searched by queries that concern strong and near ones."""

    def __init__(self, detections: Detections) -> None:
        order = np.lexsort((detections.cell, detections.spoke // STRIPE))
        self._levels = [Boxes(np.stack([detections.spoke[order]] * 2), np.stack([detections.cell[order]] * 2), order)]
        while len(self._levels[-1].strongest) > FANOUT:
            self._levels.append(_larger(self._levels[-1], detections))

    def any(self, queries: int, may: May, does: Does) -> Flags:
        """Returns whether any detection answers each query (Q,).

        may: whether some detection in a box may answer a query; does: whether a detection answers it.
        """
        parts = [np.arange(first, min(first + TOGETHER, queries)) for first in range(0, queries, TOGETHER)]
        result = np.zeros(queries, dtype=np.bool_)
        for part in parts:
            self._search(part, may, does, result)
        return result

    def _search(self, queries: Indices, may: May, does: Does, result: Flags) -> None:
        """Sets the result of some queries: from the largest boxes to the detections, without queries that are answered."""
        top = len(self._levels[-1].strongest)
        query, box = np.repeat(queries, top), np.tile(np.arange(top), len(queries))
        for level in reversed(range(len(self._levels))):
            boxes = self._levels[level]
            open_ = may(query, boxes, box)
            query, box = query[open_], box[open_]
            result[query[does(query, boxes.strongest[box])]] = True
            if level:
                query, box = query[~result[query]], box[~result[query]]
                below = box[:, None] * FANOUT + np.arange(FANOUT)
                exists = below < len(self._levels[level - 1].strongest)
                query, box = np.broadcast_to(query[:, None], below.shape)[exists], below[exists]


def _larger(boxes: Boxes, detections: Detections) -> Boxes:
    """Boxes about FANOUT boxes each."""
    count = len(boxes.strongest)
    start = np.arange(0, count, FANOUT)
    power = detections.power[boxes.strongest]
    padded = np.concatenate([power, np.full(-count % FANOUT, -1.0)]).reshape(-1, FANOUT)
    return Boxes(
        np.stack([np.minimum.reduceat(boxes.spoke[0], start), np.maximum.reduceat(boxes.spoke[1], start)]),
        np.stack([np.minimum.reduceat(boxes.cell[0], start), np.maximum.reduceat(boxes.cell[1], start)]),
        boxes.strongest[start + padded.argmax(axis=1)],
    )

"""Clusters of detections: cells that touch each other belong together, and a cluster with a deep valley is two."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from radar_service.numerics import Floats, Indices
from radar_service.plots.detections import Detections
from radar_service.plots.groups import Groups

MAX_SPLIT_CELLS = 20_000  # larger clusters are land, which is not split; no more cells are searched for neighbours at once


@dataclass(frozen=True)
class ClusterRule:
    """Which detections belong together.

    spokes, cells: detections at most this far apart along azimuth and along range touch; 1 for neighbours. A valley narrower
    than that is bridged.
    split_db: a cluster is split between two peaks where the power falls this far below the weaker one; inf: never.
    """

    spokes: int = 2
    cells: int = 2
    split_db: float = 9.0

    def __post_init__(self) -> None:
        for name in ("spokes", "cells"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: {getattr(self, name)} is not allowed; 1 or more, best 2")
        if not self.split_db > 0.0:
            raise ValueError(f"split_db: {self.split_db} is not allowed; above 0 dB, best 9, or inf to split nothing")


def clusters(detections: Detections, rule: ClusterRule) -> Indices:
    """Returns the number (C,) of the connected cluster of each detection, from 0.

    Detections of one spoke that follow each other within `cells` are a run. Two runs touch where they lie within `spokes` of
    each other and their ranges, widened by `cells`, overlap: inside a run, no cell is farther than `cells` from a detection.
    """
    if not len(detections):
        return np.empty(0, dtype=np.int64)
    order = np.lexsort((detections.cell, detections.spoke))
    spoke, cell = detections.spoke[order], detections.cell[order]
    begins = np.ones(len(order), dtype=np.bool_)
    begins[1:] = (np.diff(spoke) != 0) | (np.diff(cell) > rule.cells)
    start = np.flatnonzero(begins)
    stop = np.append(start[1:], len(order)) - 1
    pairs = _touching_runs(spoke[start], cell[start], cell[stop], rule)
    label = np.empty(len(order), dtype=np.int64)
    label[order] = np.repeat(_connected(len(start), *pairs.T), stop + 1 - start)
    return label


def _connected(count: int, first: Indices, second: Indices) -> Indices:
    """The number (count,) of the component of each node, by rising first node; first, second: pairs (P,) of nodes that touch."""
    least = np.arange(count)
    while len(first):
        low, high = np.minimum(least[first], least[second]), np.maximum(least[first], least[second])
        apart = low != high
        first, second = first[apart], second[apart]
        np.minimum.at(least, high[apart], low[apart])
        least = _tops(least)
    return np.unique(least, return_inverse=True)[1]


def _touching_runs(spoke: Indices, first: Indices, last: Indices, rule: ClusterRule) -> Indices:
    """Pairs (P, 2) of runs that touch. spoke, first and last cell: of each run (R,), in this order."""
    first, last = first - first.min(), last - first.min()
    stride = int(last.max()) + 2 * rule.cells + 1  # a row of cells in one number: rows do not meet
    row = (spoke - spoke[0]) * stride + rule.cells
    pairs = []
    for apart in range(1, min(rule.spokes, int(spoke[-1] - spoke[0])) + 1):
        lowest = np.searchsorted(row + last, row + apart * stride + first - rule.cells)
        beyond = np.searchsorted(row + first, row + apart * stride + last + rule.cells, side="right")
        count = np.maximum(beyond - lowest, 0)
        within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        pairs.append(np.stack([np.repeat(np.arange(len(row)), count), np.repeat(lowest, count) + within], axis=1))
    return np.concatenate(pairs) if pairs else np.empty((0, 2), dtype=np.int64)


def parts(detections: Detections, cluster: Indices, rule: ClusterRule) -> Indices:
    """Returns the number (C,) of the part of each detection, from 0, by cluster: one part, or several where power falls deep.

    The cells are taken from the strongest to the weakest. A cell without a stronger neighbour begins a part. Where two parts
    meet, they become one unless both have risen `split_db` above the cell where they meet (watershed by prominence).
    cluster: the number of the connected cluster (C,) of each detection.
    """
    if not len(detections):
        return cluster
    level, groups = 10.0 * np.log10(detections.power), Groups(cluster)
    height = groups.maximum(level) - groups.minimum(level)
    hilly = (groups.count > 1) & (groups.count <= MAX_SPLIT_CELLS) & (height >= rule.split_db)
    number = groups.order[groups.start][groups.of_each]  # a part has the number of one of its cells
    for cells in _batches(groups, np.flatnonzero(hilly)):
        pairs = _touching(detections.only(cells), rule)
        pairs = pairs[cluster[cells[pairs[:, 0]]] == cluster[cells[pairs[:, 1]]]]
        number[cells] = cells[_watershed(level[cells], pairs, rule.split_db)]
    return number


def _batches(groups: Groups, which: Indices) -> list[Indices]:
    """The elements of some groups (K,), at most twice MAX_SPLIT_CELLS together."""
    batch = np.cumsum(groups.count[which]) // MAX_SPLIT_CELLS
    first = np.flatnonzero(np.diff(batch, prepend=-1)).tolist()
    parted = np.split(which, first[1:]) if first else []
    return [groups.members(some) for some in parted]


def _touching(detections: Detections, rule: ClusterRule) -> NDArray[np.intp]:
    """Pairs (P, 2) of detections that touch."""
    position = np.stack([detections.spoke / rule.spokes, detections.cell / rule.cells], axis=1)
    return cKDTree(position).query_pairs(1.0 + 1e-9, p=np.inf, output_type="ndarray")


def _watershed(level: Floats, pairs: NDArray[np.intp], split_db: float) -> Indices:
    """The part (C,) of each cell, as the number of the part's strongest cell. level: (C,) [dB]; pairs (P, 2): neighbours."""
    order = np.argsort(-level, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    swapped = rank[pairs[:, 0]] < rank[pairs[:, 1]]
    low, high = np.where(swapped, pairs[:, 1], pairs[:, 0]), np.where(swapped, pairs[:, 0], pairs[:, 1])
    steepest = rank.copy()
    np.minimum.at(steepest, low, rank[high])
    hill = _tops(order[steepest])
    above = _merged(level, *_saddles(hill, rank, low, high), split_db)
    return above[hill]


def _saddles(hill: Indices, rank: Indices, low: Indices, high: Indices) -> tuple[Indices, Indices, Indices]:
    """The highest cell at which each two hills meet, with the hills of it and of its neighbour; (S,) each, from the highest."""
    meet = hill[low] != hill[high]
    low, high = low[meet], high[meet]
    order = np.lexsort((rank[hill[high]], rank[low]))
    low, hill_below, hill_above = low[order], hill[low[order]], hill[high[order]]
    _, first = np.unique(
        np.minimum(hill_below, hill_above) * len(hill) + np.maximum(hill_below, hill_above), return_index=True
    )
    first.sort()
    return low[first], hill_below[first], hill_above[first]


def _merged(level: Floats, saddle: Indices, hill_below: Indices, hill_above: Indices, split_db: float) -> Indices:
    """For each cell (C,), where it is the peak of a hill: the peak of the part of that hill. Later, lower saddles between two
    hills that stay apart do not join them: what rises enough above one rises more above those."""
    heights = level.tolist()
    above = list(range(len(heights)))

    def peak(cell: int) -> int:
        while above[cell] != cell:
            above[cell] = above[above[cell]]
            cell = above[cell]
        return cell

    for cell, first, second in zip(saddle.tolist(), hill_below.tolist(), hill_above.tolist(), strict=True):
        higher, lower = sorted((peak(first), peak(second)), key=heights.__getitem__, reverse=True)
        if higher != lower and heights[lower] - heights[cell] < split_db:
            above[lower] = higher
    return _tops(np.array(above, dtype=np.int64))


def _tops(above: Indices) -> Indices:
    """For each cell (C,) the last one of a chain in which each cell names the next, and the last one itself."""
    while (above[above] != above).any():
        above = above[above]
    return above

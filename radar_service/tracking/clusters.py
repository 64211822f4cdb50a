"""Clusters of detections: cells that touch each other belong together, and a cluster with a deep valley is two."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from radar_service.tracking.detections import Detections
from radar_service.types import Floats, Indices

MAX_SPLIT_CELLS = 20_000  # larger clusters are land, which is not split


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
    """Returns the number (C,) of the connected cluster of each detection, from 0."""
    pairs = _touching(detections, rule)
    count = len(detections)
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64) if count else np.empty(0, np.int64)


def parts(detections: Detections, rule: ClusterRule) -> list[Indices]:
    """Returns the detections of each part of one connected cluster: one part, or several between which power falls deep.

    The cells are taken from the strongest to the weakest. A cell without a stronger neighbour begins a part. Where two parts
    meet, they become one unless both have risen `split_db` above the cell where they meet (watershed by prominence).
    """
    if not 1 < len(detections) <= MAX_SPLIT_CELLS or np.isinf(rule.split_db):
        return [np.arange(len(detections))]
    level = 10.0 * np.log10(detections.power)
    if np.ptp(level) < rule.split_db:  # no valley is that deep
        return [np.arange(len(detections))]
    return groups(_watershed(level, _neighbours(detections, rule), rule.split_db))


def groups(label: Indices) -> list[Indices]:
    """Returns the indices of each label's elements, by label. label: (C,)."""
    order = np.argsort(label, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1) if len(order) else []


def _touching(detections: Detections, rule: ClusterRule) -> NDArray[np.intp]:
    """Pairs (P, 2) of detections that touch."""
    if not len(detections):
        return np.empty((0, 2), dtype=np.intp)
    position = np.stack([detections.spoke / rule.spokes, detections.cell / rule.cells], axis=1)
    pairs: NDArray[np.intp] = cKDTree(position).query_pairs(1.0 + 1e-9, p=np.inf, output_type="ndarray")
    return pairs


def _neighbours(detections: Detections, rule: ClusterRule) -> list[list[int]]:
    result: list[list[int]] = [[] for _ in range(len(detections))]
    for one, other in _touching(detections, rule).tolist():
        result[one].append(other)
        result[other].append(one)
    return result


def _watershed(level: Floats, neighbours: list[list[int]], split_db: float) -> Indices:
    """The part (C,) of each cell, as the number of the part's strongest cell. level: (C,) [dB]."""
    heights = level.tolist()
    above = [-1] * len(heights)  # a stronger cell of the same part, or the cell itself; -1: not taken yet

    def peak(cell: int) -> int:
        while above[cell] != cell:
            above[cell] = above[above[cell]]
            cell = above[cell]
        return cell

    for cell in np.argsort(-level, kind="stable").tolist():
        taken = [other for other in neighbours[cell] if above[other] >= 0]
        if not taken:
            above[cell] = cell
            continue
        above[cell] = peak(max(taken, key=heights.__getitem__))
        for other in taken:
            higher, lower = sorted((peak(cell), peak(other)), key=heights.__getitem__, reverse=True)
            if higher != lower and heights[lower] - heights[cell] < split_db:
                above[lower] = higher
    return np.array([peak(cell) for cell in range(len(heights))], dtype=np.int64)

"""Clusters against a flood fill, and the split of a cluster with a deep valley."""

import numpy as np
import pytest

from radar_service.plots.clusters import ClusterRule, clusters, parts
from radar_service.plots.detections import Detections


def detections(image: np.ndarray) -> Detections:
    """The cells of an image (K, N) above 0 as detections; spokes begin at 100."""
    row, cell = np.nonzero(image > 0)
    power = image[row, cell].astype(np.float64)
    return Detections(
        100 + row, cell, power, np.ones(len(row)), row * 0.1, row * 0.01, np.zeros(len(row)), np.zeros(len(row))
    )


def flooded(image: np.ndarray, spokes: int, cells: int) -> set[frozenset[tuple[int, int]]]:
    """The groups of cells that touch, by a flood fill."""
    left, groups = {(int(r), int(c)) for r, c in zip(*np.nonzero(image > 0), strict=True)}, set()
    while left:
        front, group = [left.pop()], set()
        while front:
            r, c = front.pop()
            group.add((r, c))
            near = {p for p in left if abs(p[0] - r) <= spokes and abs(p[1] - c) <= cells}
            left -= near
            front += near
        groups.add(frozenset(group))
    return groups


@pytest.mark.parametrize(("spokes", "cells"), [(1, 1), (2, 1), (1, 3), (2, 2)])
def test_clusters_are_those_of_a_flood_fill(spokes: int, cells: int) -> None:
    image = (np.random.default_rng(3).random((40, 60)) < 0.12).astype(float)
    some = detections(image)
    label = clusters(some, ClusterRule(spokes, cells))
    mine = {
        frozenset((int(r) - 100, int(c)) for r, c in zip(some.spoke[label == n], some.cell[label == n], strict=True))
        for n in range(label.max() + 1)
    }
    assert mine == flooded(image, spokes, cells) and len(mine) > 5


def test_nothing_has_no_cluster() -> None:
    assert len(clusters(detections(np.zeros((3, 3))), ClusterRule())) == 0


def split_of(hills: Detections, rule: ClusterRule) -> list[np.ndarray]:
    """The detections of each part of one cluster."""
    number = parts(hills, np.zeros(len(hills), dtype=np.int64), rule)
    return [np.flatnonzero(number == one) for one in np.unique(number)]


def two_hills(valley_db: float) -> Detections:
    """Two peaks of 40 and 30 dB with a valley between them, `valley_db` below the lower one."""
    level = np.interp(np.arange(21), [0, 5, 10, 15, 20], [10.0, 40.0, 30.0 - valley_db, 30.0, 10.0])
    return detections(10.0 ** (level[None, :] / 10.0) * np.ones((3, 1)))


def test_a_deep_valley_splits_and_a_shallow_one_does_not() -> None:
    rule = ClusterRule(1, 1, 9.0)
    assert [len(part) for part in split_of(two_hills(8.9), rule)] == [63]
    split = split_of(two_hills(9.1), rule)
    assert len(split) == 2 and sorted(np.concatenate(split)) == list(range(63))
    hills = two_hills(9.1)
    assert [int(hills.cell[part][hills.power[part].argmax()]) for part in split] in ([5, 15], [15, 5])
    assert len(split_of(two_hills(20.0), ClusterRule(1, 1, np.inf))) == 1


def test_three_hills_are_three_parts_however_they_merge() -> None:
    level = np.interp(np.arange(31), [0, 5, 10, 15, 20, 25, 30], [5, 30, 15, 40, 15, 35, 5])
    hills = detections(10.0 ** (level[None, :] / 10.0))
    peaks = {int(hills.cell[part][hills.power[part].argmax()]) for part in split_of(hills, ClusterRule(1, 1, 9.0))}
    assert peaks == {5, 15, 25}


@pytest.mark.parametrize(("spokes", "cells"), [(1, 1), (2, 2), (1, 4)])
def test_parts_are_those_of_a_watershed_cell_by_cell(spokes: int, cells: int) -> None:
    """Rough hills in many clusters, some of which are one detection."""
    rng, rule = np.random.default_rng(8), ClusterRule(spokes, cells, 9.0)
    image = np.where(rng.random((60, 80)) < 0.3, 10.0 ** rng.normal(2.0, 0.8, (60, 80)), 0.0)
    some = detections(image)
    label = clusters(some, rule)
    number = parts(some, label, rule)
    mine = {frozenset(np.flatnonzero(number == one).tolist()) for one in np.unique(number)}
    assert mine == watershed(some, label, rule) and len(mine) > label.max() + 10


def watershed(some: Detections, label: np.ndarray, rule: ClusterRule) -> set[frozenset[int]]:
    """The parts, from the strongest cell to the weakest. Random hills seldom meet by threes, so their order does not matter."""
    level, part = 10 * np.log10(some.power), {}
    for cell in np.argsort(-level, kind="stable").tolist():
        touching = (abs(some.spoke - some.spoke[cell]) <= rule.spokes) & (abs(some.cell - some.cell[cell]) <= rule.cells)
        near = [other for other in np.flatnonzero(touching & (label == label[cell])).tolist() if other in part]
        part[cell] = part[max(near, key=level.__getitem__)] if near else cell
        for other in near:
            low, high = sorted((part[cell], part[other]), key=level.__getitem__)
            if low != high and level[low] - level[cell] < rule.split_db:
                part = {one: high if peak == low else peak for one, peak in part.items()}
    return {frozenset(one for one, its in part.items() if its == peak) for peak in set(part.values())}


def test_clusters_in_any_order_of_detections() -> None:
    some = detections((np.random.default_rng(4).random((30, 30)) < 0.15).astype(float))
    mixed = np.random.default_rng(5).permutation(len(some))
    one, other = clusters(some, ClusterRule()), clusters(some.only(mixed), ClusterRule())
    assert len(set(zip(one[mixed].tolist(), other.tolist(), strict=True))) == one.max() + 1 == other.max() + 1


def test_rubbish_is_refused() -> None:
    with pytest.raises(ValueError, match="spokes: 0 is not allowed"):
        ClusterRule(spokes=0)
    with pytest.raises(ValueError, match="cells: -1 is not allowed"):
        ClusterRule(cells=-1)
    with pytest.raises(ValueError, match="split_db: nan is not allowed"):
        ClusterRule(split_db=float("nan"))

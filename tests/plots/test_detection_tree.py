"""The search among detections against all pairs, and how many pairs it takes."""

import numpy as np
import pytest

from radar_service.numerics.types import Flags, Indices
from radar_service.plots.detection_tree import Boxes, DetectionTree
from radar_service.plots.detections import Detections

REACH = 3


class Near:
    """Queries at detections: whether a stronger one lies within REACH spokes and cells. It counts the pairs it is given."""

    def __init__(self, detections: Detections) -> None:
        self.all, self.pairs = detections, 0

    def may(self, query: Indices, boxes: Boxes, box: Indices) -> Flags:
        self.pairs += len(query)
        near = self.all.power[boxes.strongest[box]] > self.all.power[query]
        for position, interval in ((self.all.spoke, boxes.spoke), (self.all.cell, boxes.cell)):
            near &= (interval[0, box] <= position[query] + REACH) & (interval[1, box] >= position[query] - REACH)
        return near

    def does(self, query: Indices, echo: Indices) -> Flags:
        self.pairs += len(query)
        near = self.all.power[echo] > self.all.power[query]
        for position in (self.all.spoke, self.all.cell):
            near &= np.abs(position[echo] - position[query]) <= REACH
        return near

    def search(self) -> Flags:
        return DetectionTree(self.all).any(len(self.all), self.may, self.does)


def drawn(count: int) -> Detections:
    """Detections at random in 60 range cells, as dense over as many spokes as they take."""
    rng, zero = np.random.default_rng(count), np.zeros(count)
    spoke, cell = rng.integers(0, count // 6 + 1, count), rng.integers(0, 60, count)
    return Detections(spoke, cell, rng.permutation(count) + 1.0, zero, zero, zero, zero, zero)


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 500])
def test_the_search_finds_what_all_pairs_find(count: int) -> None:
    near = Near(drawn(count))
    query, echo = (axis.ravel() for axis in np.mgrid[:count, :count])
    expected = near.does(query, echo).reshape(count, count).any(axis=1)
    assert (near.search() == expected).all() and (count < 500 or 0 < expected.sum() < count)


def test_the_pairs_grow_as_n_log_n() -> None:
    """Four times as many detections take 4 to 4 log(4 n) / log(n) = 4.7 times as many pairs; all pairs would be 16 times."""
    few, many = Near(drawn(3_000)), Near(drawn(12_000))
    few.search(), many.search()
    assert many.pairs < 5.0 * few.pairs and many.pairs < 0.02 * 12_000**2

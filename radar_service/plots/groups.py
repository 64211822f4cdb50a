"""Elements in groups: extremes and sums of each group, computed for all groups at once."""

from functools import cached_property

import numpy as np

from radar_service.numerics import Floats, Indices


class Groups:
    """The groups of elements with equal labels, by label.

    order: elements (C,) sorted by group, in each as they came. start: where groups begin in it (G,). count: of elements (G,).
    """

    def __init__(self, label: Indices) -> None:
        """label: of each element (C,), from 0."""
        self.order = np.argsort(label, kind="stable")
        self.start = np.flatnonzero(np.diff(label[self.order], prepend=-1))
        self.count = np.diff(self.start, append=len(label))

    def __len__(self) -> int:
        return len(self.start)

    @cached_property
    def of_each(self) -> Indices:
        """The group (C,) of each element, from 0."""
        result = np.empty(len(self.order), dtype=np.int64)
        result[self.order] = np.repeat(np.arange(len(self)), self.count)
        return result

    def members(self, groups: Indices) -> Indices:
        """Returns the elements of some groups, one group after the other."""
        count = self.count[groups]
        return np.asarray(
            self.order[np.repeat(self.start[groups] - np.cumsum(count) + count, count) + np.arange(count.sum())]
        )

    def maximum(self, values: Floats) -> Floats:
        """Returns the maximum of each group (G,) of values (C,)."""
        return np.maximum.reduceat(values[self.order], self.start)

    def minimum(self, values: Floats) -> Floats:
        """Returns the minimum of each group (G,) of values (C,)."""
        return np.minimum.reduceat(values[self.order], self.start)

    def total(self, values: Floats) -> Floats:
        """Returns the sum of each group (G,) of values (C,)."""
        return np.add.reduceat(values[self.order], self.start)

    def strongest(self, power: Floats) -> Indices:
        """Returns the element (G,) of the highest power (C,) in each group; the first of equals."""
        ordered = power[self.order]
        positions = np.flatnonzero(ordered == np.repeat(self.maximum(power), self.count))
        return self.order[positions[np.searchsorted(positions, self.start)]]

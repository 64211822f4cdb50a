"""Groups against sums and extremes in a loop."""

import numpy as np

from radar_service.plots.groups import Groups


def test_groups_are_those_of_a_loop() -> None:
    rng = np.random.default_rng(1)
    label = rng.integers(0, 9, 60) * 7
    values = rng.permutation(60).astype(float)
    groups = Groups(label)
    names = sorted(set(label.tolist()))
    assert len(groups) == len(names)
    for number, name in enumerate(names):
        own = np.flatnonzero(label == name)
        assert groups.members(np.array([number])).tolist() == own.tolist() and groups.count[number] == len(own)
        assert (groups.of_each[own] == number).all()
        assert groups.maximum(values)[number] == values[own].max() and groups.minimum(values)[number] == values[own].min()
        assert groups.total(values)[number] == values[own].sum()
        assert groups.strongest(values)[number] == own[values[own].argmax()]


def test_the_first_of_equals_is_the_strongest() -> None:
    assert Groups(np.array([1, 0, 1, 0])).strongest(np.array([5.0, 2.0, 5.0, 2.0])).tolist() == [1, 0]


def test_nothing_has_no_groups() -> None:
    groups = Groups(np.empty(0, dtype=np.int64))
    assert len(groups) == 0 == len(groups.maximum(np.empty(0))) == len(groups.strongest(np.empty(0)))


def test_members_of_some_groups_follow_each_other() -> None:
    groups = Groups(np.array([2, 0, 1, 0, 2, 2]))
    assert groups.members(np.array([2, 0])).tolist() == [0, 4, 5, 1, 3]
    assert groups.members(np.array([], dtype=np.int64)).tolist() == []

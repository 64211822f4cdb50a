"""Readings of several spokes, and sums of what happened to them."""

import numpy as np

from radar_service.records.reports import FeedErrorCounts, Readings

COLUMN = np.arange(4.0)
READINGS = Readings(COLUMN, COLUMN + 10, np.stack([COLUMN, COLUMN + 20], axis=1), COLUMN + 30, COLUMN + 40)


def test_a_part_has_the_rows_of_each_column() -> None:
    part = READINGS.part(slice(1, 3))
    assert [column.tolist() for column in part] == [[1, 2], [11, 12], [[1, 21], [2, 22]], [31, 32], [41, 42]]
    assert READINGS.part(2).position.tolist() == [2, 22] and READINGS.part(2).speed == 42


def test_counts_add_up() -> None:
    one = FeedErrorCounts(dropped=1, repeated=2, late=3, out_of_order=4, stuck=5, heading_lost=6)
    assert one.plus(None) is one
    assert vars(one.plus(one)) == {name: 2 * count for name, count in vars(one).items()}

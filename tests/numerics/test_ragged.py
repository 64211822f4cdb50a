"""Rows of unequal lengths, against loops over them."""

import numpy as np
import pytest

from radar_service.numerics.ragged import batches, spans


@pytest.mark.parametrize("rows", [0, 1, 50])
def test_spans_are_the_numbers_of_each_row(rows: int) -> None:
    """Some rows are empty, and some end before they begin."""
    rng = np.random.default_rng(rows)
    first = rng.integers(-5, 20, rows)
    last = first + rng.integers(-2, 6, rows)
    expected = [(n, k) for n, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)) for k in range(a, b)]
    assert list(zip(*(part.tolist() for part in spans(first, last)), strict=True)) == expected


def test_batches_hold_all_rows_once_and_no_more_than_the_limit() -> None:
    count = np.random.default_rng(1).integers(0, 40, 100)
    count[7] = 500
    parts = list(batches(count, 100))
    assert [n for part in parts for n in range(part.start, part.stop)] == list(range(100))
    assert all(count[part].sum() <= 100 or part.stop == part.start + 1 for part in parts)
    assert all(count[a.start : b.start + 1].sum() > 100 for a, b in zip(parts[:-1], parts[1:], strict=True))
    assert not list(batches(np.zeros(0, dtype=np.int64), 100))
    assert [part.stop for part in batches(np.zeros(3, dtype=np.int64), 100)] == [3]

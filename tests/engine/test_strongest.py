"""The strongest source of each cell."""

import numpy as np

from radar_service.clutter.clutter import ClutterRows
from radar_service.engine.source_numbers import RAIN, SEA
from radar_service.engine.strongest import Strongest


def powers(*rows: list[float]) -> np.ndarray:
    return np.array(rows, dtype=np.float32)


def test_a_source_takes_the_cells_in_which_it_is_stronger() -> None:
    strongest = Strongest(2, 4, 1.0)
    strongest.offer(7, powers([2, 0, 1, 3], [0, 0, 0, 0]))
    strongest.offer(9, powers([4, 4]), np.array([0]), first=2)
    assert strongest.label.tolist() == [[7, 0, 9, 9], [0, 0, 0, 0]] and strongest.label.dtype == np.uint32
    assert strongest.power.tolist() == [[2, 1, 4, 4], [1, 1, 1, 1]]


def test_columns_outside_of_the_profile_are_ignored() -> None:
    strongest = Strongest(3, 3, 0.0)
    rows = np.array([0, 2])
    strongest.offer(1, powers([9, 9, 5], [9, 9, 6]), rows, first=-2)
    strongest.offer(2, powers([4, 9], [3, 9]), rows, first=2)
    strongest.offer(3, powers([9], [9]), rows, first=3)
    strongest.offer(4, powers([9], [9]), rows, first=-1)
    assert strongest.label.tolist() == [[1, 0, 2], [0, 0, 0], [1, 0, 2]]
    assert strongest.power.tolist() == [[5, 0, 4], [0, 0, 0], [6, 0, 3]]


def test_a_part_is_a_copy_and_cleared_rows_have_noise_alone() -> None:
    strongest = Strongest(4, 2, 1.0)
    strongest.offer(5, powers([2.0, 0.0], [3.0, 4.0]), np.array([2, 3]))
    part = strongest.part(1, 2)
    assert part.label.tolist() == [[0, 0], [5, 0]] and part.power.tolist() == [[1, 1], [2, 1]]
    part.offer(6, powers([9.0, 9.0]), np.array([1]))
    part.clear(np.array([1]))
    assert part.label.tolist() == [[0, 0], [0, 0]] and part.power.tolist() == [[1, 1], [1, 1]]
    assert strongest.label.tolist() == [[0, 0], [0, 0], [5, 0], [5, 5]]


def test_clutter_is_divided_by_the_local_means_of_sea_and_rain() -> None:
    """Local means of rain 1, 4, 0 W and of the sea 3, 1, 2 W; the speckle has 2, 2 and 0 times these."""
    mean = powers([4, 5, 2])
    field = (np.sqrt(mean) * np.sqrt(powers([2, 2, 0]))).astype(np.complex64)
    clutter = ClutterRows(field, np.sqrt(mean), np.array([1, 4], dtype=np.float32))
    np.testing.assert_allclose(clutter.rain_share, [[0.25, 0.8, 0.0]], rtol=1e-6)
    strongest = Strongest(1, 4, 1.0)
    strongest.offer_clutter(clutter)
    assert strongest.label.tolist() == [[SEA, RAIN, 0, 0]]
    np.testing.assert_allclose(strongest.power, [[6, 8, 1, 1]], rtol=1e-6)

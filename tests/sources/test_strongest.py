"""The strongest source of each cell."""

import numpy as np

from radar_service.clutter.clutter import ClutterRows
from radar_service.sources.numbers import RAIN, SEA
from radar_service.sources.strongest import unlabelled

HIGHEST = 300  # 9 bits, which leave 14 for the power: a part in 16,384


def powers(*rows: list[float]) -> np.ndarray:
    return np.array(rows, dtype=np.float32)


def test_a_source_takes_the_cells_in_which_it_is_stronger() -> None:
    strongest = unlabelled(2, 4, 1.0, HIGHEST)
    strongest.offer(7, powers([2, 0, 0.9, 3], [0, 0, 0, 0]))
    strongest.offer(9, powers([4, 4]), np.array([0]), first=2)
    strongest.offer(300, powers([5], [0.5]), slice(0, 2), first=0)
    assert strongest.labels.tolist() == [[300, 0, 9, 9], [0, 0, 0, 0]] and strongest.labels.dtype == np.uint32
    strongest.offer(8, powers([5.01, 0, 4.01, 3.99], [1.001, 0.999, -0.0, -1.0]))
    assert strongest.labels.tolist() == [[8, 0, 8, 9], [8, 0, 0, 0]]


def test_a_difference_of_a_thousandth_of_a_decibel_decides_among_thousands_of_sources() -> None:
    rng = np.random.default_rng(0)
    power = (rng.exponential(size=(1, 1000)) * 10.0 ** rng.uniform(-30, 5, (1, 1000))).astype(np.float32)
    for first, second in ((4000, 256), (256, 4000)):
        strongest = unlabelled(1, 1000, 0.0, 4000)
        strongest.offer(first, power.copy())
        strongest.offer(second, power * np.float32(1.0015))  # 0.0065 dB: 12 bits of the number leave a part in 2048
        assert (strongest.labels == second).all()


def test_without_noise_cells_without_power_have_no_source() -> None:
    strongest = unlabelled(1, 4, 0.0, HIGHEST)
    strongest.offer(300, powers([0.0, 1e-37, -0.0, 0.0]))
    assert strongest.labels.tolist() == [[0, 300, 0, 0]]


def test_a_part_is_a_copy_and_cleared_rows_have_noise_alone() -> None:
    strongest = unlabelled(4, 2, 1.0, HIGHEST)
    strongest.offer(5, powers([2.0, 0.0], [3.0, 4.0]), np.array([2, 3]))
    part = strongest.part(1, 2)
    assert part.labels.tolist() == [[0, 0], [5, 0]]
    part.offer(6, powers([9.0, 9.0]), np.array([1]))
    part.clear(np.array([1]))
    part.offer(7, powers([0.9, 1.1]), np.array([1]))
    assert part.labels.tolist() == [[0, 0], [0, 7]]
    assert strongest.labels.tolist() == [[0, 0], [0, 0], [5, 0], [5, 5]]


def test_clutter_is_divided_by_the_local_means_of_sea_and_rain() -> None:
    """Local means of rain 1, 4, 0 W and of the sea 3, 1, 2 W; the speckle has 2, 2 and 0 times these."""
    mean = powers([4, 5, 2])
    field = (np.sqrt(mean) * np.sqrt(powers([2, 2, 0]))).astype(np.complex64)
    clutter = ClutterRows(field, np.sqrt(mean), np.array([1, 4], dtype=np.float32))
    np.testing.assert_allclose(clutter.rain_share, [[0.25, 0.8, 0.0]], rtol=1e-6)
    strongest = unlabelled(1, 4, 1.0, HIGHEST)
    strongest.offer_clutter(clutter)
    assert strongest.labels.tolist() == [[SEA, RAIN, 0, 0]]
    strongest.offer(9, powers([5.99, 7.99, 0, 0]))
    assert strongest.labels.tolist() == [[SEA, RAIN, 0, 0]]  # the sea has 6 W, the rain 8
    strongest.offer(9, powers([6.01, 8.01, 0, 0]))
    assert strongest.labels.tolist() == [[9, 9, 0, 0]]


def test_rain_alone_leaves_nothing_to_the_sea() -> None:
    """Not even what rounding leaves of the square of a root."""
    rain = np.linspace(0.1, 10.0, 999, dtype=np.float32)
    clutter = ClutterRows(np.zeros((1, 999), dtype=np.complex64), np.sqrt(rain)[None], rain)
    assert (clutter.rain_share == 1.0).all()

"""The kernel that spreads points on a grid against numpy."""

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.receive.gridding import Kernel, KernelTable, spread, spread_moving
from tests.kernels.both import both


@pytest.mark.parametrize("by_table", [False, True])
@pytest.mark.parametrize("shape", [(40, 300), (3, 300), (40, 4), (1, 1)])
@pytest.mark.parametrize("count", [0, 1, 3000])
def test_grids_are_those_of_numpy(
    count: int, shape: tuple[int, int], by_table: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Past all edges, also of grids smaller than the kernels, in several calls, with gaps between rows; the grid's own rounding
    is 6e-8 of the peak, in as many parts as numpy has: 20 of them."""
    monkeypatch.setattr("radar_service.receive.gridding.POINTS_PER_CALL", 700)

    rng, kernels = np.random.default_rng(count), (Kernel(4, 3.0), Kernel(6, 1.5))
    weights = tuple(KernelTable(kernel.tables()[0]) for kernel in kernels) if by_table else kernels
    row = np.where(
        rng.random(count) < 0.5, rng.uniform(-3.0, 5.0, count), rng.uniform(shape[0] - 5.0, shape[0] + 3.0, count)
    )
    column = rng.uniform(-5.0, shape[1] + 5.0, count)
    amplitude = rng.normal(size=count) + 1j * rng.normal(size=count)
    compiled, by_numpy = both(lambda: spread(shape, row, column, amplitude, *weights))
    np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=1.2e-6 * np.abs(by_numpy).max(initial=0.0))
    assert compiled.any() == (count > 0)


@pytest.mark.parametrize("migration", [0.0, 0.001, 0.04, 0.3, 9.0])
@pytest.mark.parametrize("rows, size", [(16, 300), (5, 40), (1, 900), (16, 4)])
def test_moving_points_are_those_of_numpy_to_the_bit(rows: int, size: int, migration: float) -> None:
    """Series of one, two and three terms, in one group of rows and in several, past both ends, on rows shorter than the kernel.
    The sums are in numpy's order; only cells that a point meets twice, where the kernel wraps, are rounded otherwise."""
    rng, count, tables = np.random.default_rng(7), 3500, Kernel(6, 1.5).tables()
    column = rng.uniform(-4.0, size + 4.0, count)
    moved = rng.uniform(-migration, migration, (count, rows)).astype(np.float32)
    amplitude = (rng.normal(size=(count, rows)) + 1j * rng.normal(size=(count, rows))).astype(np.complex64)

    def gridded() -> NDArray[np.complex64]:
        grid = np.zeros((rows, size), dtype=np.complex64)
        spread_moving(grid, column, moved, amplitude, tables)
        return grid

    compiled, by_numpy = both(gridded)
    assert compiled.any()
    if size < 6:
        np.testing.assert_allclose(compiled, by_numpy, rtol=0.0, atol=2e-5 * np.abs(by_numpy).max())
    else:
        np.testing.assert_array_equal(compiled, by_numpy)

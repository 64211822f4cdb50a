"""The Kaiser-Bessel grid against exact transforms."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.receive.gridding import MAX_DIRECT_WEIGHTS, Kernel, KernelTable, spread, spread_moving


@pytest.mark.parametrize(("width", "oversampling", "bound_db"), [(4, 1.5, -55), (6, 1.5, -74), (4, 3.0, -74), (6, 2.0, -90)])
def test_a_gridded_point_has_the_spectrum_of_its_exact_position(width: int, oversampling: float, bound_db: float) -> None:
    """Inside the band the corrected spectrum is a pure exponential. Bounds: docs/engine.md#errors has -61 and -80 dB at 1.5
    for a tapered spectrum; this one is flat to the band's edge, where the kernel is worst (6 dB allowed)."""
    kernel, n = Kernel(width, oversampling), 256
    positions = np.random.default_rng(1).uniform(0, n, 40)
    frequency = np.fft.fftfreq(n)
    band = np.abs(frequency) < 0.5 / oversampling
    errors = []
    for x in positions:
        gridded = np.zeros((1, n), np.complex64)
        spread_moving(gridded, np.array([x]), np.zeros((1, 1), np.float32), np.ones((1, 1), np.complex64), kernel.tables())
        exact = np.exp(-2j * np.pi * frequency * x)
        ratio = np.fft.fft(gridded[0].astype(complex)) / kernel.transform(frequency)
        errors.append(np.mean(np.abs(ratio - exact)[band] ** 2))
    assert 10 * np.log10(np.mean(errors)) < bound_db


@pytest.mark.parametrize("count", [40, 400])
@pytest.mark.parametrize("range_migration", [0.0, 0.0015, 0.03, 0.15, 0.4, 0.9, 7.0])
@pytest.mark.parametrize("drift", [np.linspace(-1, 1, 9) ** 2, np.arange(9) > 6], ids=["smooth", "at once"])
def test_points_that_migrate_are_spread_at_their_new_positions(drift: Floats, range_migration: float, count: int) -> None:
    """Each row's spectrum is that of its own place: -54 dB to the band's edge from the series (REACH), whatever the drift;
    9 rows, so that groups come out uneven; MAX_DIRECT_WEIGHTS lies between the counts."""
    kernel, n = Kernel(6, 1.5), 256
    rng = np.random.default_rng(3)
    positions, amplitude = rng.uniform(0, n, count), rng.normal(size=(count, 9)) + 1j * rng.normal(size=(count, 9))
    drifts = rng.uniform(-range_migration, range_migration, (count, 1)) * drift
    frequency = np.fft.fftfreq(n)
    band = np.abs(frequency) < 0.5 / 1.5
    assert 40 * 9 * 6 < MAX_DIRECT_WEIGHTS < 400 * 9 * 6
    gridded = np.zeros((9, n), np.complex64)
    spread_moving(gridded, positions, drifts.astype(np.float32), amplitude.astype(np.complex64), kernel.tables())
    got = np.fft.fft(gridded.astype(complex), axis=1) / kernel.transform(frequency)
    turns = np.exp(-2j * np.pi * frequency[:, None, None] * (positions[:, None] + drifts))
    exact = np.einsum("fek,ek->kf", turns, amplitude)
    error = np.sum(np.abs(got - exact)[:, band] ** 2) / np.sum(np.abs(exact)[:, band] ** 2)
    assert 10 * np.log10(error) < -54


def test_laying_is_circular_and_linear() -> None:
    """Points near the seam wrap; two points add. Float32 rounding of the grid: 1e-6."""
    rows, columns = Kernel(4, 3.0), Kernel(4, 1.5)
    both = spread((16, 32), np.array([15.9, 3.2]), np.array([31.7, 5.5]), np.array([1.0 + 2j, -1.0]), rows, columns)
    one = spread((16, 32), np.array([15.9 - 16]), np.array([31.7 - 32]), np.array([1.0 + 2j]), rows, columns)
    two = spread((16, 32), np.array([3.2]), np.array([5.5]), np.array([-1.0 + 0j]), rows, columns)
    np.testing.assert_allclose(both, one + two, atol=1e-6)
    assert np.abs(both[[15, 0]][:, [31, 0]]).min() > 0.1


def test_kernel_transform_is_the_transform_of_the_kernel() -> None:
    """Against a fine midpoint sum (4000 steps a sample; error below 1e-6 of the peak)."""
    kernel = Kernel(6, 1.5)
    x = (np.arange(6 * 4000) + 0.5) / 4000 - 3.0
    first, weight = kernel.weights(np.array([0.25]))
    direct = np.i0(kernel.beta * np.sqrt(1 - ((first[0] + np.arange(6) - 0.25) / 3.0) ** 2)) / np.i0(kernel.beta)
    np.testing.assert_allclose(weight[0], direct, rtol=1e-12)
    shape = np.i0(kernel.beta * np.sqrt(1 - (x / 3.0) ** 2)) / np.i0(kernel.beta)
    for frequency in (0.0, 0.2, 0.4):
        expected = np.sum(shape * np.cos(2 * np.pi * frequency * x)) / 4000
        assert kernel.transform(np.array([frequency]))[0] == pytest.approx(expected, abs=1e-6 * shape.sum() / 4000)


def test_tables_spread_points_as_their_kernels_do() -> None:
    """5000 points, in more parts than one, off the edges; the nearest entries of both tables err by -80 dB each."""
    rng, shape = np.random.default_rng(3), (40, 300)
    rows, columns = Kernel(4, 3.0), Kernel(6, 1.5)
    row, column = rng.uniform(4, 36, 5000), rng.uniform(8, 290, 5000)
    amplitude = rng.normal(size=5000) + 1j * rng.normal(size=5000)
    exact = spread(shape, row, column, amplitude, rows, columns)
    tables = KernelTable(rows.tables()[0]), KernelTable(columns.tables()[0])
    own = spread(shape, row, column, amplitude, *tables)
    assert np.sum(np.abs(own - exact) ** 2) < 2e-8 * np.sum(np.abs(exact) ** 2)
    none = np.zeros(0)
    assert not spread(shape, none, none, none.astype(complex), *tables).any()

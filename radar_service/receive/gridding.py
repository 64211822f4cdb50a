"""Gridding: echoes are spread on a regular grid with a short Kaiser-Bessel kernel, so that filters become FFTs.

A point at a fractional position x adds its amplitude, weighted by the kernel, to the `width` samples around x. Dividing the
spectrum by the kernel's transform puts the point back exactly at x, for spectra inside the grid's band (Fessler and Sutton 2003;
Beatty, Nishimura and Pauly 2005).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0

from radar_service.kernels.library import KERNELS
from radar_service.numerics import Complexes, Floats, Indices, Profiles, Singles, kernel_transform, shape_parameter

Tables = tuple[Singles, ...]  # of a kernel, with none, one and two of its derivatives
TABLE_STEPS = 8192  # kernel positions per sample; the nearest entry errs by 1/16384 sample, below -80 dB of the pulse
POINTS_PER_CALL = 65_536  # of the kernel: their weights take 5 MB
MAX_SHORT = 2**15  # rows whose numbers have 16 bits: they sort in a tenth of the time
MAX_DIRECT_WEIGHTS = 18_000  # of all points on all rows; more are faster together (measured, rows of 1600 to 8064 samples)
MAX_SHIFTS = (0.002, 0.05, 0.2)  # samples that series of order 0, 1, 2 may move a point: each errs by about -60 dB


@dataclass(frozen=True)
class Kernel:
    """A Kaiser-Bessel kernel of `width` samples (even) made for a grid oversampled `oversampling` times."""

    width: int
    oversampling: float

    @property
    def beta(self) -> float:
        """The `shape_parameter` of the kernel."""
        return shape_parameter(self.width, self.oversampling)

    def weights(self, x: Floats) -> tuple[Indices, Floats]:
        """First sample (E,) and weights (E, width) of points at positions x (E,) [samples]."""
        first = np.floor(x).astype(np.int64) - (self.width // 2 - 1)
        offset = (first - x)[:, None] + np.arange(self.width)
        return first, self._value(offset)

    def tables(self) -> Tables:
        """Weights for fractions 0 to 1 of a sample past floor(x), with derivatives by the position [per sample] up to the order
        of each table, (TABLE_STEPS + 1, order + 1, width)."""
        fraction = np.linspace(0.0, 1.0, TABLE_STEPS + 1)
        value = self._value(np.arange(self.width) - (self.width // 2 - 1) - fraction[:, None])
        slope = np.gradient(value, fraction, axis=0, edge_order=2)
        curve = np.gradient(slope, fraction, axis=0, edge_order=2)
        derivatives = np.stack([value, slope, curve], axis=1).astype(np.float32)
        return tuple(np.ascontiguousarray(derivatives[:, : order + 1]) for order in range(3))

    def transform(self, frequency: Floats) -> Floats:
        """The kernel's Fourier transform at `frequency` [cycles per sample]."""
        return kernel_transform(frequency, self.width, self.beta)

    def _value(self, offset: Floats) -> Floats:
        inside = np.clip(1.0 - (2.0 * offset / self.width) ** 2, 0.0, None)
        value = i0(self.beta * np.sqrt(inside)) / i0(self.beta)
        return np.where(np.abs(offset) <= self.width / 2, value, 0.0)


@dataclass(frozen=True)
class KernelTable:
    """A kernel by its table (TABLE_STEPS + 1, order + 1, width), of any order."""

    table: Singles

    @property
    def width(self) -> int:
        """How many samples it covers."""
        return int(self.table.shape[2])

    def weights(self, x: Floats) -> tuple[Indices, Floats]:
        """First sample (E,) and weights (E, width) of points at positions x (E,) [samples]."""
        entry, first = _entries(x, self.width)
        return first.astype(np.int64), self.table[:, 0].take(entry, axis=0).astype(np.float64)


def spread(
    shape: tuple[int, int],
    row: Floats,
    column: Floats,
    amplitude: Complexes,
    rows: Kernel | KernelTable,
    columns: Kernel | KernelTable,
) -> Profiles:
    """A grid of `shape`, both axes circular, with the amplitudes of points spread by the kernels of rows and of columns.

    row, column: (E,) positions [samples]; amplitude: (E,).
    """
    total = np.zeros(shape, dtype=np.complex64)
    first, low = np.floor(row), float(np.floor(row.min(initial=0.0)))
    short = np.int16 if row.max(initial=0.0) - low < MAX_SHORT else np.int64
    order = np.argsort((first - low).astype(short), kind="stable")  # so that each part is in a band of few rows
    for part in np.array_split(order, max(1, len(order) // POINTS_PER_CALL)) if len(order) else ():
        weights = *rows.weights(row[part]), *columns.weights(column[part])
        taken = *weights, amplitude[part].astype(np.complex128), total.view(np.float32)
        KERNELS.spread_points(len(part), *shape, rows.width, columns.width, *taken)
    return total


def spread_moving(
    rows: Profiles,
    column: Floats,
    range_migration: Singles,
    amplitude: Profiles,
    tables: Tables,
) -> None:
    """Spreads points (E,) that migrate from row to row on rows (K, size), circular and contiguous, which are 0 before.

    column: (E,) positions [samples]; range_migration: (E, K) from there [samples]; amplitude: (E, K). Few points are spread
    directly. For many, a Taylor series of the kernel shifts each point; its order is the cheapest for the maximum migration,
    or for that of the longest step between two rows. Where the migration exceeds MAX_SHIFTS, rows form groups, each about its
    middle row. The compiled kernel adds in the same order.
    """
    if amplitude.size * tables[0].shape[2] <= MAX_DIRECT_WEIGHTS:
        _spread_direct(rows, column[:, None] + range_migration, amplitude, tables[0][:, 0])
        return
    count, size = rows.shape
    longest = float(np.abs(range_migration).max(initial=0.0))
    step = float(np.abs(np.diff(range_migration, axis=1)).max(initial=0.0))
    order, groups = _series(max(longest, step * (count - 1) / 2.0), count)
    points = [np.ascontiguousarray(values) for values in (column, range_migration, amplitude)]
    points[2] = points[2].view(np.float32)
    for part in np.array_split(np.arange(count), groups):
        middle = -1 if groups == 1 else int(part[0] + part[-1]) // 2
        about = int(part[0]), int(part[-1]) + 1, middle, *tables[order].shape[1:], TABLE_STEPS
        KERNELS.spread_series(len(column), count, size, *about, *points, tables[order], rows.view(np.float32))


def _spread_direct(rows: Profiles, position: Floats, amplitude: Profiles, table: Singles) -> None:
    """Adds points (E, K) at positions [samples] to rows (K, size), each by itself."""
    size, width = rows.shape[1], table.shape[1]
    entry, first = _entries(position, width)
    cells = first[:, :, None] + np.arange(width, dtype=np.int64)
    if first.min(initial=0) < 0 or first.max(initial=0) + width > size:
        cells %= size
    cells += np.arange(0, rows.size, size)[:, None]
    weighted = table.take(entry, axis=0) * amplitude[:, :, None]
    np.add.at(rows.reshape(-1, copy=False), cells.ravel(), weighted.ravel())  # flat: a tenth of the time of two indices


def _entries(position: Floats, width: int) -> tuple[NDArray[np.intp], NDArray[np.int32]]:
    """The entry of a kernel's table for positions (...) [samples], and the first of its `width` samples."""
    floor = np.floor(position)
    entry = ((position - floor) * TABLE_STEPS + 0.5).astype(np.intp)
    return entry, floor.astype(np.int32) - (width // 2 - 1)


def _series(range_migration: float, rows: int) -> tuple[int, int]:
    """Order of the series and number of groups of rows that keep MAX_SHIFTS at minimum cost.

    range_migration: maximum of all points [samples].
    """
    choices = [(order, min(rows, int(np.ceil(range_migration / shift)) or 1)) for order, shift in enumerate(MAX_SHIFTS)]
    order, groups = min(choices, key=lambda choice: _cost(choice[0], choice[1], rows))
    return (order, groups) if groups < rows else (0, rows)


def _cost(order: int, groups: int, rows: int) -> int:
    """Cost of a series in products of all points with one row.

    The first matrix of a group costs 16, each further one 6 (measured with 13 000 points, 6 wide).
    """
    return rows * (order + 1) + groups * (16 + 6 * order)

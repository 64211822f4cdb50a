"""Azimuth rows of the Gaussian field from which sea texture is made, at the time when the beam passes over them.

Each multiple k of the waves' period has a field of its own, which drifts with the waves. At a time in between, the two
neighbours are blended by cosine and sine. So the correlation falls to 0 within two periods, and any time can be computed
without the times before. Own ship and antenna only sample the fields.

Near the antenna, rows are lines on the map (`TextureTile`). Where rows lie farther apart than the field correlates, each has
numbers of its own, and stands for its part of the beam.
"""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np
import scipy.fft

from radar_service.block_cache import BlockCache
from radar_service.clutter.azimuth_rows import BLOCK
from radar_service.clutter.texture_law import TextureGains, TextureLaw
from radar_service.clutter.texture_tile import TextureTile
from radar_service.random import TEXTURE, generator, normals
from radar_service.types import Flags, Floats, Indices, Singles

MIN_POWER = 1e-5  # of the maximum; weaker frequencies are not drawn
FIELDS = 3  # kept: those of the two neighbours, and one for slower threads


@dataclass(frozen=True)
class TextureGrid:
    """Where the rows of texture lie, and how they move.

    rows_per_scan: rows of a full circle.
    rotation_period: of the antenna [s].
    step: between columns [m].
    distance: (columns,) ground distance of each column [m].
    lifetime: of the texture [s].
    waves: (2,) velocity of the waves east, north [m/s].
    antenna: positions (J, 2) east, north [m] of the antenna at times (J,) [s].
    """

    rows_per_scan: int
    rotation_period: float
    step: float
    distance: Floats
    lifetime: float
    waves: Floats
    antenna: Callable[[Floats], Floats]


class TextureRows:
    """Real Gaussian rows whose sum, weighted by the beam, has unit variance."""

    def __init__(self, law: TextureLaw, grid: TextureGrid, overlap: Floats, seed: int) -> None:
        """overlap: of the beam's weights, as in `TextureGains`."""
        self.grid = grid
        self._taps = law.taps(grid.step)
        reach, count = len(self._taps) // 2, len(grid.distance)
        self._gains = TextureGains(law, grid.rows_per_scan, grid.step, count, overlap)
        self._tile = TextureTile(law, seed) if self._gains.columns else None
        before = -grid.distance[:reach][::-1] if reach else grid.distance[:0]
        after = grid.distance[-1] + grid.step * np.arange(1, reach + 1)
        self._distance = np.concatenate([before, grid.distance, after])
        self._independent = IndependentRows(law, grid, seed)

    def make(self, scan: int, start: int, stop: int) -> Singles:
        """Rows start to stop (exclusive) of a scan from -1 on, (stop - start, columns)."""
        grid, row = self.grid, np.arange(start, stop)
        time: Floats = np.maximum((scan + row / grid.rows_per_scan) * grid.rotation_period, 0.0)
        field = np.floor(time / grid.lifetime).astype(np.int64)
        blend = 0.5 * np.pi * (time / grid.lifetime - field)
        fields, shares = (field, field + 1), (np.cos(blend).astype(np.float32), np.sin(blend).astype(np.float32))
        first, last = self._gains.zone(start, stop)
        total = np.zeros((stop - start, len(grid.distance)), dtype=np.float32)
        for number, share in zip(fields, shares, strict=True):
            self._independent.add(total[:, first:], number, share, row, time)
        if last:
            near, far = self._gains.rows(start, stop)
            total[:, :last] *= far[:, :last]
            total[:, :last] += near[:, :last] * self._on_map(row, time, fields, shares, last)
        return total

    def _on_map(
        self, row: Indices, time: Floats, fields: tuple[Indices, ...], shares: tuple[Singles, ...], columns: int
    ) -> Singles:
        """The blended fields (J, columns) on the map, summed over the pulse."""
        assert self._tile is not None
        grid, taps = self.grid, self._taps
        outward = outward_unit(row, grid.rows_per_scan)
        antenna, distance = grid.antenna(time), self._distance[: columns + len(taps) - 1]
        total = np.zeros((len(row), len(distance)), dtype=np.float32)
        for field, share in zip(fields, shares, strict=True):
            start = antenna - grid.waves * (time - field * grid.lifetime)[:, None]
            values = self._tile.along_lines(field, start, outward, distance)
            values *= share[:, None]
            total += values
        if len(taps) == 1:
            return total
        parts = [np.float32(tap) * total[:, i : i + columns] for i, tap in enumerate(taps)]
        return np.asarray(np.sum(parts, axis=0))


class IndependentRows:
    """Fields of rows that are independent of each other, for where the beam is wider than the waves are long.

    A field consists of rows around the antenna's position at the field's own time. It drifts with the waves from there: along
    range column by column, across it row by row.
    """

    def __init__(self, law: TextureLaw, grid: TextureGrid, seed: int) -> None:
        self._grid, self._seed = grid, seed
        bearing = np.arange(grid.rows_per_scan) * (2.0 * np.pi / grid.rows_per_scan)
        self._length = np.hypot(law.beam_averaged_length(bearing), law.cell)
        self._size = int(scipy.fft.next_fast_len(len(grid.distance), real=True))
        self._fields: BlockCache[int, _Field] = BlockCache(FIELDS)

    def add(self, total: Singles, field: Indices, share: Singles, row: Indices, time: Floats) -> None:
        """Adds rows (J,) of field numbers (J,), each times its share (J,), to the last columns, `total` (J, n)."""
        grid = self._grid
        moved = grid.antenna(time) - grid.waves * (time - field * grid.lifetime)[:, None]
        moved -= grid.antenna(field * grid.lifetime)
        outward = outward_unit(row, grid.rows_per_scan)
        begin = np.rint(np.einsum("ij,ij->i", moved, outward) / grid.step).astype(np.int64) % self._size
        rows_across = (moved[:, 0] * outward[:, 1] - moved[:, 1] * outward[:, 0]) * grid.rows_per_scan / (2.0 * np.pi)
        count = len(grid.distance)
        begin += count - total.shape[1]
        distance = grid.step * (np.arange(count - total.shape[1], count) + 0.5)
        moving = int(np.searchsorted(distance, 2.0 * np.abs(rows_across).max()))  # beyond, less than half a row
        for number in np.unique(field).tolist():
            its = np.flatnonzero(field == number)
            low, high = its[0], its[-1] + 1  # times rise with the rows
            part = slice(low, high)
            self._add_field(total[part], number, share[part], row[part], begin[part], rows_across[part], distance[:moving])

    def _add_field(
        self,
        total: Singles,
        number: int,
        share: Singles,
        row: Indices,
        begin: Indices,
        rows_across: Floats,
        distance: Floats,
    ) -> None:
        """Adds one field; within `distance` (n,) rows move by whole rows, rows_across (J,) [m] over the distance."""
        field, moving = self._field(number), len(distance)
        if moving:
            across = np.rint(rows_across[:, None] / distance).astype(np.int64)
            across += row[:, None]
            across %= len(self._length)
            values = field.rows(across.min(), across.max() + 1)
            across *= values.shape[1]
            across += begin[:, None] + np.arange(moving)
            total[:, :moving] += share[:, None] * values.ravel().take(across, mode="clip")
        if moving < total.shape[1]:
            values = field.rows(int(row[0]), int(row[-1]) + 1)
            for into, line, first, weight in zip(total[:, moving:], row.tolist(), begin.tolist(), share, strict=True):
                into += weight * values[line, first + moving : first + total.shape[1]]

    def _field(self, number: int) -> "_Field":
        return self._fields.get(number, lambda: _Field(self._length, self._size, self._grid.step, (self._seed, number)))


class _Field:
    """One field, circular along range and repeated once; drawn block by block. Threads wait for each other."""

    def __init__(self, length: Floats, size: int, step: float, key: tuple[int, int]) -> None:
        """length: (rows,) 1/e length of each row [m]; size: columns; step: between them [m]; key: seed and number."""
        self._length, self._size, self._step, self._key = length, size, step, key
        self._rows = np.empty((len(length), 2 * size), dtype=np.float32)
        self._ready: Flags = np.zeros(-(-len(length) // BLOCK), dtype=np.bool_)
        self._lock = Lock()

    def rows(self, low: int, high: int) -> Singles:
        """All rows (rows, 2 size), of which low to high (exclusive) are drawn."""
        with self._lock:
            for block in range(low // BLOCK, -(-high // BLOCK)):
                if not self._ready[block]:
                    self._draw(block * BLOCK, min((block + 1) * BLOCK, len(self._length)))
                    self._ready[block] = True
        return self._rows

    def _draw(self, start: int, stop: int) -> None:
        seed, number = self._key
        rng = generator(seed, TEXTURE, 1 + number, start)
        frequency = scipy.fft.rfftfreq(self._size, self._step)
        power = np.exp(-((np.pi * self._length[start:stop, None] * frequency) ** 2))
        kept = int(np.count_nonzero(power.max(axis=0) > MIN_POWER))
        power = power[:, :kept]
        spectrum = np.zeros((stop - start, len(frequency)), dtype=np.complex64)
        spectrum[:, :kept] = normals(rng, stop - start, 2 * kept).view(np.complex64)
        whole = 2.0 * power.sum(axis=1, keepdims=True) - power[:, :1]  # both sides; the two ends' variances differ
        spectrum[:, :kept] *= (self._size * np.sqrt(0.5 * power / whole)).astype(np.float32)
        spectrum[:, 0] *= np.float32(np.sqrt(2.0))  # here the imaginary half of the draw is unused
        values = scipy.fft.irfft(spectrum, n=self._size, axis=1)
        self._rows[start:stop, : self._size] = values
        self._rows[start:stop, self._size :] = values


def outward_unit(row: Indices, rows_per_scan: int) -> Floats:
    """Unit vectors (J, 2) east, north along rows (J,)."""
    bearing = row * (2.0 * np.pi / rows_per_scan)
    return np.stack([np.sin(bearing), np.cos(bearing)], axis=1)

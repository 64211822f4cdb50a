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
from typing import NamedTuple

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import as_strided

from radar_service.block_cache import BlockCache
from radar_service.clutter.azimuth_rows import BLOCK
from radar_service.clutter.texture_law import TextureGains, TextureLaw
from radar_service.clutter.texture_tile import TextureTile
from radar_service.random import TEXTURE, generator, normals
from radar_service.types import Flags, Floats, Indices, Singles

MIN_POWER = 1e-5  # of the maximum; weaker frequencies are not drawn
CHUNK = 16  # columns that move across range together
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
        self._outward = outward_units(grid.rows_per_scan)
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
        shares = (np.cos(blend).astype(np.float32), np.sin(blend).astype(np.float32))
        lines = self._lines(row, time, field)
        first, last = self._gains.zone(start, stop)
        total = np.zeros((stop - start, len(grid.distance)), dtype=np.float32)
        for each, share in zip(lines, shares, strict=True):
            self._independent.add(total[:, first:], each, share)
        if last:
            near, far = self._gains.rows(start, stop, last)
            total[:, :last] *= far
            total[:, :last] += near * self._on_map(lines, shares, last)
        return total

    def _lines(self, row: Indices, time: Floats, field: Indices) -> list["Lines"]:
        """The rows in the frames of the earlier and of the later field."""
        grid, outward = self.grid, self._outward[row]
        low = int(field[0])  # times rise with the rows
        antenna = grid.antenna(np.concatenate([time, np.arange(low, int(field[-1]) + 2) * grid.lifetime]))
        now, own = antenna[: len(row)], antenna[len(row) :]
        lines = []
        for number in (field, field + 1):
            start = now - grid.waves * (time - number * grid.lifetime)[:, None]
            lines.append(Lines(row, number, start, start - own[number - low], outward))
        return lines

    def _on_map(self, lines: list["Lines"], shares: tuple[Singles, Singles], columns: int) -> Singles:
        """The blended fields (J, columns) on the map, summed over the pulse."""
        assert self._tile is not None
        taps = self._taps.astype(np.float32)
        distance = self._distance[: columns + len(taps) - 1]
        earlier, total = (self._tile.along_lines(each.field, each.start, each.outward, distance) for each in lines)
        total *= shares[1][:, None]
        earlier *= shares[0][:, None]
        total += earlier
        if len(taps) == 1:
            return total
        summed: Singles = total[:, :columns] * taps[0]
        for i, tap in enumerate(taps[1:], start=1):
            summed += total[:, i : i + columns] * tap
        return summed


class Lines(NamedTuple):
    """Azimuth rows as lines in the frames of fields, which drift with the waves; J rows.

    row, field: (J,) numbers.
    start: (J, 2) position of the antenna east, north [m].
    moved: (J, 2) the same relative to the antenna at the field's own time [m].
    outward: (J, 2) unit vectors.
    """

    row: Indices
    field: Indices
    start: Floats
    moved: Floats
    outward: Floats


class IndependentRows:
    """Fields of rows that are independent of each other, for where the beam is wider than the waves are long.

    A field consists of rows around the antenna's position at the field's own time. It drifts with the waves from there: along
    range column by column, across it row by row.
    """

    def __init__(self, law: TextureLaw, grid: TextureGrid, seed: int) -> None:
        self._grid, self._seed = grid, seed
        rows = grid.rows_per_scan
        bearing = np.arange(rows, dtype=np.float64) * (2.0 * np.pi / rows)
        self._length = np.hypot(law.beam_averaged_length(bearing), law.cell)
        self._size = int(scipy.fft.next_fast_len(len(grid.distance) + CHUNK, real=True))
        self._fields: BlockCache[int, _Field] = BlockCache(FIELDS)

    def add(self, total: Singles, lines: Lines, share: Singles) -> None:
        """Adds rows (J,), each times its share (J,), to the last columns, `total` (J, n)."""
        grid, moved, outward = self._grid, lines.moved, lines.outward
        chunks = -(-total.shape[1] // CHUNK)
        column = len(grid.distance) - total.shape[1] + CHUNK * np.arange(chunks)
        clockwise = moved[:, 0] * outward[:, 1] - moved[:, 1] * outward[:, 0]
        angle = clockwise[:, None] / (grid.step * (column + 0.5 * CHUNK))
        row = np.rint(angle * (grid.rows_per_scan / (2.0 * np.pi))).astype(np.int64)
        row += lines.row[:, None]
        row %= grid.rows_per_scan
        out = np.rint(np.einsum("ij,ij->i", moved, outward) / grid.step).astype(np.int64)
        begin = (column + out[:, None]) % self._size
        edges = [0, *(np.flatnonzero(np.diff(lines.field)) + 1).tolist(), len(row)]
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            values = self._field(int(lines.field[low])).rows(int(row[low:high].min()), int(row[low:high].max()) + 1)
            taken = _runs(values)[row[low:high] * values.shape[1] + begin[low:high]].reshape(high - low, -1)
            taken *= share[low:high, None]
            total[low:high] += taken[:, : total.shape[1]]

    def _field(self, number: int) -> "_Field":
        return self._fields.get(number, lambda: _Field(self._length, self._size, self._grid.step, (self._seed, number)))


class _Field:
    """One field, circular along range, its start repeated; drawn block by block. Threads wait for each other."""

    def __init__(self, length: Floats, size: int, step: float, key: tuple[int, int]) -> None:
        """length: (rows,) 1/e length of each row [m]; size: columns; step: between them [m]; key: seed and number."""
        self._length, self._size, self._step, self._key = length, size, step, key
        self._rows = np.empty((len(length), size + CHUNK), dtype=np.float32)
        self._ready: Flags = np.zeros(-(-len(length) // BLOCK), dtype=np.bool_)
        self._lock = Lock()

    def rows(self, low: int, high: int) -> Singles:
        """All rows (rows, size + CHUNK), of which low to high (exclusive) are drawn."""
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
        self._rows[start:stop, self._size :] = values[:, :CHUNK]


def outward_units(rows_per_scan: int) -> Floats:
    """Unit vectors (rows, 2) east, north along all rows."""
    bearing = np.arange(rows_per_scan, dtype=np.float64) * (2.0 * np.pi / rows_per_scan)
    return np.stack([np.sin(bearing), np.cos(bearing)], axis=1)


def _runs(values: Singles) -> Singles:
    """View (N, CHUNK): the CHUNK values from each one of `values` on, in flat order."""
    return as_strided(values, (values.size - CHUNK + 1, CHUNK), (values.itemsize, values.itemsize), writeable=False)

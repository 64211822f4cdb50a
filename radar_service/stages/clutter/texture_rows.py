"""Azimuth rows of the Gaussian field from which sea texture is made, at the time when the beam passes over them.

Each multiple k of the waves' period has a field of its own, which drifts with the waves. At a time in between, the two
neighbours are blended by cosine and sine. So the correlation falls to 0 within two periods, and any time can be computed
without the times before. Own ship and antenna only sample the fields.

Near the antenna, rows are lines on the map (`PeriodicTexture`). Where rows lie farther apart than the field correlates, each has
numbers of its own, and stands for its part of the beam.

The texture is a Gaussian field on the map, read along lines: one periodic field that all times share, each at another offset.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import as_strided

from radar_service.numerics import TEXTURE, Floats, Indices, ResultCache, Singles, generator, normals
from radar_service.stages.clutter.azimuth_rows import BLOCK, BlockRows
from radar_service.stages.clutter.texture import TextureGains, TextureLaw

SIZE = 1024  # grid points a side, a power of 2; 256 lengths, so 3 km along the wind in sea state 3
PER_LENGTH = 4  # grid points in a 1/e length: the nearest one lengthens the correlation by 1 %
TILT = 0.5 * (np.sqrt(5.0) - 1.0)  # rad between grid and wind, so that no main direction repeats within a few km
# Offset of the next field, of the field's side: the two-dimensional golden ratio, so that no two fields of a run coincide.
OFFSET = np.array([0.7548776662466927, 0.5698402909980532])
_DRAW = 0  # key after TEXTURE; independent rows use 1 and up
MIN_POWER = 1e-5  # of the maximum; weaker frequencies are not drawn
CHUNK = 16  # columns that move across range together
FIELDS = 3  # kept: those of the two neighbours, and one for slower threads


class PeriodicTexture:
    """Periodic Gaussian field of unit power with the correlation of a law; field k is it at its own offset."""

    def __init__(self, law: TextureLaw, seed: int) -> None:
        along = np.array([np.sin(law.wind_from), np.cos(law.wind_from)]) / law.along
        across = np.array([np.cos(law.wind_from), -np.sin(law.wind_from)]) / law.across
        turn = np.array([[np.cos(TILT), -np.sin(TILT)], [np.sin(TILT), np.cos(TILT)]])
        self._grid_from_map = PER_LENGTH * turn @ np.stack([along, across])  # (2, 2), grid steps per metre
        self._field = _periodic_field(seed).ravel()

    def along_lines(self, field: Indices, start: Floats, outward: Floats, distance: Floats) -> Singles:
        """Values (J, N) at `distance` (N,) [m] along lines.

        field: (J,) number; start: (J, 2) in the field's frame east, north [m]; outward: (J, 2) unit vectors.
        """
        begin = start @ self._grid_from_map.T + field[:, None] * OFFSET * SIZE
        slope = (outward @ self._grid_from_map.T).astype(np.float32)
        reach = np.abs(slope).max() * np.abs(distance).max(initial=0.0)
        room = SIZE * np.ceil(reach / SIZE)  # whole periods: no number below 0
        first = (begin % SIZE + room).astype(np.float32)
        index = self._grid_index(first[:, 0], slope[:, 0], distance)
        index *= SIZE
        index += self._grid_index(first[:, 1], slope[:, 1], distance)
        return self._field.take(index, mode="clip")

    def _grid_index(self, first: Singles, slope: Singles, distance: Floats) -> Indices:
        place = slope[:, None] * distance.astype(np.float32)
        place += first[:, None]
        index = place.astype(np.int64)
        index &= SIZE - 1
        return index


def _periodic_field(seed: int) -> Singles:
    """Gaussian field (SIZE, SIZE) of unit power, correlation exp(-r^2) at r lengths."""
    white = normals(generator(seed, TEXTURE, _DRAW), SIZE, SIZE)
    frequency = np.fft.fftfreq(SIZE) * PER_LENGTH  # per length
    amplitude = np.exp(-0.5 * (np.pi * frequency) ** 2).astype(np.float32)
    amplitude /= np.float32(np.mean(amplitude.astype(np.float64) ** 2) ** 0.5)
    spectrum = scipy.fft.rfft2(white)
    spectrum *= amplitude[:, None]
    spectrum *= amplitude[: spectrum.shape[1]]
    return np.asarray(scipy.fft.irfft2(spectrum, overwrite_x=True), dtype=np.float32)


@dataclass(frozen=True)
class TextureGrid:
    """Where the rows of texture lie, and how they move.

    rows_per_scan: rows of a full circle.
    rotation_period: of the antenna [s].
    step: between columns [m].
    distance: (columns,) ground distance of each column [m].
    lifetime: of the texture [s].
    waves: (2,) velocity of the waves east, north [m/s].
    antenna: positions (J, 2 or more) east, north [m] of the antenna at times (J,) [s].
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
        self._tile = PeriodicTexture(law, seed) if self._gains.columns else None
        outward = np.concatenate([grid.distance, grid.distance[-1] + grid.step * np.arange(1, reach + 1)])
        self._distance = np.concatenate([-outward[:reach][::-1], outward])
        self._independent = IndependentRows(law, grid, seed)

    def make(self, scan: int, start: int, stop: int) -> Singles:
        """Rows start to stop (exclusive) of a scan from -1 on, (stop - start, columns)."""
        grid, row = self.grid, np.arange(start, stop)
        turns = scan + row / grid.rows_per_scan
        time: Floats = np.maximum(turns * grid.rotation_period, 0.0)
        lines = self._lines(row, time)
        first, last = self._gains.zone(start, stop)
        total = np.empty((len(row), len(grid.distance)), dtype=np.float32)
        if first < total.shape[1]:
            blended(self._independent.rows(lines, first), lines.share, total[:, first:])
        if last:
            near, far = self._gains.rows(start, stop, last)
            total[:, :first] = 0.0
            total[:, first:last] *= far[:, first:]
            near *= self._on_map(lines, last)
            total[:, :last] += near
        return total

    def _lines(self, row: Indices, time: Floats) -> "TextureLines":
        """The rows (J,) in the frames of the earlier and of the later field."""
        grid = self.grid
        field = np.floor(time / grid.lifetime).astype(np.int64)
        blend = 0.5 * np.pi * (time / grid.lifetime - field)
        low = int(field[0])  # times rise with the rows
        antenna = grid.antenna(np.concatenate([time, np.arange(low, int(field[-1]) + 2) * grid.lifetime]))[:, :2]
        now, own = antenna[: len(row)], antenna[len(row) :]
        number = np.concatenate([field, field + 1])
        start = np.tile(now, (2, 1)) - grid.waves * (np.tile(time, 2) - number * grid.lifetime)[:, None]
        share = np.concatenate([np.cos(blend), np.sin(blend)]).astype(np.float32)
        return TextureLines(np.tile(row, 2), number, share, start, start - own[number - low], self._outward[np.tile(row, 2)])

    def _on_map(self, lines: "TextureLines", columns: int) -> Singles:
        """The blended fields (J, columns) on the map, summed over the pulse."""
        assert self._tile is not None
        taps = self._taps.astype(np.float32)
        distance = self._distance[: columns + len(taps) - 1]
        values = self._tile.along_lines(lines.field, lines.start, lines.outward, distance)
        total = np.empty((len(values) // 2, len(distance)), dtype=np.float32)
        blended(values, lines.share, total)
        if len(taps) == 1:
            return total
        summed: Singles = total[:, :columns] * taps[0]
        for i, tap in enumerate(taps[1:], start=1):
            summed += total[:, i : i + columns] * tap
        return summed


class TextureLines(NamedTuple):
    """Azimuth rows as lines in the frames of fields, which drift with the waves: J rows in the earlier field, then in the later.

    row, field: (2 J,) numbers.
    share: (2 J,) of the field in the row.
    start: (2 J, 2) position of the antenna east, north [m].
    moved: (2 J, 2) the same relative to the antenna at the field's own time [m].
    outward: (2 J, 2) unit vectors.
    """

    row: Indices
    field: Indices
    share: Singles
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
        self._fields: ResultCache[int, BlockRows] = ResultCache(FIELDS)
        self._amplitudes: ResultCache[int, Singles] = ResultCache(-(-rows // BLOCK))

    def rows(self, lines: TextureLines, first: int) -> Singles:
        """Values (2 J, N) in the columns from `first` on."""
        grid, moved, outward = self._grid, lines.moved, lines.outward
        count = len(grid.distance) - first
        column = first + np.arange(0, count, CHUNK)
        clockwise = moved[:, 0] * outward[:, 1] - moved[:, 1] * outward[:, 0]
        rows_over = grid.rows_per_scan / (2.0 * np.pi * grid.step * (column + 0.5 * CHUNK))
        row = np.rint(clockwise[:, None] * rows_over).astype(np.int64)
        row += lines.row[:, None]
        row %= grid.rows_per_scan
        out = np.rint((moved * outward).sum(axis=1) / grid.step).astype(np.int64)
        begin = (column + out[:, None]) % self._size
        values = np.empty((*row.shape, CHUNK), dtype=np.float32)
        edges = [0, *(np.flatnonzero(np.diff(lines.field)) + 1).tolist(), len(row)]
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            field = self._field(int(lines.field[low])).known(int(row[low:high].min()), int(row[low:high].max()) + 1)
            values[low:high] = _runs(field)[row[low:high] * field.shape[1] + begin[low:high]]
        return values.reshape(len(row), -1)[:, :count]

    def _field(self, number: int) -> BlockRows:
        return self._fields.get(number, lambda: BlockRows(len(self._length), partial(self._drawn, number)))

    def _drawn(self, number: int, start: int, stop: int) -> Singles:
        """Rows start to stop (exclusive) of a field, circular along range, their start repeated (stop - start, size + CHUNK)."""
        rng = generator(self._seed, TEXTURE, 1 + number, start)
        amplitude = self._amplitude(start, stop)
        kept = amplitude.shape[1]
        spectrum = np.zeros((stop - start, self._size // 2 + 1), dtype=np.complex64)
        np.multiply(normals(rng, stop - start, 2 * kept).view(np.complex64), amplitude, out=spectrum[:, :kept])
        spectrum[:, 0] *= np.float32(np.sqrt(2.0))  # here the imaginary half of the draw is unused
        values = scipy.fft.irfft(spectrum, n=self._size, axis=1)
        return np.concatenate([values, values[:, :CHUNK]], axis=1, dtype=np.float32)

    def _amplitude(self, start: int, stop: int) -> Singles:
        """Of the spectra (stop - start, kept) of rows that a field draws together, up to the last frequency that counts."""
        return self._amplitudes.get(start, lambda: self._spectra(self._length[start:stop]))

    def _spectra(self, length: Floats) -> Singles:
        frequency = scipy.fft.rfftfreq(self._size, self._grid.step)
        power = np.exp(-((np.pi * length[:, None] * frequency) ** 2))
        power = power[:, : int(np.count_nonzero(power.max(axis=0) > MIN_POWER))]
        total = 2.0 * power.sum(axis=1, keepdims=True) - power[:, :1]  # both sides; the two ends' variances differ
        amplitude: Singles = (self._size * np.sqrt(0.5 * power / total)).astype(np.float32)
        return amplitude


def outward_units(rows_per_scan: int) -> Floats:
    """Unit vectors (rows, 2) east, north along all rows."""
    bearing = np.arange(rows_per_scan, dtype=np.float64) * (2.0 * np.pi / rows_per_scan)
    return np.stack([np.sin(bearing), np.cos(bearing)], axis=1)


def blended(values: Singles, share: Singles, out: Singles) -> None:
    """Writes rows of the earlier field and of the later, (2 J, N), each times its share (2 J,), summed, to out (J, N)."""
    values *= share[:, None]
    np.add(values[: len(out)], values[len(out) :], out=out)


def _runs(values: Singles) -> Singles:
    """View (N, CHUNK): the CHUNK values from each one of `values` on, in flat order."""
    return as_strided(values, (values.size - CHUNK + 1, CHUNK), (values.itemsize, values.itemsize), writeable=False)

"""Gridded rows of each source by itself, before compression.

Most sources stand in few columns of a row. Where no other source is near, these columns of the rows that the engine has spread
are theirs alone. The others are spread again side by side on one grid, each in a window of its own.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radar_service.echo import BeamWeightedEchoes, Echoes
from radar_service.engine.pipeline import Contributions
from radar_service.engine.preparation import MAX_TILE, Prepared, beam_rows, column
from radar_service.numerics import Flags, Indices, Profiles
from radar_service.records import square_law


class RestingField(NamedTuple):
    """The field of one source at rest. rows: azimuths (R,) of a scan, rising; field: (R, bins) [sqrt(W)]."""

    rows: Indices
    field: Profiles

    def add_to(self, profiles: Profiles, start: int) -> None:
        """Adds it to profiles (K, bins) [sqrt(W)] of the azimuths from `start` on."""
        first, stop = np.searchsorted(self.rows, [start, start + len(profiles)])
        profiles[self.rows[first:stop] - start] += self.field[first:stop]


def resting_numbers(prepared: Prepared, numbers: Indices) -> Indices:
    """The source number (E,) of each echo at rest; numbers: as `source_numbers`."""
    return numbers[prepared.resting.scene_body]


def resting_fields(prepared: Prepared, numbers: Indices, floor: float) -> Iterator[tuple[int, RestingField]]:
    """Number and field of each source at rest; rows whose power stays below `floor` [W] are left out."""
    each = resting_numbers(prepared, numbers)
    for number in np.unique(each).tolist():
        yield number, resting_field(prepared, np.flatnonzero(each == number), floor)


def resting_field(prepared: Prepared, which: Indices, floor: float) -> RestingField:
    """The field of echoes at rest, indices `which` (N,); rows whose power stays below `floor` [W] are left out."""
    every, compression, radar = prepared.resting.echoes, prepared.compression, prepared.scene.radar
    echoes = Echoes(every.range[which], every.azimuth[which], every.amplitude[which])
    first, count = _window(prepared, echoes)
    filtered = beam_rows(prepared.scene, prepared.fidelity, echoes, compression, first, count)
    energy = np.einsum("ij,ij->i", filtered, filtered.conj()).real
    rows = np.flatnonzero(energy * compression.peak_gain**2 > floor)
    field = np.empty((len(rows), radar.bins), dtype=np.complex64)
    for start in range(0, len(rows), MAX_TILE):
        part = rows[start : start + MAX_TILE]
        gridded = np.zeros((len(part), compression.size), dtype=np.complex64)
        gridded[:, first : first + count] = filtered[part]
        field[start : start + MAX_TILE] = compression.profiles(gridded)
    above = square_law(field).max(axis=1, initial=0.0) > floor
    return RestingField(rows[above], field[above])


def _window(prepared: Prepared, echoes: Echoes) -> tuple[int, int]:
    """First and number of the grid columns that the echoes' kernels cover; all of them where kernels wrap or may be clipped."""
    compression, radar = prepared.compression, prepared.scene.radar
    position = column(echoes.range, radar.range_step)
    first = int(np.floor(position.min(initial=0.0 if not len(position) else np.inf))) - compression.kernel.width
    stop = int(np.ceil(position.max(initial=0.0))) + compression.kernel.width + 1
    if radar.eclipsing or first < 0 or stop > compression.size:
        return 0, compression.size
    return first, stop - first


@dataclass(frozen=True)
class WindowedSources:
    """Sources (S,) that stand in windows of their own on one grid.

    number: (S,) source numbers.
    begin: (S,) column of the row at which the window begins.
    at: (S,) column of the grid at which it begins, rising.
    width: (S,) its columns.
    grid: (K, columns), 0 where the radar is blind.
    """

    number: Indices
    begin: Indices
    at: Indices
    width: Indices
    grid: Profiles


@dataclass(frozen=True)
class SourceRows:
    """Gridded rows of sources over the azimuths (K,) of a tile.

    full_rows: rows (K, size) of the sources that have full rows, by source number.
    windows: all others.
    """

    full_rows: dict[int, Profiles]
    windows: tuple[WindowedSources, ...]


def source_rows(prepared: Prepared, record: Contributions, numbers: Indices, full_rows: Collection[int] = ()) -> SourceRows:
    """The echoes of all blocks of a tile by source.

    numbers: as `source_numbers`; full_rows: sources that get full rows. So do those whose columns are not all within a row.
    """
    if record.rows is None:
        return SourceRows({}, ())
    present, index = _sources(record, numbers)
    begin, width = _windows(prepared, record, index, len(present))
    has_full_rows = np.array([number in full_rows for number in present.tolist()]) | _out_of_row(
        prepared, begin, begin + width
    )
    shared = ~has_full_rows & _isolated(begin, begin + width, prepared.compression.size)
    again = np.flatnonzero(~has_full_rows & ~shared)
    at = np.cumsum(np.concatenate([[0], width[again]]))
    shift = np.zeros(len(present), dtype=np.int64)  # from the column of the row to that of the grid
    shift[again] = at[:-1] - begin[again]
    grid = np.zeros((len(record.transmitting), int(at[-1])), dtype=np.complex64)
    rows = {s: np.zeros_like(record.rows) for s in np.flatnonzero(has_full_rows).tolist()}
    start = 0
    for first, stop, echoes in record.echoes:
        of, start = index[start : start + len(echoes.range)], start + len(echoes.range)
        for s in rows:
            spread_echoes(prepared, rows[s][first:stop], echoes.chosen(np.flatnonzero(of == s)))
        if len(again) and len(left := np.flatnonzero(~has_full_rows[of] & ~shared[of])):
            spread_echoes(prepared, grid[first:stop], echoes.chosen(left), shift[of[left]])
    for spread in (grid, *rows.values()):
        spread[~record.transmitting] = 0.0
    alone = np.flatnonzero(shared)[np.argsort(begin[shared])]
    windows = (
        WindowedSources(present[alone], begin[alone], begin[alone], width[alone], record.rows),
        WindowedSources(present[again], begin[again], at[:-1], width[again], grid),
    )
    return SourceRows({int(present[s]): row for s, row in rows.items()}, windows)


def spread_echoes(prepared: Prepared, rows: Profiles, echoes: BeamWeightedEchoes, shift: Indices | int = 0) -> None:
    """Spreads echoes (E,) on rows (K, columns), which are 0 before, `shift` (E,) columns beyond their own."""
    step = prepared.scene.radar.range_step
    migration = echoes.range_migration * np.float32(1.0 / step)
    prepared.compression.spread(rows, column(echoes.range, step) + shift, migration, echoes.amplitude)


def _sources(record: Contributions, numbers: Indices) -> tuple[Indices, Indices]:
    """The numbers (S,) of all sources of a tile, rising, and the index there of the source of each echo, block by block."""
    each = numbers[np.concatenate([echoes.body for _, _, echoes in record.echoes])]
    is_present = np.zeros(int(numbers.max()) + 1, dtype=np.bool_)
    is_present[each] = True
    return np.flatnonzero(is_present), (np.cumsum(is_present) - 1)[each]


def _windows(prepared: Prepared, record: Contributions, index: Indices, count: int) -> tuple[Indices, Indices]:
    """First grid column and columns of the windows that hold all kernels of each source (S,); index: source of all echoes."""
    step, half = prepared.scene.radar.range_step, prepared.compression.kernel.width // 2
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    start = 0
    for _, _, echoes in record.echoes:
        of, start = index[start : start + len(echoes.range)], start + len(echoes.range)
        migration = max(float(echoes.range_migration.max()), -float(echoes.range_migration.min())) / step
        position = column(echoes.range, step)
        runs = np.flatnonzero(np.diff(of, prepend=-1))  # echoes of a body mostly follow each other
        np.minimum.at(low, of[runs], np.minimum.reduceat(position, runs) - migration)
        np.maximum.at(high, of[runs], np.maximum.reduceat(position, runs) + migration)
    begin = np.floor(low).astype(np.int64) - (half - 1)
    return begin, np.floor(high).astype(np.int64) + half + 1 - begin


def _out_of_row(prepared: Prepared, begin: Indices, end: Indices) -> Flags:
    """Whether columns wrap around the row, or are among those behind its end that count as eclipsed too."""
    eclipsing = prepared.compression.eclipsing_filter
    last = prepared.compression.size - (0 if eclipsing is None else eclipsing.before)
    return np.asarray((begin < 0) | (end > last))


def _isolated(begin: Indices, end: Indices, size: int) -> Flags:
    """Whether no other of these windows (S,) on a circular row shares columns with each."""
    order = np.argsort(begin)
    first, last = begin[order], end[order]
    before = np.concatenate([[last.max() - size], np.maximum.accumulate(last)[:-1]])
    after = np.concatenate([first[1:], [first[0] + size]])
    isolated = np.zeros(len(begin), dtype=np.bool_)
    isolated[order] = (first >= np.maximum(before, last.max() - size)) & (last <= np.minimum(after, first[0] + size))
    return isolated

"""Gridded rows of each source by itself, before compression.

Most sources stand in few cells of a row. They are spread side by side on one grid in one go, each in a window of its own.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.engine.preparation import Prepared, column
from radar_service.types import Indices, Profiles

COLUMNS = 64  # windows are as wide as a multiple of so many columns, so that many are transformed together
Block = tuple[int, int, BeamWeightedEchoes]  # first azimuth in the tile, end, and the echoes


@dataclass(frozen=True)
class SourceRows:
    """Gridded rows of sources over the azimuths (K,) of a tile.

    whole: rows (K, size) of the sources that have whole rows, by source number.
    number, begin, width: (S,) of the others, by rising width: source number, first grid column of the window, and its columns.
    grid: (K, sum of widths), their windows side by side.
    """

    whole: dict[int, Profiles]
    number: Indices
    begin: Indices
    width: Indices
    grid: Profiles

    def windows(self) -> Iterator[tuple[Indices, Indices, Profiles]]:
        """For each width: numbers (S,) and first columns (S,) of its sources, and their rows (K, S, columns)."""
        offset = 0
        for width in np.unique(self.width).tolist():
            which = np.flatnonzero(self.width == width)
            end = offset + width * len(which)
            yield self.number[which], self.begin[which], self.grid[:, offset:end].reshape(len(self.grid), len(which), width)
            offset = end


def source_rows(
    prepared: Prepared, blocks: Sequence[Block], numbers: Indices, azimuths: int, whole: Collection[int] | None = None
) -> SourceRows:
    """Spreads the echoes of all blocks of a tile by source.

    numbers: as `source_numbers`; azimuths: of the tile; whole: sources that get whole rows, None for all. So do those whose
    windows would not lie within a row.
    """
    each = [numbers[echoes.body] for _, _, echoes in blocks]
    present, index = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *each]), return_inverse=True)
    begin, width = _windows(prepared, blocks, index, len(present))
    is_whole = (begin < 0) | (begin + width > prepared.compression.size) | np.isin(present, list(whole or ()))
    if whole is None or prepared.scene.radar.eclipsing:
        is_whole[:] = True
    order = np.lexsort((present, width, is_whole))
    cut = order[: np.count_nonzero(~is_whole)]
    shift = np.zeros(len(present), dtype=np.int64)  # from the column of the row to that of the grid
    shift[cut] = np.cumsum([0, *width[cut]])[:-1] - begin[cut]
    grid = np.zeros((azimuths, int(width[cut].sum())), dtype=np.complex64)
    rows: dict[int, Profiles] = {}
    start = 0
    for first, stop, echoes in blocks:
        of, start = index[start : start + len(echoes.range)], start + len(echoes.range)
        if is_whole.any():
            for s in np.flatnonzero(is_whole & (np.bincount(of, minlength=len(present)) > 0)).tolist():
                gridded = rows.setdefault(
                    int(present[s]), np.zeros((azimuths, prepared.compression.size), dtype=np.complex64)
                )
                spread_echoes(prepared, gridded[first:stop], echoes.chosen(np.flatnonzero(of == s)))
            left = np.flatnonzero(~is_whole[of])
            of, echoes = of[left], echoes.chosen(left)
        if len(of):
            spread_echoes(prepared, grid[first:stop], echoes, shift[of])
    return SourceRows(rows, present[cut], begin[cut], width[cut], grid)


def spread_echoes(prepared: Prepared, rows: Profiles, echoes: BeamWeightedEchoes, shift: Indices | int = 0) -> None:
    """Spreads echoes (E,) on rows (K, columns), which are 0 before, `shift` (E,) columns beyond their own."""
    step = prepared.scene.radar.range_step
    migration = echoes.range_migration * np.float32(1.0 / step)
    prepared.compression.spread(rows, column(echoes.range, step) + shift, migration, echoes.amplitude)


def _windows(prepared: Prepared, blocks: Sequence[Block], index: Indices, count: int) -> tuple[Indices, Indices]:
    """First grid column and columns of the windows that hold all kernels of each source (S,); index: source of all echoes."""
    step, width = prepared.scene.radar.range_step, prepared.compression.kernel.width
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    start = 0
    for _, _, echoes in blocks:
        of, start = index[start : start + len(echoes.range)], start + len(echoes.range)
        migration = max(float(echoes.range_migration.max()), -float(echoes.range_migration.min())) / step
        position = column(echoes.range, step)
        np.minimum.at(low, of, position - migration)
        np.maximum.at(high, of, position + migration)
    begin = np.floor(low).astype(np.int64) - width
    columns = np.ceil(high).astype(np.int64) + width + 1 - begin
    return begin, COLUMNS * -(-columns // COLUMNS)

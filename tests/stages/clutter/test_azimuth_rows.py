"""Rows over the turn: the same however they are asked for, and weighted as the beam is."""

import numpy as np
import pytest

from radar_service.numerics.result_cache import Revision
from radar_service.stages.clutter.azimuth_rows import BLOCK, CHUNK, AzimuthRowCache, StaticAzimuthRows, beam_weights


def numbered(turn: int) -> AzimuthRowCache:
    """Rows that hold their own number, counted from the start."""
    return AzimuthRowCache(turn, lambda scan, start, stop: (scan * turn + np.arange(start, stop, dtype=np.float64))[:, None])


@pytest.mark.parametrize("turn", [4, 16, 37, 64, 200, 2 * CHUNK + 5])
def test_any_span_is_there_across_north_and_before_the_start(turn: int) -> None:
    rows = numbered(turn)
    for first in (-3, 0, 5, turn - 1, turn, 3 * turn - 2):
        for count in (1, 7, 2 * turn + 1):
            np.testing.assert_array_equal(rows.span(first, first + count)[:, 0], np.arange(first, first + count))


@pytest.mark.parametrize("turn", [1, 4, 37])
def test_what_is_known_is_the_same_in_every_turn(turn: int) -> None:
    rows = StaticAzimuthRows(np.arange(turn)[:, None])
    for first in (-3, 0, 5, turn - 1, 3 * turn - 2):
        for count in (1, 7, 3 * turn + 1):
            np.testing.assert_array_equal(rows.span(first, first + count)[:, 0], np.arange(first, first + count) % turn)


def test_blocks_are_computed_once_while_they_are_in_use_and_never_cross_north() -> None:
    requested = []

    def make(scan: int, start: int, stop: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        requested.append((scan, start, stop))
        return np.zeros((stop - start, 1))

    half = BLOCK // 2
    rows = AzimuthRowCache(5 * half, make)
    for first in range(0, 50 * half + 1, half):
        rows.span(first, first + 2 * half + half // 2)
    blocks = [(scan, start, min(start + BLOCK, 5 * half)) for scan in range(11) for start in (0, BLOCK, 2 * BLOCK)]
    assert requested == blocks[: len(requested)]
    assert len(requested) == 32  # the last row is in the 32nd block


def test_weights_are_the_pattern_within_reach() -> None:
    """Rows 10 degrees apart, boresights 358 and 361 degrees, reach 25: rows 34 to 38, each weighted by its offset."""
    first, stop, weight = beam_weights(np.deg2rad([358.0, 361.0]), 36, lambda x: 1.0 - np.abs(x), np.deg2rad(25.0))
    assert (first, stop) == (34, 39)
    offset = np.deg2rad([[18, 8, -2, -12, -22], [21, 11, 1, -9, -19]])
    np.testing.assert_allclose(weight, 1.0 - np.abs(offset), rtol=1e-12)
    _, _, cut = beam_weights(np.deg2rad([0.0, 10.0]), 36, np.ones_like, np.deg2rad(10.0))
    np.testing.assert_array_equal(cut, [[1, 1, 1, 0], [0, 1, 1, 1]])


def test_rows_are_made_anew_after_a_change() -> None:
    level, revision = [1.0], Revision()
    rows = AzimuthRowCache(8, lambda scan, start, stop: np.full((stop - start, 1), level[0]), revision=revision)
    assert rows.span(0, 4).tolist() == [[1.0]] * 4
    level[0] = 2.0
    assert rows.span(0, 4).tolist() == [[1.0]] * 4
    revision.change()
    assert rows.span(0, 4).tolist() == [[2.0]] * 4

"""Shares of tiles: the best of all divisions, bodies at cuts counted, by what tiles took."""

import itertools

import numpy as np
import pytest

from radar_service.simulation.tile_shares import NOBODY, TileShares, computed_again, longest, shares


@pytest.mark.parametrize("seed", range(6))
def test_shares_are_the_best_of_all_divisions(seed: int) -> None:
    """Each division of up to 8 tiles among up to 4 processes is tried."""
    random = np.random.default_rng(seed)
    tiles, count = int(random.integers(1, 9)), int(random.integers(1, 5))
    seconds, again = random.exponential(1.0, tiles), random.exponential(1.0, tiles) * (np.arange(tiles) > 0)

    def last(begins: tuple[int, ...]) -> float:
        parts = itertools.pairwise((0, *begins, tiles))
        return max(float(again[first] + seconds[first:stop].sum()) for first, stop in parts)

    divisions = [each for n in range(min(count, tiles)) for each in itertools.combinations(range(1, tiles), n)]
    owners = shares(seconds, again, count)
    assert owners[0] == 0 and set(np.diff(owners)) <= {0, 1} and owners[-1] < count
    assert longest(seconds, again, owners) == pytest.approx(min(map(last, divisions)))
    assert longest(seconds, again, owners) == pytest.approx(last(tuple((np.flatnonzero(np.diff(owners)) + 1).tolist())))


def test_a_body_is_computed_again_where_a_process_begins_within_its_passage() -> None:
    seconds = np.array([1.0, 9.0, 1.0, 1.0, 1.0, 5.0, 1.0, 1.0])
    np.testing.assert_array_equal(computed_again(seconds, 3), [0, 0, 8, 8, 0, 0, 4, 4])
    np.testing.assert_array_equal(computed_again(seconds, 1), np.zeros(8))
    np.testing.assert_array_equal(computed_again(np.ones(4), 9), np.zeros(4))
    np.testing.assert_array_equal(computed_again(seconds, 20), [0, 0, 8, 8, 8, 8, 12, 12])


def test_shares_follow_what_tiles_took() -> None:
    """Two dear tiles of eight, which take a second in all others' hundredth: each process has one of them."""
    cut = TileShares(8, passage=1)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 0, 0, 0, 1, 1, 1, 1])
    assert cut.uneven(2) == 1.0
    for tile in range(8):
        cut.note(tile, 1.0 if tile < 2 else 0.01)
    assert cut.uneven(2) == pytest.approx(2.02 / 1.06)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 1, 1, 1, 1, 1, 1, 1])
    assert cut.uneven(2) == 1.0


def test_what_a_first_tile_takes_more_does_not_count_as_its_own() -> None:
    """A body that begins in tile 3 takes 2 s; who begins with tile 4 computes it once more. A later time counts by half."""
    cut = TileShares(8, passage=3)
    cut.share_out(np.arange(8), 1)
    for tile in range(8):
        cut.note(tile, 3.0 if tile == 3 else 1.0)
    assert cut.uneven(2) == pytest.approx(10.0 / 6.0)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 0, 0, 0, 1, 1, 1, 1])
    cut.note(4, 3.0)
    cut.share_out(np.arange(8), 1)
    assert cut.uneven(2) == pytest.approx(10.0 / 6.0)
    cut.note(0, 3.0)
    assert cut.uneven(2) == pytest.approx(11.0 / 7.0)


def test_tiles_that_nobody_asks_for_have_no_owner() -> None:
    cut = TileShares(6, passage=2)
    cut.share_out(np.array([1, 2, 5]), 3)
    np.testing.assert_array_equal(cut.owners, [NOBODY, 0, 1, NOBODY, NOBODY, 2])

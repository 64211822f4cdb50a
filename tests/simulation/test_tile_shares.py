"""Shares of tiles: the best of all divisions, bodies at cuts counted, by what tiles took."""

import itertools

import numpy as np
import pytest

from radar_service.simulation import tile_shares
from radar_service.simulation.tile_shares import NOBODY, TRIED, TileShares, begins, computed_again, longest, shares


@pytest.mark.parametrize("seed", range(12))
def test_shares_are_the_best_of_all_divisions(seed: int) -> None:
    """Each division of a turn of up to 8 tiles among up to 4 processes is tried."""
    random = np.random.default_rng(seed)
    tiles, count = int(random.integers(1, 9)), int(random.integers(1, 5))
    seconds, again = random.exponential(1.0, tiles), random.exponential(1.0, tiles)

    def last(begins: tuple[int, ...]) -> float:
        parts = zip(begins, (*begins[1:], begins[0] + tiles), strict=True)
        return max(float(again[first] + np.roll(seconds, -first)[: stop - first].sum()) for first, stop in parts)

    divisions = [each for n in range(2, min(count, tiles) + 1) for each in itertools.combinations(range(tiles), n)]
    owners = shares(seconds, again, count)
    begin = np.flatnonzero(begins(owners))
    assert owners[0] == 0 and len(begin) <= count and sorted(owners[begin]) == [*range(len(begin))]
    assert longest(seconds, again, owners) == pytest.approx(min([seconds.sum(), *map(last, divisions)]))
    if len(begin):
        assert longest(seconds, again, owners) == pytest.approx(last(tuple(begin.tolist())))


def test_the_last_tile_and_the_first_one_are_consecutive() -> None:
    """A body that begins with the last tile but one is in the beam up to the first: one process has all three."""
    seconds = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 10.0, 1.0])
    again = computed_again(seconds, 3)
    np.testing.assert_array_equal(again, [9, 0, 0, 0, 0, 0, 0, 9])
    owners = shares(seconds, again, 2)
    np.testing.assert_array_equal(owners, [0, 1, 1, 1, 1, 1, 0, 0])
    assert longest(seconds, again, owners) == 12.0


def test_first_tiles_are_thinned_out_where_there_are_many() -> None:
    """Not each of them is tried as the first one of a process; the shares are within 2 % of even ones."""
    tiles = 6 * TRIED
    owners = shares(np.ones(tiles), np.arange(tiles) % 8.0, 2)
    assert longest(np.ones(tiles), np.arange(tiles) % 8.0, owners) <= 1.02 * tiles / 2


def test_a_body_is_computed_again_where_a_process_begins_within_its_passage() -> None:
    seconds = np.array([1.0, 9.0, 1.0, 1.0, 1.0, 5.0, 1.0, 1.0])
    np.testing.assert_array_equal(computed_again(seconds, 3), [0, 0, 8, 8, 0, 0, 4, 4])
    np.testing.assert_array_equal(computed_again(seconds, 4), [4, 0, 8, 8, 8, 0, 4, 4])
    np.testing.assert_array_equal(computed_again(seconds, 1), np.zeros(8))
    np.testing.assert_array_equal(computed_again(np.ones(4), 9), np.zeros(4))
    np.testing.assert_array_equal(computed_again(seconds, 20), [12, 4, 12, 12, 12, 8, 12, 12])


def test_shares_follow_what_tiles_took() -> None:
    """Two dear tiles of eight, which take a second in all others' hundredth: each process has one of them."""
    cut = TileShares(8, passage=1)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 0, 0, 0, 1, 1, 1, 1])
    assert not cut.end_late(2, 1.0)
    for tile in range(8):
        cut.note(tile, 1.0 if tile < 2 else 0.01)
    assert cut.end_late(2, 1.9) and not cut.end_late(2, 2.02 / 1.03)
    cut.share_out(np.arange(8), 2)
    assert cut.owners[0] != cut.owners[1] and not cut.end_late(2, 1.0)


def test_what_a_first_tile_takes_more_does_not_count_as_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body that begins in tile 3 takes 2 s; who begins with tile 4 computes it once more. A later time counts by a quarter."""
    cut = TileShares(8, passage=3)
    cut.share_out(np.arange(8), 1)
    for tile in range(8):
        cut.note(tile, 3.0 if tile == 3 else 1.0)
    halves = np.arange(8) // 4
    with monkeypatch.context() as patched:
        patched.setattr(tile_shares, "shares", lambda seconds, again, count: halves)
        cut.share_out(np.arange(8), 2)
    assert cut.end_late(2, 1.19) and not cut.end_late(2, 1.21)  # 6 s in place of 5
    cut.note(4, 3.0)
    assert cut.end_late(2, 1.19) and not cut.end_late(2, 1.21)
    cut.share_out(np.arange(8), 2)
    assert not cut.end_late(2, 1.0)
    cut.note(0, 17.0)
    assert cut.end_late(2, 1.0)


def test_the_first_tile_costs_more_in_the_first_scan_alone_where_its_process_has_the_last_one() -> None:
    """A body of 8 s begins in the last tile. Two take 10 / 13 of what one takes, and 14 / 17 where the first tile has 5 s."""
    cut = TileShares(5, passage=2)
    cut.share_out(np.arange(5), 1)
    for tile, seconds in enumerate((1.0, 1.0, 1.0, 1.0, 9.0)):
        cut.note(tile, seconds)
    cut.share_out(np.arange(4), 1)
    cut.share_out(np.arange(5), 2)
    np.testing.assert_array_equal(cut.owners, [0, 1, 1, 1, 0])
    cut.note(0, 9.0)
    assert cut.end_late(1, 0.76) and not cut.end_late(1, 0.78)
    cut.go_on()
    cut.note(0, 17.0)
    assert cut.end_late(1, 0.82) and not cut.end_late(1, 0.83)


def test_tiles_that_nobody_asks_for_have_no_owner() -> None:
    cut = TileShares(6, passage=2)
    cut.share_out(np.array([1, 2, 5]), 3)
    np.testing.assert_array_equal(cut.owners, [NOBODY, 0, 1, NOBODY, NOBODY, 2])

"""Shares of tiles: consecutive ones to each process, as even as tiles allow, by what they took."""

import numpy as np
import pytest

from radar_service.simulation.tile_processes import NOBODY, TileShares, shares


@pytest.mark.parametrize("seed", range(12))
def test_shares_are_consecutive_and_as_even_as_tiles_allow(seed: int) -> None:
    """Each tile belongs to the process in whose share of the time its middle lies, so no share is longer by more than a tile."""
    random = np.random.default_rng(seed)
    tiles, count = int(random.integers(1, 65)), int(random.integers(1, 5))
    seconds = random.exponential(1.0, tiles)
    owners = shares(seconds, count)
    assert owners.min() >= 0 and owners.max() < count and np.all(np.diff(owners) >= 0)
    taken = np.bincount(owners, seconds, count)
    assert np.abs(taken - seconds.sum() / count).max() <= seconds.max() * (1.0 + 1e-9)


def test_tiles_of_unknown_time_are_shared_out_evenly() -> None:
    np.testing.assert_array_equal(shares(np.ones(8), 2), [0, 0, 0, 0, 1, 1, 1, 1])
    np.testing.assert_array_equal(shares(np.ones(7), 3), [0, 0, 1, 1, 1, 2, 2])
    np.testing.assert_array_equal(shares(np.ones(2), 2), [0, 1])


def test_shares_follow_what_tiles_took() -> None:
    """Two dear tiles of eight, which take a second in all others' hundredth: each process has one of them."""
    cut = TileShares(8)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 0, 0, 0, 1, 1, 1, 1])
    assert not cut.are_uneven(2, 1.0)
    for tile in range(8):
        cut.note(tile, 1.0 if tile < 2 else 0.01)
    assert cut.are_uneven(2, 1.9) and not cut.are_uneven(2, 1.91)
    cut.share_out(np.arange(8), 2)
    np.testing.assert_array_equal(cut.owners, [0, 1, 1, 1, 1, 1, 1, 1])
    assert not cut.are_uneven(2, 1.0)


def test_a_later_time_counts_by_a_quarter() -> None:
    """A tile of 1 s counts 2 s after one of 5 s, and 4 s after one more of 10 s: its process has 5 s of 7, in place of 4."""
    cut = TileShares(4)
    cut.share_out(np.arange(4), 2)
    for tile in range(4):
        cut.note(tile, 1.0)
    cut.note(0, 5.0)
    assert not cut.are_uneven(2, 1.0)
    cut.note(0, 10.0)
    assert cut.are_uneven(2, 1.24) and not cut.are_uneven(2, 1.26)


def test_tiles_that_nobody_asks_for_have_no_owner() -> None:
    cut = TileShares(6)
    cut.share_out(np.array([1, 2, 5]), 3)
    np.testing.assert_array_equal(cut.owners, [NOBODY, 0, 1, NOBODY, NOBODY, 2])

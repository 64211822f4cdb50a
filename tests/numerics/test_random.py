"""Streams that depend on seed and key alone, and normal numbers from a table."""

import numpy as np
import pytest
import scipy.stats

from radar_service.numerics.random import generator, name_key, normals


def draws(seed: int, *key: int) -> bytes:
    return generator(seed, *key).integers(0, 2**63, 4).tobytes()


def test_the_same_key_gives_the_same_stream_whatever_was_drawn_in_between() -> None:
    first = draws(3, 1, 2)
    generator(3, 1, 3).normal(size=100)
    assert draws(3, 1, 2) == first


def test_keys_that_differ_in_any_way_give_different_streams() -> None:
    # the last pairs are those that numpy's own zero padding and 32-bit words would merge
    keys = [(0,), (1,), (1, 0), (0, 1), (1, 0, 0), (1, 2), (2, 1), (12,), (2**32,), (0, 2**32), (2**32, 0), (0, 0, 1), ()]
    streams = {draws(7, *key) for key in keys} | {draws(8, *key) for key in keys}
    assert len(streams) == 2 * len(keys)


@pytest.mark.parametrize("key", [(-1,), (2**64,), (0, -5)])
def test_a_key_out_of_bounds_is_refused_with_its_index(key: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=rf"key\[{len(key) - 1}\]: {key[-1]} is not allowed; a whole number from 0"):
        generator(0, *key)


def test_streams_of_neighbouring_keys_are_uncorrelated() -> None:
    many = np.array([generator(0, scan, azimuth).normal(size=1000) for scan in range(10) for azimuth in range(10)])
    correlation = np.corrcoef(many)[np.triu_indices(100, 1)]
    assert np.abs(correlation).max() < 5.2 / np.sqrt(1000)  # 5.2 sigma: 4950 pairs, chance 1e-3 in all


def test_normal_numbers_are_normal() -> None:
    """65,536 slices are finer than what 400 000 draws resolve: Kolmogorov-Smirnov at 1e-4; mean and variance to 5 sigma."""
    numbers = normals(generator(1, 2), 400, 1000)
    assert numbers.shape == (400, 1000) and numbers.dtype == np.float32
    values = numbers.ravel().astype(float)
    assert scipy.stats.kstest(values, "norm").pvalue > 1e-4
    assert abs(values.mean()) < 5 / np.sqrt(values.size) and abs(values.var() - 1) < 5 * np.sqrt(2 / values.size)
    assert np.abs(np.corrcoef(values[:-1], values[1:])[0, 1]) < 5 / np.sqrt(values.size)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (2, 8)])
def test_any_count_of_normal_numbers_can_be_drawn(shape: tuple[int, int]) -> None:
    """Four come from each 64-bit word; the rest of the last word is dropped."""
    numbers = normals(generator(0), *shape)
    assert numbers.shape == shape and np.isfinite(numbers).all()
    np.testing.assert_array_equal(numbers.ravel(), normals(generator(0), 1, 40)[0, : numbers.size])


def test_names_make_keys_that_stay_the_same() -> None:
    """A stored value, so that a scene has the same luck in each version and on each machine; made when names became keys."""
    assert name_key("harbour", "pilot boat") == 9895391009513380443
    keys = {name_key(*names) for names in (("ab", ""), ("a", "b"), ("", "ab"), ("ab",), ("b", "a"), ("\u00e9", ""))}
    assert len(keys) == 6 and all(0 <= key < 2**64 for key in keys)

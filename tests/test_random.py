import numpy as np
import pytest

from radar_service.random import generator


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
def test_a_key_out_of_bounds_is_refused_with_its_place(key: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=rf"key\[{len(key) - 1}\]: {key[-1]} is not allowed; a whole number from 0"):
        generator(0, *key)


def test_streams_of_neighbouring_keys_are_uncorrelated() -> None:
    many = np.array([generator(0, scan, azimuth).normal(size=1000) for scan in range(10) for azimuth in range(10)])
    correlation = np.corrcoef(many)[np.triu_indices(100, 1)]
    assert np.abs(correlation).max() < 5.2 / np.sqrt(1000)  # 5.2 sigma: 4950 pairs, chance 1e-3 in all

"""Profiles of cut rows against those of whole rows."""

import numpy as np
import pytest

from radar_service.engine.range_sidelobes import RangeSidelobes
from radar_service.receive.compression import Compression, compression_for
from tests.scenes import radar

BEGIN, COLUMNS = 500, 64


def rows_of(compression: Compression, level: float) -> tuple[np.ndarray, np.ndarray]:
    """A row with three points, cut and whole. level: amplitude of each."""
    position = np.array([520.3, 527.9, 540.0])
    first, weight = compression.kernel.weights(position)
    whole = np.zeros((1, compression.size), dtype=np.complex64)
    np.add.at(whole[0], (first[:, None] + np.arange(compression.kernel.width)).ravel(), (level * weight).ravel())
    return whole[:, BEGIN : BEGIN + COLUMNS], whole


@pytest.mark.parametrize("level_db", [10, 30, 50, 90])
@pytest.mark.parametrize(
    "pulse", [{"pulse_s": 4e-6}, {"modulation": "none", "pulse_s": 2e-7, "bandwidth_hz": 10e6, "sample_rate_hz": 75e6}]
)
def test_a_cut_profile_is_exact_within_its_reach_and_noise_stands_beyond(pulse: dict[str, float], level_db: float) -> None:
    compression = compression_for(radar(range_max_m=3000, **pulse), 6)
    level = 10.0 ** (level_db / 20.0)
    cut, whole = rows_of(compression, level)
    sidelobes = RangeSidelobes(compression, noise=1.0)
    (reach,) = sidelobes.reach(np.abs(cut).sum(axis=1)).tolist()
    got, expected = sidelobes.profiles(cut, reach)[0], compression.profiles(whole)[0]
    first, stop = max(0, BEGIN - reach), BEGIN + COLUMNS + reach
    inside = expected[first:stop]
    assert len(got) == COLUMNS + 2 * reach
    np.testing.assert_allclose(got[first - BEGIN + reach :][: len(inside)], inside, atol=3e-5 * level)  # single precision
    beyond = np.abs(np.concatenate([expected[:first], expected[stop:]]))
    assert beyond.max(initial=0.0) < max(1.0, 1e-4 * level)


def test_stronger_rows_reach_farther_up_to_the_length_of_the_pulse() -> None:
    compression = compression_for(radar(range_max_m=3000, pulse_s=4e-6), 6)
    reach = RangeSidelobes(compression, noise=1.0).reach(np.array([1.0, 3e2, 1e3, 1e9]))
    assert np.diff(reach).min() > 0 and reach[0] == 16
    assert 300 <= reach[-1] < 350  # 4 us at 75 MSPS, and the tail of the kernel's correction

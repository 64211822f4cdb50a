"""The kernel of skylines against numpy."""

import numpy as np
import pytest

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Floats
from tests.kernels.both import both

AHEAD, TOLERANCE = np.array([0.6, 0.8]), 1e-3


def height(chords: Floats, u: Floats) -> Floats:
    """v at u; NaN where no chord is."""
    over = (chords[:, 0, 0] <= u[:, None]) & (u[:, None] < chords[:, 1, 0])
    v = chords[:, 0, 1] + (u[:, None] - chords[:, 0, 0]) * (np.diff(chords[:, :, 1]) / np.diff(chords[:, :, 0]))[:, 0]
    return np.where(over, v, np.nan).max(axis=1, initial=-np.inf, where=over)


@pytest.mark.parametrize("count", [0, 1, 9, 30])
def test_a_skyline_is_that_of_numpy_within_its_tolerance(count: int) -> None:
    """Triangles about the antenna too, in two groups; chords that find no room are counted."""
    draw = np.random.default_rng(count)
    corners = draw.uniform([-40.0, -5.0, -6.0], [60.0, 90.0, 6.0], (count, 1, 3)) + draw.normal(0.0, 6.0, (count, 3, 3))
    shift = 4.0 * draw.integers(0, 2, count)

    def chords() -> Floats:
        result = np.empty((5000, 2, 2))
        taken = (-0.8, 0.9, -0.3, 0.2, TOLERANCE, AHEAD, corners, shift)
        found = KERNELS.skyline(count, 5000, *taken, result)
        assert KERNELS.skyline(count, 1, *taken, np.empty((1, 2, 2))) == found
        return result[:found]

    compiled, by_numpy = both(chords)
    u = draw.uniform(-0.9, 5.0, 3000)
    found, expected = height(compiled, u), height(by_numpy, u)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(expected))
    some = np.isfinite(expected)
    assert np.abs(found[some] - expected[some]).max(initial=0.0) < TOLERANCE * 1.000001
    assert len(compiled) <= len(by_numpy) and (count < 9 or 0.1 < some.mean() < 0.8)

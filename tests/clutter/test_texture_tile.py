"""The field on the map: normal, of unit power, elliptic, the same along any line, another at each number."""

import numpy as np
import pytest
import scipy.stats
from numpy.typing import NDArray

from radar_service.clutter.texture_law import TextureLaw
from radar_service.clutter.texture_tile import TextureTile

WIND = np.deg2rad(40.0)
TILE = TextureTile(TextureLaw(24.0, 12.0, WIND, 0.0), seed=3)
LEVEL = 1e-4  # of the statistical test; the seed is fixed, so it either always passes or never


def values(start: NDArray[np.float64], bearing: float, distance: NDArray[np.float64], field: int = 0) -> NDArray[np.float64]:
    """Along lines from points (J, 2) at one bearing [rad]."""
    outward = np.tile([np.sin(bearing), np.cos(bearing)], (len(start), 1))
    return TILE.along_lines(np.full(len(start), field), start, outward, distance).astype(np.float64)


def starts(count: int, seed: int = 1) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(-1e5, 1e5, (count, 2))


def test_field_is_normal_with_unit_power() -> None:
    """Points far apart; Kolmogorov-Smirnov, and the variance to 5 sigma of 65,000 / 2 independent patches and of the points."""
    drawn = values(starts(4000), 0.0, np.zeros(1)).ravel()
    assert scipy.stats.kstest(drawn, "norm").pvalue > LEVEL
    drawn = values(starts(300_000), 0.0, np.zeros(1))
    assert np.mean(drawn**2) == pytest.approx(1.0, abs=5 * np.sqrt(2 / 30_000 + 2 / 300_000))


@pytest.mark.parametrize(
    ("off_wind_deg", "length"), [(0, 24.0), (90, 12.0), (45, np.sqrt(2 / (24**-2 + 12**-2))), (135, None)]
)
def test_correlation_is_gaussian_on_the_ellipse(off_wind_deg: float, length: float | None) -> None:
    """exp(-(r / length)^2) at every lag; 0.03: the nearest grid point (1 %) and 5 sigma of 30,000 patches. 135 is as 45."""
    length = length or float(np.sqrt(2 / (24**-2 + 12**-2)))
    lag = length * np.array([0.0, 0.5, 1.0, 1.5, 2.5])
    drawn = values(starts(60_000), WIND + np.deg2rad(off_wind_deg), lag)
    np.testing.assert_allclose(np.mean(drawn * drawn[:, :1], axis=0), np.exp(-((lag / length) ** 2)), atol=0.03)


def test_lines_that_cross_agree_where_they_cross() -> None:
    """A point of the map has one value, whatever line leads there, near or far from the start; but for the rounding of
    float32 to another grid point (5 % of points)."""
    point = starts(2000, 2) / 100
    bearing = np.random.default_rng(3).uniform(0, 2 * np.pi, 2000)
    outward = np.stack([np.sin(bearing), np.cos(bearing)], axis=1)
    far = TILE.along_lines(np.zeros(2000, dtype=np.int64), point - 3000.0 * outward, outward, np.array([3000.0]))
    assert np.mean(far != values(point, 0.0, np.zeros(1))) < 0.05


def test_fields_of_different_numbers_are_independent_at_a_point() -> None:
    """The number moves the tile by many lengths; 5 sigma of the points."""
    at = starts(20_000, 4)
    zero = values(at, 0.0, np.zeros(1), 0)
    for number in (1, 2, 3, 8, 57):
        assert abs(np.mean(zero * values(at, 0.0, np.zeros(1), number))) < 5 / np.sqrt(20_000)

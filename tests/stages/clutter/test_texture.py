"""Random fields of clutter: their laws at stated levels, their correlations against the closed forms."""

import numpy as np
import pytest
import scipy.stats

from radar_service.stages.clutter.texture import SpeckleRows, TextureTable, gamma_from_gaussian, gaussian_correlation

LEVEL = 1e-4  # of each statistical test; seeds are fixed, so a test either always passes or never


def test_speckle_is_complex_gaussian_of_unit_power() -> None:
    """Parts of every 4th bin of a white band are normal with variance 1/2 (Kolmogorov-Smirnov) and independent."""
    rows = SpeckleRows(np.ones(512), 2000, seed=3).make(0, 0, 64)
    assert rows.dtype == np.complex64 and rows.shape == (64, 2000)
    real, imag = (part[:, ::4].ravel() * np.sqrt(2) for part in (rows.real, rows.imag))
    for part in (real, imag):
        assert scipy.stats.kstest(part, "norm").pvalue > LEVEL
    assert abs(np.mean(real * imag)) < 5 / np.sqrt(real.size)
    assert scipy.stats.kstest(real**2 + imag**2, "expon", args=(0, 2)).pvalue > LEVEL


def test_speckle_correlates_along_range_as_its_pulse() -> None:
    """Any spectrum: the correlation at lag n is its transform over its sum; 5 sigma of the bins averaged."""
    frequency = np.fft.fftfreq(512)
    power = np.exp(-((frequency / 0.12) ** 2)) * (1 + 0.5 * np.sin(9 * frequency))  # lopsided: a complex correlation
    rows = SpeckleRows(power, 4000, seed=1).make(2, 16, 48)
    expected = np.fft.ifft(power) / np.mean(power)
    for lag in range(8):
        result = np.mean(rows[:, lag:] * np.conj(rows[:, : 4000 - lag]))
        assert abs(result - expected[lag]) < 5 * 2.5 / np.sqrt(32 * 4000)  # 2.5: bins correlate over six


def test_rows_are_independent_and_belong_to_their_number() -> None:
    made = SpeckleRows(np.ones(64), 300, seed=9)
    one, next_scan, other = made.make(0, 0, 16), made.make(1, 0, 16), made.make(0, 16, 32)
    np.testing.assert_array_equal(one, SpeckleRows(np.ones(64), 300, seed=9).make(0, 0, 16))
    for stranger in (next_scan, other, SpeckleRows(np.ones(64), 300, seed=8).make(0, 0, 16)):
        assert abs(np.mean(one * np.conj(stranger))) < 5 / np.sqrt(16 * 300)
    assert abs(np.mean(one[:-1] * np.conj(one[1:]))) < 5 / np.sqrt(15 * 300)


@pytest.mark.parametrize("shape", [0.1, 1.0, 20.0])
def test_gamma_has_its_quantiles(shape: float) -> None:
    """Against the law itself by another route (survival function of scipy.stats), to 1e-9 of probability."""
    gaussian = np.linspace(-6, 6, 25)
    gamma = gamma_from_gaussian(gaussian, shape)
    law = scipy.stats.gamma(shape, scale=1 / shape)
    normal = scipy.stats.norm
    np.testing.assert_allclose(law.cdf(gamma[:13]), normal.cdf(gaussian[:13]), rtol=1e-6, atol=1e-300)
    np.testing.assert_allclose(law.sf(gamma[12:]), normal.sf(gaussian[12:]), rtol=1e-6)


@pytest.mark.parametrize("shape", [0.1, 1.0, 100.0])
def test_table_makes_gamma_texture(shape: float) -> None:
    """The squared roots of normal numbers follow the gamma law of unit mean (Kolmogorov-Smirnov), with its mean and second
    moment 1 + 1/nu to 5 sigma."""
    gaussian = np.random.default_rng(7).standard_normal((200, 500)).astype(np.float32)
    texture = TextureTable(np.full(500, shape)).roots(gaussian).astype(np.float64) ** 2
    law = scipy.stats.gamma(shape, scale=1 / shape)
    assert scipy.stats.kstest(texture.ravel(), law.cdf).pvalue > LEVEL
    assert texture.mean() == pytest.approx(1.0, abs=5 * law.std() / np.sqrt(100_000))
    spread = np.sqrt((law.moment(4) - law.moment(2) ** 2) / 100_000)
    assert np.mean(texture**2) == pytest.approx(1 + 1 / shape, abs=5 * spread)


def test_table_serves_every_bin_its_own_shape_and_any_number() -> None:
    shape = np.geomspace(0.05, 100.0, 500)
    table = TextureTable(shape)
    gaussian = np.full((1, 500), 1.2816, dtype=np.float32)  # the 90th percentile
    expected = scipy.stats.gamma(shape, scale=1 / shape).ppf(0.9)
    np.testing.assert_allclose(table.roots(gaussian)[0] ** 2, expected, rtol=0.03)  # 1 % of shape, 0.4 % of a sigma
    assert np.isfinite(table.roots(np.array([[-1e3] * 500, [1e3] * 500], dtype=np.float32))).all()


@pytest.mark.parametrize("shape", [0.3, 10.0])
def test_gaussian_correlation_gives_the_texture_its_own(shape: float) -> None:
    """100 000 pairs of Gaussians with the correlation found have textures that correlate 1/e: 5 sigma of the products."""
    rho = gaussian_correlation(shape, np.exp(-1))
    assert np.exp(-1) < rho < 1
    rng = np.random.default_rng(8)
    a, b = rng.standard_normal((2, 100_000))
    x, y = gamma_from_gaussian(a, shape) - 1, gamma_from_gaussian(rho * a + np.sqrt(1 - rho**2) * b, shape) - 1
    products = x * y * shape
    assert products.mean() == pytest.approx(np.exp(-1), abs=5 * products.std() / np.sqrt(100_000))

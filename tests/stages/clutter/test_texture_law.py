"""The ellipse of the texture against its geometry, and the gains against sums over pairs of rows."""

import numpy as np
import pytest

from radar_service.stages.clutter.texture import FAR, TextureGains, TextureLaw

LAW = TextureLaw(20.0, 10.0, np.deg2rad(30.0), 0.0)


def test_the_ellipse_is_long_along_the_wind() -> None:
    """-log correlation is 1 at 20 m along the wind and 10 m across it; 45 degrees off it at sqrt(2) / sqrt(1/400 + 1/100)."""
    bearing = np.deg2rad([30.0, 120.0, 75.0, 210.0])
    a, b, c = LAW.form(bearing)
    np.testing.assert_allclose(a**-0.5, [20, 10, np.sqrt(2 / 0.0125), 20], rtol=1e-12)
    np.testing.assert_allclose(c**-0.5, [10, 20, np.sqrt(2 / 0.0125), 10], rtol=1e-12)
    np.testing.assert_allclose(b, [0, 0, 0.5 * (0.01 - 0.0025), 0], atol=1e-15)


def test_the_mixed_term_is_that_of_the_map() -> None:
    """Any displacement, outward and clockwise along any bearing, by hand in the frame of the wind."""
    rng = np.random.default_rng(1)
    bearing, r, s = rng.uniform(0, 7, 50), rng.normal(size=50), rng.normal(size=50)
    east = r * np.sin(bearing) + s * np.cos(bearing)
    north = r * np.cos(bearing) - s * np.sin(bearing)
    along = east * np.sin(LAW.wind_from) + north * np.cos(LAW.wind_from)
    across = east * np.cos(LAW.wind_from) - north * np.sin(LAW.wind_from)
    a, b, c = LAW.form(bearing)
    np.testing.assert_allclose(a * r**2 + 2 * b * r * s + c * s**2, (along / 20) ** 2 + (across / 10) ** 2, rtol=1e-9)


def test_a_beams_average_lies_between_the_field_and_watts() -> None:
    """At 0 and 90 degrees off the wind all three are equal; at 45 they are 12.65, 14.14 and 15.81 m."""
    bearing = np.deg2rad([30.0, 120.0, 75.0])
    np.testing.assert_allclose(LAW.beam_averaged_length(bearing), [20, 10, np.sqrt(200)], rtol=1e-12)


def test_taps_have_the_correlation_of_the_pulse() -> None:
    """exp(-(r / 12)^2) at steps of 2 m to 0.02, the tails beyond 1.2 lengths; no taps where the pulse is short."""
    taps = TextureLaw(20.0, 10.0, 0.0, 12.0).taps(2.0)
    correlation = np.correlate(taps, taps, "full") / np.sum(taps**2)
    lag = 2.0 * (np.arange(len(correlation)) - len(taps) + 1)
    np.testing.assert_allclose(correlation, np.exp(-((lag / 12.0) ** 2)), atol=0.02)
    assert TextureLaw(20.0, 10.0, 0.0, 1.0).taps(2.0).tolist() == [1.0]


@pytest.mark.parametrize("cell", [0.0, 8.0])
@pytest.mark.parametrize("bearing_deg", [30.0, 75.0, 120.0, 297.0])
def test_gains_make_the_beams_sum_of_unit_variance(cell: float, bearing_deg: float) -> None:
    """By hand over all pairs of seven rows, 2 degrees apart, and of all taps, with the law's correlation; near the antenna,
    where rows blend, and far out. 2 %: the table's steps."""
    law, step = TextureLaw(20.0, 10.0, np.deg2rad(30.0), cell), 2.0
    weight = np.exp(-(np.arange(-3, 4) ** 2) / 3.0)
    weight /= np.sqrt(np.sum(weight**2))
    gains = TextureGains(law, 180, step, 1000, np.correlate(weight, weight, "full"))
    row = round(bearing_deg / 2)
    near, far = gains.rows(row, row + 1, gains.columns)
    a, b, c = (float(part[0]) for part in law.form(np.array([row * np.deg2rad(2.0)])))
    taps = law.taps(step)
    r = step * np.subtract.outer(np.arange(len(taps)), np.arange(len(taps)))[:, :, None, None]
    for column in (0, 40, 120, 180, 240, 300, 400):
        s = np.subtract.outer(np.arange(7), np.arange(7)) * np.deg2rad(2.0) * (column + 0.5) * step
        pairs = np.exp(-(a * r**2 + 2 * b * r * s + c * s**2))
        variance = np.einsum("i,j,k,l,ijkl", taps, taps, weight, weight, pairs) * near[0, column] ** 2 + far[0, column] ** 2
        assert variance == pytest.approx(1.0, abs=0.02)
    assert gains.columns == np.ceil(FAR * 20.0 / np.deg2rad(2.0) / step)


def test_zone_holds_all_columns_that_need_the_map_and_no_independent_rows_before_it() -> None:
    gains = TextureGains(LAW, 180, 2.0, 1000, np.ones(1))
    for start in range(0, 180, 30):
        near, far = gains.rows(start, start + 30, gains.columns)
        first, last = gains.zone(start, start + 30)
        assert 0 < first < last <= gains.columns
        assert (far[:, :first] == 0).all() and (near[:, last:] < 1e-6).all()

from decimal import Decimal, getcontext

import numpy as np
import pytest

from radar_service.propagation import multipath
from radar_service.propagation.multipath import (
    mean_square_factor,
    moved_excess,
    printed_two_ray_factor,
    specular_geometry,
    two_ray_factor,
    two_rays,
)
from radar_service.propagation.sea_surface import fresnel, sea_water_permittivity
from tests.reference.legs import reflected_ray

FREQUENCY = 9.41e9
WAVELENGTH = multipath.wavelength(FREQUENCY)
EARTH = 4 / 3 * 6_371_000.0
ANTENNA, TARGET = 15.0, 10.0
NULLS = {np.inf: (9416.5, 4708.3, 3138.8, 2354.1, 1883.3), EARTH: (8037.0, 4487.6, 3069.6, 2324.3, 1867.9)}


def test_wavelength_of_the_table() -> None:
    assert multipath.wavelength(9.41e9) == pytest.approx(0.0319, abs=5e-5)  # eq. 1, half its last digit


@pytest.mark.parametrize("earth_radius", [np.inf, EARTH])
def test_the_reflected_ray_is_that_of_the_whole_geometry(earth_radius: float) -> None:
    """To rounding, on both sides of the horizon and with targets below the sea."""
    distance, height = np.meshgrid([5.0, 300.0, 5000.0, 30_000.0], [-1.0, 0.0, 2.0, 30.0])
    ray, whole = (f(distance, height, ANTENNA, earth_radius) for f in (reflected_ray, specular_geometry))
    for computed, exact in ((ray.reflection, whole.reflection), (ray.first, whole.first), (ray.second, whole.second)):
        np.testing.assert_allclose(computed, exact, rtol=1e-13)
    np.testing.assert_allclose(ray.grazing_sine, np.sin(whole.grazing), rtol=1e-12)
    np.testing.assert_allclose(
        ray.rise, np.maximum(height, 0) - (distance**2 - ray.reflection**2) / 2 / earth_radius, atol=1e-9
    )


@pytest.mark.parametrize("earth_radius", [np.inf, EARTH])
def test_nulls_of_a_perfect_reflection(earth_radius: float) -> None:
    distance = np.linspace(1500.0, 12_000.0, 200_001)
    waves = specular_geometry(distance, TARGET, ANTENNA, earth_radius).excess / WAVELENGTH
    result = [np.interp(-n, -waves, distance) for n in range(1, 6)]
    # half the last digit; the tables' 2 h1 h2 / d leaves out (h1^2 + h2^2) / d^2, 6e-5 at the fifth null: 0.1 m
    assert result == pytest.approx(NULLS[earth_radius], abs=0.15)


@pytest.mark.parametrize(
    ("kilometres", "flat_db", "curved_db"),
    [
        (2, 8.02, 9.59),
        (4, 10.15, 6.71),
        (6, 11.62, 11.37),
        (9.4165, None, 1.86),
        (12, 3.90, 10.50),
        (15, 10.60, 7.57),
        (20, 11.97, -5.35),
    ],
)
def test_fourth_power_of_the_factor(
    kilometres: float, flat_db: float | None, curved_db: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(multipath, "fresnel", lambda grazing, *_: -np.ones_like(grazing))  # the tables are for rho = -1

    def level(earth_radius: float) -> float:
        factor = two_ray_factor(1e3 * kilometres, TARGET, ANTENNA, WAVELENGTH, earth_radius=earth_radius)
        return float(40 * np.log10(np.abs(factor)))

    assert level(EARTH) == pytest.approx(curved_db, abs=6e-3)  # half the last digit
    if flat_db is None:
        assert level(np.inf) < -90  # the flat null, given to 0.1 m: 20 log10(2 pi 0.05 m / 9416 m) for each of two ways
    else:
        assert level(np.inf) == pytest.approx(flat_db, abs=0.012)  # the table's 2 h1 h2 / d, see the nulls


def test_the_ray_in_the_null_region_is_what_the_horizon_leaves() -> None:
    geometry = specular_geometry(np.array([2000.0, 9416.5, 20_000.0]), TARGET, ANTENNA, EARTH)
    assert geometry.divergence[0] == pytest.approx(0.9955, abs=5e-5)  # half the last digit
    assert np.all(np.diff(geometry.divergence) < 0) and np.all(np.diff(geometry.grazing) < 0)


@pytest.mark.parametrize(
    ("antenna", "target", "distance"),
    [(15.0, 10.0, 8000.0), (15.0, 10.0, 25_000.0), (100.0, 120.0, 40_000.0), (15.0, 2.0, 300.0)],
)
def test_the_path_difference_is_the_least_path_to_a_millionth_of_a_radian(
    antenna: float, target: float, distance: float
) -> None:
    getcontext().prec = 40
    d, earth = Decimal(distance), Decimal(2 * EARTH)
    top, end = Decimal(antenna), Decimal(target) - d * d / earth

    def path(x: Decimal) -> Decimal:
        sea = -x * x / earth
        return (x * x + (top - sea) ** 2).sqrt() + ((d - x) ** 2 + (end - sea) ** 2).sqrt()

    near = Decimal(float(d) * antenna / (antenna + target))
    low, high = max(near - 8000, Decimal(0)), min(near + 8000, d)
    for _ in range(150):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if path(a) < path(b) else (a, high)
    minimum = path(low) - (d * d + (end - top) ** 2).sqrt()
    result = specular_geometry(distance, target, antenna, EARTH).excess
    assert float(result) == pytest.approx(float(minimum), abs=1e-6 * WAVELENGTH / (2 * np.pi))


def test_a_null_of_the_beam_on_the_direct_ray_stays_finite() -> None:
    null = two_ray_factor(1000.0, 40.0, ANTENNA, WAVELENGTH, elevation_gain=lambda e: np.where(e > 0, 0.0, 1.0))
    assert np.isfinite(null)


def test_beyond_the_horizon_there_is_nothing() -> None:
    horizon = np.sqrt(2 * EARTH * ANTENNA) + np.sqrt(2 * EARTH * TARGET)
    assert horizon == pytest.approx(28_998, abs=0.5)  # half the last digit of the reference
    factor = two_ray_factor(
        np.array([horizon - 1, horizon + 1, 2 * horizon]), TARGET, ANTENNA, WAVELENGTH, earth_radius=EARTH
    )
    assert np.abs(factor[0]) == pytest.approx(1.0, abs=0.05)  # D goes to 0 at the horizon: as the root of the metre left
    assert np.array_equal(factor[1:], [0, 0])


@pytest.mark.parametrize("earth_radius", [np.inf, EARTH, 1e6 * EARTH])
def test_unusual_positions_stay_finite(earth_radius: float) -> None:
    d, h = np.meshgrid([0.0, 1e-3, 1.0, 100.0, 3e4], [-5.0, 0.0, 1e-3, 15.0, 500.0])
    factor = two_ray_factor(d, h, ANTENNA, WAVELENGTH, earth_radius=earth_radius, wave_height=0.3)
    assert factor.shape == d.shape and np.all(np.isfinite(factor)) and np.abs(factor).max() <= 2.0


def test_a_hardly_curved_earth_is_flat() -> None:
    d = np.array([50.0, 500.0, 5000.0])
    flat, nearly = (specular_geometry(d, TARGET, ANTENNA, ae) for ae in (np.inf, 1e15))
    # d^2 / 2 ae is 1e-8 m at 5 km, which tilts a path of 2 h1 h2 / d by some 1e-9 of itself
    assert nearly.excess == pytest.approx(flat.excess, rel=1e-8)
    assert nearly.divergence == pytest.approx(1.0, abs=1e-8)


def test_printed_factor_is_flat_with_a_curved_divergence() -> None:
    null = printed_two_ray_factor(9416.5, TARGET, ANTENNA, WAVELENGTH)
    grazing = np.arctan2(25.0, 9416.5)
    left = 1 - np.abs(fresnel(grazing, sea_water_permittivity(FREQUENCY), "h"))
    assert np.abs(null) == pytest.approx(left, abs=2e-3)  # Gamma is 0.06 degrees short of -180: 1e-3
    curved = printed_two_ray_factor(9416.5, TARGET, ANTENNA, WAVELENGTH, earth_radius=EARTH)
    d1, d2 = 9416.5 * 15 / 25, 9416.5 * 10 / 25
    expected = 1 - (1 - left) / np.sqrt(1 + 2 * d1 * d2 / (EARTH * 9416.5 * np.sin(grazing)))
    assert np.abs(curved) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("earth_radius", [np.inf, EARTH])
@pytest.mark.parametrize("distance", [80.0, 300.0, 3000.0, 20_000.0])
def test_the_excess_after_a_move_is_that_of_the_new_geometry(distance: float, earth_radius: float) -> None:
    """Moves by 2 m and 0.3 m of both heights change the excess by more than 1e-5 m; 1e-6 m (the stated error) are 0.2 mrad."""
    d, h = np.array([distance]), np.array([TARGET])
    geometry = specular_geometry(d, h, ANTENNA, earth_radius)
    after = (d - 2.0, h + 0.3, np.array(ANTENNA - 0.3))
    exact = specular_geometry(*after, earth_radius).excess
    assert abs(exact[0] - geometry.excess[0]) > 1e-5
    result = moved_excess(geometry, (d, h, np.array(ANTENNA)), after, earth_radius)
    assert result[0] == pytest.approx(exact[0], abs=1e-6 if distance > 5000 else 1e-8)


@pytest.mark.parametrize("earth_radius", [np.inf, EARTH])
def test_the_excess_slopes_with_height(earth_radius: float) -> None:
    """A difference of 2 mm: second order errs by 1e-9 of the slope, rounding of 1e-15 km by 1e-8."""
    d = np.array([100.0, 1000.0, 15_000.0])
    ends = [specular_geometry(d, TARGET + dh, ANTENNA, earth_radius).excess for dh in (-1e-3, 1e-3)]
    slope = specular_geometry(d, TARGET, ANTENNA, earth_radius).excess_slope
    assert slope == pytest.approx((ends[1] - ends[0]) / 2e-3, rel=1e-5)


@pytest.mark.parametrize("span", [0.0, 0.05, 0.4, 3.0, 12.0])
@pytest.mark.parametrize("distance", [150.0, 900.0, 4000.0])
def test_the_mean_over_a_height_is_that_of_many_points(distance: float, span: float) -> None:
    """|F|^4 averaged over 20,001 heights with the ratio of the middle. The phase is linear to dh^2 k / 2 R: 2 % of a radian at
    12 m and 150 m, less elsewhere; 0.02 of the mean."""
    middle, k = two_rays(distance, TARGET, ANTENNA, WAVELENGTH, earth_radius=EARTH), 2 * np.pi / WAVELENGTH
    heights = TARGET + span * np.linspace(-0.5, 0.5, 20_001)
    excess = specular_geometry(distance, heights, ANTENNA, EARTH).excess
    by_points = np.sqrt(np.mean(np.abs(1 + middle.ratio * np.exp(-1j * k * excess)) ** 4))
    geometry = middle.geometry
    result = mean_square_factor(middle.ratio, k * geometry.excess, k * geometry.excess_slope * span)
    assert result == pytest.approx(by_points, rel=0.02, abs=0.01)

"""The short modules of propagation, each under its name."""

import numpy as np
import pytest
from scipy.special import i0e

from radar_service.propagation.gas_and_rain import attenuation_amplitude, printed_atmosphere, rain_db_per_km
from radar_service.propagation.sea_surface import ament, fresnel, miller_brown, rms_wave_height, sea_water_permittivity

# sea_surface: its tests.
FREQUENCY, WAVELENGTH = 9.41e9, 0.031859
SEA = 55.3 - 38.2j  # sea water at 15 C for which the Fresnel values below were computed


@pytest.mark.parametrize(
    ("celsius", "expected"), [(5, 47.9 - 41.2j), (10, 52.1 - 39.9j), (15, 55.3 - 38.2j), (20, 57.4 - 36.5j)]
)
def test_permittivity_of_sea_water(celsius: float, expected: complex) -> None:
    # 2 %: the anchors follow the 2004 fit of Meissner and Wentz, the code their fit of 2012, which moved by up to 1.4 %
    assert sea_water_permittivity(FREQUENCY, celsius) == pytest.approx(expected, rel=0.02)


def test_fresh_water_far_below_relaxation_is_the_static_permittivity() -> None:
    # CRC Handbook: 78.4 at 25 C; 0.3 % is the spread between published fits
    assert sea_water_permittivity(1e7, 25.0, 0.0) == pytest.approx(78.4, rel=3e-3)


def test_conductivity_of_standard_sea_water() -> None:
    # practical salinity scale 1978: C(35, 15 C, 0) = 4.2914 S/m; at 1 MHz conduction is all of the imaginary part
    conductivity = -sea_water_permittivity(1e6, 15.0, 35.0).imag * 2 * np.pi * 1e6 * 8.8541878e-12
    assert conductivity == pytest.approx(4.2914, rel=2e-3)  # Stogryn's polynomial against the scale


@pytest.mark.parametrize(
    ("polarization", "grazing_deg", "magnitude"),
    [("h", 0.5, 0.9980), ("h", 1, 0.9959), ("h", 2, 0.9919), ("h", 5, 0.9798), ("h", 10, 0.9602), ("h", 30, 0.8896),
     ("v", 0.1, 0.9729), ("v", 0.5, 0.8713), ("v", 1, 0.7585), ("v", 2, 0.5711), ("v", 3, 0.4237), ("v", 5, 0.2221),
     ("v", 10, 0.2326), ("v", 30, 0.6249), ("v", 90, 0.7916), ("h", 90, 0.7916)],
)  # fmt: skip
def test_fresnel_magnitudes(polarization: str, grazing_deg: float, magnitude: float) -> None:
    # 3e-4: the permittivity behind the table has three digits, and the coefficient moves by up to 0.004 for 1 of it
    assert abs(fresnel(np.deg2rad(grazing_deg), SEA, polarization)) == pytest.approx(magnitude, abs=3e-4)


def test_pseudo_brewster_angle_of_vertical_polarization() -> None:
    grazing = np.deg2rad(np.linspace(4, 10, 6001))
    reflected = fresnel(grazing, SEA, "v")
    k = np.argmin(np.abs(reflected))
    assert np.rad2deg(grazing[k]) == pytest.approx(6.97, abs=0.01)  # half the last digit, and three digits of permittivity
    assert abs(reflected[k]) == pytest.approx(0.150, abs=5e-4)
    assert np.rad2deg(np.angle(reflected[k])) == pytest.approx(-90, abs=1)  # the phase turns 25 degrees a degree here


def test_horizontal_polarization_turns_the_field_over_at_every_angle() -> None:
    phase = np.abs(np.rad2deg(np.angle(fresnel(np.deg2rad(np.linspace(0, 90, 91)), SEA, "h"))))
    assert phase.min() > 175  # "180 throughout", less the loss angle of sqrt(eps) at normal incidence


def test_a_metal_sea_conserves_energy() -> None:
    assert np.abs(fresnel(np.array([0.2, 1.0]), 1 - 1e12j, "h")) == pytest.approx([1, 1], abs=1e-5)  # 1/sqrt(1e12) x 2


def test_fresnel_refuses_other_polarizations() -> None:
    with pytest.raises(ValueError, match='"c" is not one of h, v'):
        fresnel(0.1, SEA, "c")


@pytest.mark.parametrize(
    ("height", "grazing_deg", "by_ament", "by_miller_brown"),
    [
        (0.1, 1, 0.789, 0.800),
        (0.3, 0.5, 0.587, 0.629),
        (0.3, 1, 0.119, 0.297),
        (0.5, 0.5, 0.227, 0.370),
        (0.5, 1, 0.0027, 0.168),
    ],
)
def test_roughness(height: float, grazing_deg: float, by_ament: float, by_miller_brown: float) -> None:
    grazing = np.deg2rad(grazing_deg)
    assert ament(grazing, height, WAVELENGTH) == pytest.approx(by_ament, abs=5.1e-4)  # half the last digit
    assert miller_brown(grazing, height, WAVELENGTH) == pytest.approx(by_miller_brown, abs=5.1e-4)


def test_a_smooth_sea_reflects_fully_and_a_very_rough_one_stays_finite() -> None:
    assert (float(ament(0.3, 0.0, WAVELENGTH)), float(miller_brown(0.3, 0.0, WAVELENGTH))) == (1.0, 1.0)
    assert 0 < float(miller_brown(np.pi / 2, 14.0, WAVELENGTH)) < 1e-3


def test_the_table_of_roughness_is_the_bessel_function() -> None:
    """Within 2e-9 of itself: an eighth of the squared step times the curvature."""
    height = np.logspace(-4, 6, 100_001)
    exact = i0e(0.5 * (4.0 * np.pi * height * np.sin(0.1) / WAVELENGTH) ** 2)
    np.testing.assert_allclose(miller_brown(0.1, height, WAVELENGTH), exact, rtol=2e-9)


def test_sea_states_follow_the_wmo_code() -> None:
    """States 2 to 6 lie in its bands."""
    edges = [0.1, 0.5, 1.25, 2.5, 4, 6]  # H_1/3 [m] between states, WMO code table 3700
    for state, low, high in zip(range(2, 7), edges, edges[1:], strict=False):
        assert low <= 4 * rms_wave_height(state) <= high


# gas_and_rain: attenuation by gas and rain against the tables of the ITU-R recommendations.
def test_printed_atmosphere_loses_one_db_both_ways_at_50_km() -> None:
    # docs/specification.md eq. 10; rounding
    assert 10 * np.log10(printed_atmosphere(50_000.0, 0.01)) == pytest.approx(-1.0, rel=1e-12)


def test_gas_loses_its_decibels_in_power_both_ways() -> None:
    # 0.01327 dB/km by ITU-R P.676: 0.53 dB at 20 km two-way, half the last digit
    assert -20 * np.log10(attenuation_amplitude(20_000.0, 0.01327)) == pytest.approx(0.53, abs=5e-3)


@pytest.mark.parametrize(("mm_h", "horizontal", "vertical"), [(4, 0.0556, 0.0480), (16, 0.332, 0.274), (50, 1.443, 1.147)])
def test_rain(mm_h: float, horizontal: float, vertical: float) -> None:
    # half the last printed digit
    digits = 5e-5 if mm_h == 4 else 5e-4
    assert rain_db_per_km(mm_h, "h", FREQUENCY) == pytest.approx(horizontal, abs=digits)
    assert rain_db_per_km(mm_h, "v", FREQUENCY) == pytest.approx(vertical, abs=digits)


def test_no_rain_costs_nothing() -> None:
    assert rain_db_per_km(0, "v", FREQUENCY) == 0.0


@pytest.mark.parametrize(
    ("arguments", "position"), [((4, "x", 9e9), "polarization"), ((4, "h", 5e8), "frequency"), ((-1, "h", 9e9), "rain_mm_h")]
)
def test_rain_outside_its_range_is_refused(arguments: tuple[float, str, float], position: str) -> None:
    with pytest.raises(ValueError, match=f"^{position}: "):
        rain_db_per_km(*arguments)

"""Attenuation by gas and rain against the tables of the ITU-R recommendations."""

import numpy as np
import pytest

from radar_service.propagation.attenuation import attenuation_amplitude, printed_atmosphere, rain_db_per_km

FREQUENCY = 9.41e9


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

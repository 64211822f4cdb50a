"""Gas attenuation against the line-by-line sum of ITU-R P.676-12, Annex 1."""

import pytest

from radar_service.scene.atmosphere import gas_attenuation_db_per_km, oxygen_db_per_km, vapour_db_per_km
from radar_service.scene.error import SceneError

# P.676-12 Annex 1 at 15 C, 1013.25 hPa, 7.5 g/m3, by itur 0.4.0 (reference values of the project, 9.41 GHz).
OXYGEN, VAPOUR = 0.00810, 0.00517


def test_x_band() -> None:
    # 10 %: what Annex 2 claims for its fits; of the vapour alone, in the far wing of its lines, it is 11 % too much
    assert oxygen_db_per_km(9.41) == pytest.approx(OXYGEN, rel=0.1)
    assert gas_attenuation_db_per_km(9.41e9) == pytest.approx(OXYGEN + VAPOUR, rel=0.1)


def test_water_peaks_at_its_line() -> None:
    """0.19 dB/km at 22.235 GHz is the height of the line in figure 5 of P.676-10."""
    assert vapour_db_per_km(22.235) > max(vapour_db_per_km(20.0), vapour_db_per_km(25.0))
    assert vapour_db_per_km(22.235) == pytest.approx(0.19, abs=0.02)  # what can be read off the figure


def test_oxygen_band_is_refused() -> None:
    with pytest.raises(SceneError, match=r'environment.gas_db_per_km: "itu" covers 1 to 54 GHz, not 60 GHz'):
        gas_attenuation_db_per_km(60e9)

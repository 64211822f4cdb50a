"""Gas attenuation against the line-by-line sum of ITU-R P.676-12, Annex 1."""

import pytest

from radar_service.world.atmosphere import gas_attenuation_db_per_km, oxygen_db_per_km, vapour_db_per_km
from radar_service.world.error import SceneError

# Frequency [GHz], oxygen and water vapour [dB/km] by P.676-12 Annex 1 at 15 C, 1013.25 hPa, 7.5 g/m3: itur 0.4.0,
# gamma0_exact and gammaw_exact.
LINE_BY_LINE = [
    (3.0, 0.0070760, 0.00046279),
    (9.41, 0.0081032, 0.0051694),
    (16.0, 0.0099908, 0.025325),
    (22.235, 0.0132927, 0.178977),
    (35.0, 0.0318430, 0.0696143),
    (50.0, 0.2772686, 0.1111585),
]


@pytest.mark.parametrize("f_ghz, oxygen, vapour", LINE_BY_LINE)
def test_against_the_sum_over_lines(f_ghz: float, oxygen: float, vapour: float) -> None:
    # oxygen 6 %, vapour 12 %: how far the two annexes lie apart between the lines; 10 % of the sum is what is promised
    assert oxygen_db_per_km(f_ghz) == pytest.approx(oxygen, rel=0.06)
    assert vapour_db_per_km(f_ghz) == pytest.approx(vapour, rel=0.12)
    assert gas_attenuation_db_per_km(f_ghz * 1e9) == pytest.approx(oxygen + vapour, rel=0.1)


def test_oxygen_band_is_refused() -> None:
    with pytest.raises(SceneError, match=r'environment.gas_db_per_km: "itu" covers 1 to 54 GHz, not 60 GHz'):
        gas_attenuation_db_per_km(60e9)

"""`check` warns of beacons that answer no radar, with the remedy, and of no others."""

from typing import Any

import pytest

from tests.scenes import point, scene

STRONG: dict[str, Any] = {"power_w": 10e3, "gain_dbi": 30.0, "range_max_m": 5000}
S_BAND = STRONG | {"frequency_hz": 3.05e9}
K = {"racon": {"letter": "K"}}


def warnings(body: dict[str, Any], radar: Any, **sections: Any) -> list[str]:
    made = scene([point("mark", 0, 4000) | body], radar=radar, **sections)
    return [warning for warning in made.warnings if warning.startswith("body[0].")]


@pytest.mark.parametrize(
    "body, radar, expected",
    [
        (
            {"sart": {}}, S_BAND,
            "body[0].sart: mark answers no radar of this scene, for it takes 9.2 to 9.5 GHz; give the radar such a frequency_hz",
        ),
        (
            {"racon": {"letter": "K", "band": "x"}}, S_BAND,
            "body[0].racon: mark answers no radar of this scene, for it takes 9.3 to 9.5 GHz; give the radar such a "
            'frequency_hz or the racon band = "both"',
        ),
        (
            {"racon": {"letter": "K", "band": "x", "max_pulse_s": 1e-6}}, STRONG | {"pulse_s": 2e-6},
            "body[0].racon: mark answers no radar of this scene, for it takes 9.3 to 9.5 GHz and pulses up to 1e-06 s; raise "
            "max_pulse_s or shorten the radar's pulse",
        ),
        (
            K, STRONG | {"power_w": 0.2},
            "body[0].racon: mark is 4 km off, but the peak power of the radar's pulses triggers it within 0.359 km in free "
            "space; raise power_w of the radar or lower sensitivity_dbm",
        ),
    ],
)  # fmt: skip
def test_a_beacon_that_answers_nobody(body: dict[str, Any], radar: dict[str, Any], expected: str) -> None:
    """0.2 W and 30 dBi reach -50 dBm at 0.359 km: 53.01 + 50 - 32.45 - 20 log10(9410) - 20 log10(km) = 0."""
    assert warnings(body, radar) == [expected]


def test_no_warning_where_one_radar_is_enough() -> None:
    """An S-band set beside one of X band; 1.9 times the range of free space, as a sea may double the field; a ship that comes."""
    assert not warnings({"sart": {}}, [{"id": "x", **STRONG}, {"id": "s", **S_BAND}])
    assert not warnings(K, STRONG | {"power_w": 0.2 * (4.0 / 0.359 / 1.9) ** 2})
    assert warnings(K, STRONG | {"power_w": 0.2 * (4.0 / 0.359 / 2.1) ** 2})
    assert not warnings(K, STRONG | {"power_w": 0.2}, own_ship={"speed_kn": 12})
    assert not warnings(K | {"speed_kn": 5.0}, STRONG | {"power_w": 0.2})
    near = {"modulation": "none", "bandwidth_hz": 5e6, "pulse_s": 0.2e-6, "range_max_m": 1800}
    far = {"modulation": "lfm", "bandwidth_hz": 5e6, "pulse_s": 2e-6}
    takes_the_near_pulse = {"racon": {"letter": "K", "max_pulse_s": 1e-6}}
    assert not warnings(takes_the_near_pulse, STRONG | {"sample_rate_hz": 15e6, "pulses": [near, far]})

"""The environment of a scene file: effects that need each other."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.world.error import SceneError
from tests.scenes import scene


@pytest.mark.parametrize(
    ("environment", "message"),
    [
        ({"diffraction": True}, "environment.diffraction: true needs the sea's reflection; give multipath = true"),
        ({"diffraction": True, "multipath": True, "earth": "flat"}, "environment.diffraction: true needs a round earth"),
        ({"diffraction": True, "multipath": True, "earth": 1000.0}, "needs a round earth, not earth = 1000.0; give 4/3"),
        ({"earth": "round"}, 'environment.earth: "round" is not allowed'),
        ({"sea_state": 10}, "environment.sea_state: 10 is not allowed; a whole number from 0 to 9"),
    ],
)
def test_what_does_not_go_together_is_refused(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError) as refused:
        rs.load_scene({"environment": environment})
    assert message in str(refused.value)


def test_an_interfering_radar_in_si_units() -> None:
    (other,) = scene(interference=[{"bearing_deg": 90, "level_db": 20, "rpm": 30}]).interference
    assert (other.position, other.rotation_period) == (None, 2.0)
    assert (other.bearing, other.level) == (pytest.approx(np.pi / 2), pytest.approx(100.0))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "interference[0].bearing_deg: an interfering radar needs exactly one of bearing_deg and position_m"),
        ({"bearing_deg": 1, "position_m": [1, 1]}, "interference[0].bearing_deg: an interfering radar needs exactly one"),
        ({"bearing_deg": 1, "pulse_s": 1e-4, "prf_hz": 5000}, "interference[0].pulse_s: 0.0001 s at 5000 pulses a second"),
    ],
)
def test_impossible_radars_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(interference=[keys])
    assert str(caught.value).startswith(message)

"""Other radars in a scene file."""

from typing import Any

import numpy as np
import pytest

from radar_service.world.error import SceneError
from tests.scenes import scene


def test_an_interfering_radar_in_si_units() -> None:
    (other,) = scene(interference=[{"bearing_deg": 90, "level_db": 20, "rpm": 30}]).effects["interference"]
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

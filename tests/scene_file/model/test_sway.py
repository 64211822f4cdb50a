"""Keys of sway in scene files, for own ship and bodies."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from tests.scenes import point, scene

KEYS = {"roll_deg": 5, "roll_period_s": 8, "roll_phase_deg": 90, "heave_m": 0.5, "heave_period_s": 6, "heave_phase_deg": -90}


def test_keys_become_si_for_own_ship_and_bodies() -> None:
    made = scene([point("p", 0, 300, **KEYS)], own_ship=KEYS)
    for sway in (made.own_ship.sway, made.bodies[0].motion.sway):
        assert sway is not None
        np.testing.assert_allclose(sway.amplitude, [np.deg2rad(5), 0, 0, 0.5])
        np.testing.assert_allclose(sway.period, [8, 7, 20, 6])
        np.testing.assert_allclose(sway.phase, [np.pi / 2, 0, 0, -np.pi / 2])
    assert scene([point("p", 0, 300)]).bodies[0].motion.sway is None


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"heave_period_s": 5}, "heave_period_s: it needs an amplitude; add heave_m"),
        ({"pitch_phase_deg": 5}, "pitch_phase_deg: it needs an amplitude; add pitch_deg"),
        ({"heave_m": 21}, "heave_m"),
        ({"roll_deg": -1}, "roll_deg"),
    ],
)
def test_keys_without_an_amplitude_and_values_out_of_range_are_refused(keys: dict[str, Any], message: str) -> None:
    for sections in ({"bodies": [point("p", 0, 300, **keys)]}, {"own_ship": keys}):
        with pytest.raises(rs.SceneError, match=message):
            scene(**sections)

"""Angles: which interval they are in, at its ends too."""

import numpy as np
import pytest

from radar_service.frames import wrap_angle, wrap_bearing

TURN = 2.0 * np.pi


@pytest.mark.parametrize("angle", [-1e-17, -5e-324, -TURN, TURN, 0.0, -1e-17 - TURN])
def test_a_bearing_of_north_is_zero_and_never_a_whole_turn(angle: float) -> None:
    assert float(wrap_bearing(angle)) == 0.0


def test_bearings_are_in_one_turn_and_angles_in_half_a_turn_either_way() -> None:
    angle = np.concatenate([np.linspace(-20.0, 20.0, 1001), np.nextafter(TURN * np.arange(-3, 4), -np.inf)])
    bearing, wrapped = wrap_bearing(angle), wrap_angle(angle)
    assert bearing.min() >= 0.0 and bearing.max() < TURN and np.abs(wrapped).max() <= np.pi
    for same in (bearing, wrapped):  # two roundings of at most 20 rad and one of the cosine's argument
        np.testing.assert_allclose(np.exp(1j * same), np.exp(1j * angle), rtol=0, atol=4 * 20 * np.finfo(float).eps)

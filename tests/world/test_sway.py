"""Sway: angles, heave and their rates."""

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_deck
from radar_service.world.sway import Sway

SWAY = Sway(np.array([0.2, 0.1, 0.05, 0.6]), np.array([6.0, 5.0, 9.0, 4.0]), np.array([0.4, -1.0, 2.0, 0.7]))
TIME = np.linspace(0.0, 30.0, 61)
STEP = 1e-5  # s; a central difference over it errs by some 1e-10


def test_each_motion_is_a_sine_of_its_period_and_phase() -> None:
    both = np.column_stack([SWAY.angles(TIME), SWAY.heave(TIME)])
    expected = SWAY.amplitude * np.sin(2 * np.pi * TIME[:, None] / SWAY.period + SWAY.phase)
    np.testing.assert_allclose(both, expected, atol=1e-14)
    assert SWAY.max_heave == 0.6 and SWAY.max_tilt == pytest.approx(0.3) and SWAY.tilts
    assert not Sway(np.array([0.0, 0.0, 0.1, 1.0]), np.ones(4)).tilts


def test_rates_are_derivatives_and_have_their_maxima() -> None:
    before, after = (np.column_stack([SWAY.angles(t), SWAY.heave(t)]) for t in (TIME - STEP, TIME + STEP))
    rates = np.column_stack([SWAY.rate(n, TIME) for n in range(4)])
    np.testing.assert_allclose(rates, (after - before) / (2 * STEP), atol=1e-8)
    every = np.column_stack([SWAY.rate(n, np.linspace(0, 200, 200001)) for n in range(4)])
    np.testing.assert_allclose(np.abs(every).max(axis=0), SWAY.max_rates, rtol=1e-6)


def test_the_rotation_changes_at_its_rate() -> None:
    heading, turn_rate = 1.0 + 0.03 * TIME, np.full(len(TIME), 0.03)
    np.testing.assert_array_equal(SWAY.rotation(heading, TIME), map_from_deck(heading, *SWAY.angles(TIME).T[:2]))
    ends = [SWAY.rotation(heading + sign * STEP * 0.03, TIME + sign * STEP) for sign in (-1, 1)]
    rate = SWAY.rotation_rate(heading, turn_rate, TIME)
    np.testing.assert_allclose(rate, (ends[1] - ends[0]) / (2 * STEP), atol=1e-8)

"""Sway: angles, heave and their rates."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.frames import map_from_deck
from radar_service.numerics.types import Floats
from radar_service.world.motion import Motion
from radar_service.world.sway import Sway, SwayState

SWAY = Sway(np.array([0.2, 0.1, 0.05, 0.6]), np.array([6.0, 5.0, 9.0, 4.0]), np.array([0.4, -1.0, 2.0, 0.7]))
TIME = np.linspace(0.0, 30.0, 61)
STEP = 1e-5  # s; a central difference over it errs by some 1e-10


def along(law: Sway, time: Floats) -> SwayState:
    return Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), sway=law).sway_state(time)


def test_each_motion_is_a_sine_of_its_period_and_phase() -> None:
    expected = SWAY.amplitude * np.sin(2 * np.pi * TIME[:, None] / SWAY.period + SWAY.phase)
    np.testing.assert_allclose(along(SWAY, TIME).values, expected, atol=1e-14)
    assert SWAY.max_heave == 0.6 and SWAY.max_tilt == pytest.approx(0.3) and SWAY.tilts and SWAY.shortest_period == 4.0
    assert not Sway(np.array([0.0, 0.0, 0.1, 1.0]), np.ones(4)).tilts


def test_list_and_trim_are_added_to_roll_and_pitch() -> None:
    leaning = replace(SWAY, lean=(0.03, -0.02))
    added = along(leaning, TIME).values - along(SWAY, TIME).values
    np.testing.assert_allclose(added, np.tile([0.03, -0.02, 0.0, 0.0], (len(TIME), 1)), atol=1e-15)
    np.testing.assert_array_equal(along(leaning, TIME).rates, along(SWAY, TIME).rates)
    np.testing.assert_allclose(leaning.max_values, [0.23, 0.12, 0.05, 0.6])
    assert Sway(np.zeros(4), np.ones(4), lean=(0.1, 0.0)).tilts


def test_rates_are_derivatives_and_have_their_maxima() -> None:
    before, after = (along(SWAY, t).values for t in (TIME - STEP, TIME + STEP))
    np.testing.assert_allclose(along(SWAY, TIME).rates, (after - before) / (2 * STEP), atol=1e-8)
    every = along(SWAY, np.linspace(0, 200, 200001)).rates
    np.testing.assert_allclose(np.abs(every).max(axis=0), SWAY.max_rates, rtol=1e-6)
    motion = Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), sway=SWAY)
    about = np.hypot(along(SWAY, TIME).rates, SWAY.max_rates / 2.0)
    np.testing.assert_allclose(motion.sway_rates(TIME), about, rtol=1e-12)


def test_the_rotation_changes_at_its_rate() -> None:
    heading, turn_rate = 1.0 + 0.03 * TIME, np.full(len(TIME), 0.03)
    state = along(SWAY, TIME)
    np.testing.assert_array_equal(state.rotation(heading), map_from_deck(heading, *state.values.T[:2]))
    ends = [along(SWAY, TIME + sign * STEP).rotation(heading + sign * STEP * 0.03) for sign in (-1, 1)]
    rate = state.rotation_rate(heading, turn_rate)
    np.testing.assert_allclose(rate, (ends[1] - ends[0]) / (2 * STEP), atol=1e-8)

"""Errors of the antenna's encoder against their laws."""

import numpy as np
import pytest

from radar_service.errors.antenna import AntennaLaw, backlash
from radar_service.numerics.types import Floats
from radar_service.scene.error_settings import AntennaErrors

ANGLES = np.linspace(-np.pi, np.pi, 4000, endpoint=False)
NUMBER = np.arange(len(ANGLES))


def error(misalignment: float = 0.0, play: float = 0.0, noise: float = 0.0, step: float = 0.0) -> Floats:
    """The errors at ANGLES."""
    law = AntennaLaw(AntennaErrors(misalignment, play, noise, step), 3, 1)
    return law.error(NUMBER, 0.01 * NUMBER, ANGLES)


def test_misalignment_is_added() -> None:
    np.testing.assert_array_equal(error(misalignment=0.02), np.full(len(ANGLES), 0.02))


def test_play_is_zero_along_and_across_the_wind_and_changes_sign_four_times() -> None:
    quarter = np.pi / 2.0
    np.testing.assert_allclose(backlash(quarter * np.arange(4)), 0.0, atol=1e-15)  # rounding of sin(2 pi)
    np.testing.assert_allclose(backlash(quarter * (np.arange(4) + 0.5)), [1, -1, 1, -1], atol=1e-7)  # arcsin near 1


def test_play_is_evenly_distributed() -> None:
    counts, _ = np.histogram(error(play=0.05), 10, (-0.05, 0.05))
    assert np.abs(counts - len(ANGLES) / 10).max() <= 4  # four sides of the triangle wave, one sample at each end


def test_the_encoder_rounds_the_angle_from_the_bow_to_whole_steps() -> None:
    step = 0.2 * np.pi / 180.0
    angle = ANGLES + error(misalignment=0.01, step=step)
    np.testing.assert_allclose(angle / step, np.rint(angle / step), atol=1e-9)  # rounding of 900 steps
    assert np.abs(error(step=step)).max() <= step / 2.0 * (1.0 + 1e-9)


def test_the_encoder_is_noisy() -> None:
    values = error(noise=0.01)
    assert values.std() == pytest.approx(0.01, rel=4.4 / np.sqrt(2.0 * len(ANGLES)))  # 4.4 standard errors: level 1e-5
    assert abs(values.mean()) < 4.4 * 0.01 / np.sqrt(len(ANGLES))

"""Factors on known levels of averaged power, against draws of all pulses."""

import numpy as np
import pytest

from radar_service.numerics.gamma_law import clutter_level_factor, known_level_factor


def test_of_one_pulse_the_law_is_exponential() -> None:
    assert known_level_factor(1e-4) == clutter_level_factor(1e-4, 3.0, 1) == -np.log(1e-4)


@pytest.mark.parametrize("clutter", [0.0, 0.1, 1.0, 30.0])
@pytest.mark.parametrize("pulses", [2, 10])
def test_noise_and_clutter_exceed_their_factor_as_rarely_as_asked(clutter: float, pulses: int) -> None:
    """200,000 draws of a speckle that all pulses share and of noise that none share; four standard errors of 2 %."""
    rng = np.random.default_rng(8)
    shared, noise = (rng.standard_normal((2, n, 200_000)) / np.sqrt(2.0) for n in (1, pulses))
    power = ((np.sqrt(clutter) * shared + noise) ** 2).sum(axis=0).mean(axis=0) / (1.0 + clutter)
    assert (power > clutter_level_factor(1e-2, clutter, pulses)).mean() == pytest.approx(1e-2, rel=0.09)

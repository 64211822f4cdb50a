"""The closed form of the studies, against that of the tests."""

import numpy as np
import pytest

from radar_service.study.stability.closed_form import pulse_response
from tests.reference import compressed_pulse


@pytest.mark.parametrize("window", ["none", "hamming", "blackman"])
def test_the_closed_form_of_the_studies_agrees_with_that_of_the_tests(window: str) -> None:
    """Two independent closed forms agree to rounding, 1e-12 of the peak."""
    delay = np.linspace(-2.1e-6, 2.1e-6, 1001)
    pulse = pulse_response(delay, 50e6, 2e-6, window)
    coefficients = {"none": (1.0,), "hamming": (0.54, 0.46), "blackman": (0.42, 0.5, 0.08)}[window]
    assert np.abs(pulse - compressed_pulse.compressed_pulse(delay, 50e6, 2e-6, coefficients)).max() < 1e-12

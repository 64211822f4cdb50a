"""The closed form of the studies, against that of the tests."""

import numpy as np
import pytest

from radar_service.study.compressed_pulse import compressed_chirp, cosine_coefficients
from tests.reference.compressed_pulse import compressed_pulse


@pytest.mark.parametrize("window", ["none", "hamming", "blackman", "blackman-harris"])
def test_the_closed_form_of_the_studies_agrees_with_that_of_the_tests(window: str) -> None:
    """Two derivations, about the middle of the overlap and of the pulse, agree to the rounding of 64 bits, 1e-12 of the peak."""
    delay = np.linspace(-2.1e-6, 2.1e-6, 1001)
    coefficients = {"none": (1.0,), "hamming": (0.54, 0.46), "blackman": (0.42, 0.5, 0.08)}
    coefficients["blackman-harris"] = (0.35875, 0.48829, 0.14128, 0.01168)
    expected = compressed_pulse(delay, 50e6, 2e-6, coefficients[window])
    assert np.abs(compressed_chirp(delay, 50e6, 2e-6, window) - expected).max() < 1e-12


def test_the_cosine_series_of_a_taylor_window_holds_its_sidelobes() -> None:
    """Source: Taylor 1955. The first sidelobe of 35 dB is 35 dB below the peak, to 0.6 dB of the near sidelobes' slope."""
    coefficients = np.array(cosine_coefficients("taylor"))
    u = np.linspace(0.0, 5.0, 5001)
    field = coefficients[0] * np.sinc(u)
    for m, a in enumerate(coefficients[1:], start=1):
        field += 0.5 * a * (np.sinc(u - m) + np.sinc(u + m))
    level = np.abs(field / field[0])
    first_null = int(np.flatnonzero(np.diff(level) > 0)[0])
    assert 20 * np.log10(level[first_null:].max()) == pytest.approx(-35.0, abs=0.6)

"""The closed form of the chart, against its integral and against other derivations."""

import numpy as np
import pytest

from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.patterns import PATTERNS, Table, Taylor
from radar_service.study.chart.closed_form import beam, closed_form_error_db, compressed_pulse
from tests.reference.compressed_pulse import compressed_pulse as other_pulse
from tests.reference.point_scene import other_chirp
from tests.scenes import radar
from tests.study.chart.settings import SMALL


@pytest.mark.parametrize("window", ["none", "hamming", "blackman", "taylor", "nuttall"])
def test_closed_form_is_its_integral(window: str) -> None:
    """The quadrature has 64-bit rounding (1e-15 a node, 1e-13 = -260 dB in all); a wrong sign or term gives -20 dB."""
    assert closed_form_error_db(radar(**SMALL, window=window)) < -250


@pytest.mark.parametrize(("modulation", "compression", "bound_db"), [("nlfm", "matched", -100), ("lfm", "inverse", -250)])
def test_the_forms_of_other_chirps_are_their_integrals(modulation: str, compression: str, bound_db: float) -> None:
    """The inverse filter leaves a closed form. A nonlinear chirp is summed over 64 samples per 1/B: (w dt)^2 / 24 = 4e-4 of
    its ends, which are 1 / (2 pi B T) = 1e-3 of the peak at this product of 100 to 200, and less in both together."""
    made = radar(**SMALL, window="nuttall", modulation=modulation, compression=compression)
    assert closed_form_error_db(made) < bound_db


@pytest.mark.parametrize(("modulation", "compression"), [("nlfm", "matched"), ("nlfm", "inverse")])
def test_the_forms_of_other_chirps_agree_with_those_of_the_tests(modulation: str, compression: str) -> None:
    """Two ways to sum the phase and to join samples agree to 2e-5 of the peak."""
    small = radar(**SMALL, window="nuttall", modulation=modulation, compression=compression)
    delay = np.linspace(-1.2, 1.2, 2001) * small.pulse
    expected = other_chirp(small)(delay, delay)
    np.testing.assert_allclose(compressed_pulse(delay, small), expected, atol=2e-5)


def test_closed_form_agrees_with_that_of_the_tests() -> None:
    """Two derivations, about the middle of the pulse and of the overlap, agree to the rounding of 64 bits."""
    small = radar(**SMALL)
    delay = np.linspace(-4.1e-6, 4.1e-6, 501)
    np.testing.assert_allclose(
        compressed_pulse(delay, small), other_pulse(delay, small.bandwidth, small.pulse, (0.54, 0.46)), atol=1e-12
    )


@pytest.mark.parametrize("pattern", [*PATTERNS.values(), Taylor(25.0, 3)], ids=lambda pattern: pattern.description)
def test_two_formulas_of_a_beam_agree(pattern: AntennaPattern) -> None:
    """The product of zeros and the sum of sincs agree to 1e-6 of boresight: -120 dB, below the error of every method."""
    offset = np.linspace(-np.pi, np.pi, 1001)[:-1]
    np.testing.assert_allclose(beam(offset, 0.07, pattern), pattern.gain(offset, 0.07), atol=1e-6)


def test_a_pattern_without_a_formula_uses_its_own_gain() -> None:
    """Offsets wrap around; equal to the rounding of 64 bits."""
    table = Table(((0.0, 1.0), (0.05, 0.4), (0.2, 0.001)))
    offset = np.linspace(-0.3, 0.3, 101)
    np.testing.assert_allclose(beam(offset + 2.0 * np.pi, 0.07, table), table.gain(offset), atol=1e-12)

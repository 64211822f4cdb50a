"""The closed form of the chart, against other derivations."""

import numpy as np
import pytest

from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.patterns import PATTERNS, Table, Taylor
from radar_service.study.chart.reference_surface import beam, compressed_pulse
from tests.reference.compressed_pulse import compressed_pulse as other_pulse
from tests.reference.point_scene import other_chirp
from tests.scenes import radar
from tests.study.chart.settings import SMALL


@pytest.mark.parametrize(("modulation", "compression"), [("nlfm", "matched"), ("nlfm", "inverse")])
def test_the_forms_of_other_chirps_agree_with_those_of_the_tests(modulation: str, compression: str) -> None:
    """Two ways to sum the phase and to join samples agree to 2e-5 of the peak."""
    small = radar(**SMALL, window="nuttall", modulation=modulation, compression=compression)
    delay = np.linspace(-1.2, 1.2, 2001) * small.pulse
    expected = other_chirp(small)(delay, delay)
    np.testing.assert_allclose(compressed_pulse(delay, small), expected, atol=2e-5)


@pytest.mark.parametrize(
    ("window", "series"), [("hamming", (0.54, 0.46)), ("nuttall", (0.355768, 0.487396, 0.144232, 0.012604))]
)
def test_closed_form_agrees_with_that_of_the_tests(window: str, series: tuple[float, ...]) -> None:
    """Two derivations, about the middle of the pulse and of the overlap, agree to the rounding of 64 bits."""
    small = radar(**SMALL, window=window)
    delay = np.linspace(-4.1e-6, 4.1e-6, 501)
    np.testing.assert_allclose(
        compressed_pulse(delay, small), other_pulse(delay, small.bandwidth, small.pulse, series), atol=1e-12
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

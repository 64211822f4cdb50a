"""Gain tables and azimuth sampling of antenna patterns."""

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.radar.antenna import AntennaPattern, azimuth_oversampling, grid_rows, interpolated_gain
from radar_service.radar.patterns import PATTERNS, Table, Taylor

BEAM = np.deg2rad(3.9)
TABLE = Table(((0.0, 1.0), (0.02, 0.1), (0.10, 0.001)))


def test_a_pattern_without_an_aperture_width_cannot_be_made() -> None:
    class Narrow(AntennaPattern):
        name = "narrow"

        def gain(self, offset: Floats | float, beamwidth: float) -> Floats:
            return np.exp(-np.abs(np.asarray(offset) / beamwidth))

    with pytest.raises(TypeError, match="aperture_width"):
        Narrow()


@pytest.mark.parametrize("pattern", [*PATTERNS.values(), Taylor(40.0, 6), TABLE])
def test_the_table_of_gains_is_the_pattern(pattern: AntennaPattern) -> None:
    """3e-6, as interpolated_gain promises, at offsets on both sides of boresight."""
    offset = np.random.default_rng(1).uniform(-np.pi, np.pi, 5000)
    np.testing.assert_allclose(interpolated_gain(offset, BEAM, pattern), pattern.gain(offset, BEAM), atol=3e-6)


def test_a_longer_aperture_has_a_narrower_uniform_beam() -> None:
    """Cosine taper: 1.189 lambda / a, so the uniform aperture as long has 0.8859 / 1.189 of the beamwidth (Balanis)."""
    assert PATTERNS["sinc2"].aperture_beamwidth(BEAM) == BEAM
    assert PATTERNS["cosine"].aperture_beamwidth(BEAM) == pytest.approx(BEAM * 0.8859 / 1.189, rel=1e-3)
    assert PATTERNS["cosine2"].half_power_width(BEAM) == BEAM and PATTERNS["cosine2"].description == "cosine2"


def test_a_sinc2_beam_has_its_band_in_grid_rows() -> None:
    """sinc^2 of half-power width b has spatial frequencies up to 2 x 0.8859 / (2 b) per radian each side: 0.564 b / step."""
    assert azimuth_oversampling(BEAM, 720) == pytest.approx(0.564 * BEAM / (2 * np.pi / 720), rel=1e-3)
    rows = 720
    offset = (np.arange(rows) * 2 * np.pi / rows + np.pi) % (2 * np.pi) - np.pi
    spectrum = np.abs(np.fft.fft(PATTERNS["sinc2"].gain(offset, BEAM)))
    band = rows / azimuth_oversampling(BEAM, rows) / 2
    order = np.abs(np.fft.fftfreq(rows) * rows)
    assert spectrum[order > band + 2].max() < 1e-3 * spectrum[0] < spectrum[order < 0.9 * band].min()


@pytest.mark.parametrize(
    ("azimuths", "beamwidth_deg", "multiple"), [(720, 3.9, 1), (720, 1.0, 3), (2048, 0.9, 2), (360, 0.4, 13)]
)
def test_grid_rows_are_the_minimum_that_leaves_two_thirds_of_the_band(
    azimuths: int, beamwidth_deg: float, multiple: int
) -> None:
    beamwidth = np.deg2rad(beamwidth_deg)
    rows = grid_rows(azimuths, beamwidth)
    assert rows == multiple * azimuths
    assert azimuth_oversampling(beamwidth, rows) >= 2.9
    assert multiple == 1 or azimuth_oversampling(beamwidth, rows - azimuths) < 2.9

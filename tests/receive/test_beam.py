"""The beam filter and its spectrum against the pattern itself."""

import numpy as np
import pytest

from radar_service.radar.antenna import grid_rows
from radar_service.receive.beam import azimuth_kernel, beam_filter, beam_spectrum
from radar_service.receive.gridding import Kernel, spread
from tests.reference.compressed_pulse import sinc2_beam


@pytest.mark.parametrize(("beamwidth_deg", "azimuths"), [(3.9, 720), (0.9, 2048), (1.0, 720), (0.4, 360), (25.0, 16)])
def test_the_filter_is_the_beam_around_the_full_circle(beamwidth_deg: float, azimuths: int) -> None:
    """A unit point at any azimuth, seen from every boresight, is the pattern itself; error energy below -70 dB of it
    (design: -78 dB at the oversampling that grid_rows keeps)."""
    beamwidth = np.deg2rad(beamwidth_deg)
    rows = grid_rows(azimuths, beamwidth)
    assert rows % azimuths == 0
    kernel, flat = azimuth_kernel(beamwidth, rows, 4), Kernel(4, 4.0)
    fine = np.linspace(-np.pi, np.pi, 200_001)
    expected = azimuths * np.mean(sinc2_beam(fine, beamwidth) ** 2)  # a beam between two spokes may show almost nothing
    for azimuth in np.random.default_rng(2).uniform(0, 2 * np.pi, 5):
        grid = spread(
            (rows, 8), np.array([azimuth * rows / (2 * np.pi)]), np.array([3.0]), np.ones(1, complex), kernel, flat
        )
        column = np.argmax(np.abs(grid).sum(axis=0))
        filtered = beam_filter(grid, lambda offset: sinc2_beam(offset, beamwidth), kernel, azimuths)[:, column]
        boresight = np.arange(azimuths) * 2 * np.pi / azimuths
        exact = sinc2_beam(boresight - azimuth, beamwidth)
        assert np.sum(np.abs(filtered - exact) ** 2) < 1e-7 * expected


def test_beam_spectrum_sums_to_the_boresight_gain() -> None:
    """The pattern at offset 0 is the sum of its Fourier coefficients: 1, up to what lies beyond the band (1e-4)."""
    spectrum = beam_spectrum(lambda offset: sinc2_beam(offset, np.deg2rad(3.9)), 720)
    assert spectrum.sum() / 720 == pytest.approx(1.0, abs=1e-4)

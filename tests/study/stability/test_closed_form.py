"""Fields of points in closed form, against those of the tests."""

import numpy as np
import pytest

from radar_service.study.stability.closed_form import echo_amplitude, error_db, point, point_fields, scene_of
from tests.reference.compressed_pulse import point_field


def test_the_field_of_a_point_agrees_with_that_of_the_tests() -> None:
    """Two derivations agree to 1e-8 of the peak: their constants of the beam have nine digits."""
    scene = scene_of(point(211.1, 111.7), environment={"earth": "flat"})
    radar, time = scene.radar, np.zeros(24)
    sample_range = (np.arange(radar.bins) + 0.5) * radar.range_step
    azimuth = np.arange(24) * radar.azimuth_step
    distance, bearing = np.full((24, 1), np.hypot(211.1, 111.7)), np.full((24, 1), np.arctan2(211.1, 111.7))
    expected = point_field(
        sample_range, azimuth, distance, bearing, echo_amplitude(radar, distance, 10.0), radar.wavelength, radar.bandwidth,
        radar.pulse, (0.54, 0.46), radar.beamwidth,
    )  # fmt: skip
    field = point_fields(scene, time, azimuth, sample_range)
    assert np.abs(field - expected).max() < 1e-8 * np.abs(expected).max()


def test_an_error_of_a_hundredth_is_minus_forty_decibels() -> None:
    """20 log10(0.01), to the rounding of 32 bits."""
    exact = np.array([3.0 + 4.0j])
    assert error_db((1.01 * exact).astype(np.complex64), exact) == pytest.approx(-40.0, abs=1e-3)

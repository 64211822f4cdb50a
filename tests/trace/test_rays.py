import numpy as np
import pytest
from scipy.stats import chisquare

from radar_service.frames import direction
from radar_service.random import generator
from radar_service.trace.rays import azimuth_offsets, elevation_offsets, printed_direction

BEAM = np.deg2rad(3.9)


@pytest.mark.parametrize("offsets", [azimuth_offsets, elevation_offsets])
def test_offsets_are_uniform_in_one_and_a_half_beamwidths_each_way(offsets) -> None:
    drawn = offsets(generator(1, 2), 20_000, BEAM)
    assert drawn.shape == (20_000,) and np.abs(drawn).max() <= 1.5 * BEAM
    counts, _ = np.histogram(drawn, bins=20, range=(-1.5 * BEAM, 1.5 * BEAM))
    assert chisquare(counts).pvalue > 1e-3  # level of the test; the seed is fixed


def test_printed_direction_counts_from_x_counter_clockwise() -> None:
    thirty, ten = np.deg2rad(30), np.deg2rad(10)
    expected = [np.cos(ten) * np.cos(thirty), np.cos(ten) * np.sin(thirty), np.sin(ten)]
    assert printed_direction(thirty, ten) == pytest.approx(expected, abs=1e-15)  # rounding; eq. 6
    assert printed_direction(0.0, 0.0) == pytest.approx([1, 0, 0], abs=1e-15)


def test_printed_and_project_directions_agree_at_45_degrees_only() -> None:
    azimuth = np.deg2rad(np.arange(0, 360, 15.0))
    same = np.all(np.isclose(printed_direction(azimuth, 0 * azimuth), direction(azimuth, 0 * azimuth), atol=1e-12), axis=1)
    assert np.rad2deg(azimuth[same]).round() == pytest.approx([45, 225])

import numpy as np
import pytest
from scipy import stats
from scipy.stats import chisquare

from radar_service.numerics.frames import direction
from radar_service.numerics.random import generator
from radar_service.trace.ray_sampling import (
    SAMPLERS,
    azimuth_offsets,
    elevation_offsets,
    full_circle_rays,
)
from tests.reference.printed_formulas import printed_direction

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


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize("tilt", [0.0, 0.1])
def test_a_turn_of_rays_covers_its_part_of_the_sphere(sampler: str, tilt: float) -> None:
    """The solid angles add up to 2 pi (sin high - sin low) within 5 sigma of independent rays: cos varies by less than
    half its mean over the box, so sigma < 0.5 / sqrt(M)."""
    rays = full_circle_rays(sampler, np.random.default_rng(1), 2000, 0.07, 0.4, tilt)
    box = 2 * np.pi * (np.sin(tilt + 0.6) - np.sin(tilt - 0.6))
    assert rays.solid_angle.sum() == pytest.approx(box, rel=2.5 / np.sqrt(len(rays)))
    assert np.all(np.abs(rays.elevation - tilt) <= 0.6) and np.all((rays.azimuth >= 0) & (rays.azimuth < 2 * np.pi))
    assert 2000 * 2 * np.pi / 0.21 * 0.99 < len(rays) < 2 * 2000 * 2 * np.pi / 0.21


def test_a_box_over_the_zenith_ends_there() -> None:
    rays = full_circle_rays("stratified", np.random.default_rng(1), 500, 0.1, 1.0, 0.5)
    assert rays.elevation.max() <= np.pi / 2 and rays.elevation.min() < -0.95
    assert rays.solid_angle.min() >= 0.0


def test_each_sampler_keeps_its_law() -> None:
    """Counts in 16 x 8 equal cells, 64 to a cell: independent rays scatter as chi-square (level 1e-4, two-sided), jittered
    ones and a net have exactly 64 in each."""
    across, up = 128, 64
    for sampler, square in SAMPLERS.items():
        points = square(np.random.default_rng(7), across, up)
        assert points.shape == (across * up, 2)
        counts, _, _ = np.histogram2d(points[:, 0], points[:, 1], bins=(16, 8), range=((0, 1), (0, 1)))
        spread = float(np.sum((counts - 64) ** 2 / 64))
        if sampler == "rays":
            assert stats.chi2(127).ppf(0.5e-4) < spread < stats.chi2(127).ppf(1 - 0.5e-4)
        else:
            assert spread == 0.0


def test_too_many_rays_are_refused() -> None:
    with pytest.raises(ValueError, match=r"radar\.rays: 1000000 to a box of 3 x 0.5.* at most 8000000: lower rays"):
        full_circle_rays("rays", np.random.default_rng(0), 1_000_000, np.deg2rad(0.5), 0.4, 0.0)

"""The boundaries that the studies find, each held where theory or an independent rule puts it."""

from functools import cache

import pytest

from radar_service.constants import KNOT
from radar_service.study import stability
from radar_service.study.stability.finding import Finding

WAVELENGTH = 299_792_458.0 / 9.41e9
EARTH = 4.0 / 3.0 * 6_371_000.0


@cache
def found(name: str) -> Finding:
    """What the study of that name finds in its quick run."""
    return {study.__name__: study for study in stability.STUDIES}[name](1)


# Boundary of each region, and the relative tolerance: half a step of the drive where it is interpolated, and its origin.
BOUNDARIES: dict[str, tuple[float, float]] = {
    "float32_range": (1024.0, 0.0),  # half a unit in the last place of 2^10 m is 30.5 um x 2 = 1.38 degrees; below it 0.69
    "triangle_size": (1e-3, 0.05),  # legs squared = epsilon 1e-6; rays up to 23 degrees off the normal see 4 % less
    "sliver_width": (1e-7, 0.05),  # 10 m x width = epsilon
    "wide_maps": (150e3, 0.35),  # measured 157 km: 2^-24 of half of it, 5 mm, over 2 mm slack; the warning comes at 150 km
    "missed_targets": (46.4, 0.05),  # (1 - p)^2000 = 0.05: p = 1.5e-3, R^2 = 1 / (p x 0.2042 x 1.3090): 49.9 m; chord -7 %
    "missed_sizes": (20.0, 0.05),  # the same p at 1 km: side = 1000 m x sqrt(p x 0.2673 sr); chord as above
    "undersampled_facet": (1.9, 0.03),  # embree.md: 0.43 dB at 2 to a wavelength (63 rays), 1.8 at 1
    "sampling_rate": (1.09, 0.02),  # measured; 1.1 is where the scene is warned of
    "short_chirps": (13.5, 0.04),  # measured; 14 is where the scene is warned of
    "far_end": (347.2, 0.02),  # measured; cT/2 = 300 m before the end the pulse begins to reach over
    "dynamic_range": (860.8, 0.02),  # measured on the closed form: a Hamming window, 60 dB, 10 us
    "overflow": (3.4028e38, 1e-3),  # the largest number of IEEE 754 single precision
    "underflow": (7e-44, 0.8),  # half of the smallest one, 1.4e-45, is one per cent of 7e-44; each sum rounds anew
    "narrow_beam": (1.0 / 0.72, 0.01),  # two-way half-power width of a sinc^2 beam: 0.7200 beamwidths (DESIGN row 2)
    "range_to_zero": (1.0, 0.01),  # range_min_m
    "two_ray_null": (2949.0, 0.02),  # measured on this grid: 2^-12 m, a unit of 2^11 m, is 2.8 degrees
    "null_depth": (0.66, 0.02),  # measured
    "flat_earth": (690.0, 0.02),  # measured on this grid
    "horizon": (16_770.0, 0.005),  # see test_last_quarter_wavelength
    "divergence_edge": (18_052.0, 0.005),  # see test_least_grazing_angle
    "roughness": (1.5625, 0.04),  # I0(g^2 / 2) = 10^(3/20); the grid has 8 steps to a decade
    "pixel_size": (1.567, 0.05),  # measured
    "sequence_numbers": (2.0**53 / (288 * 86_400), 1e-3),  # doubles hold every whole number up to 2^53
    "numbered_anew": (0.5, 0.0),  # at once
    "slow_turns": (0.0971, 0.05),  # measured: 16 spokes of 12.9 s at 12 kn are 1270 m
    "doppler_in_the_pulse": (0.5 * WAVELENGTH / 2e-3 / KNOT, 1e-6),  # lambda / (4 T): 15.48 kn for 1 ms
}


@pytest.mark.parametrize("name", BOUNDARIES)
def test_a_boundary_stands_where_it_was_found(name: str) -> None:
    where, tolerance = BOUNDARIES[name]
    assert found(name).boundary == pytest.approx(where, rel=max(tolerance, 1e-9))


NOWHERE = (
    "shared_edges", "grazing_sight", "range_ends", "north", "headings", "spokes_lost", "fast_targets", "months",
    "numbers_at_the_end", "small_pixels",
)  # fmt: skip


@pytest.mark.parametrize("name", NOWHERE)
def test_some_regions_have_no_end_where_they_are_driven(name: str) -> None:
    assert found(name).boundary is None


def test_every_study_has_its_boundary_held() -> None:
    assert {study.__name__ for study in stability.STUDIES} == {*BOUNDARIES, *NOWHERE}

"""The short modules of scattering/physical_optics, each under its name."""

import math

import numpy as np
import pytest

from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.plane_echoes import BEAM_SHARE, EXTENT_SHARE, MAX_BEND, RANGE_SHARE, EdgeLimits
from radar_service.world.poses import BodyPose

# body_legs: legs in a body's frame: straight from an eye, and turned with the body.
ANTENNA = np.array([0.0, 0.0, 15.0])
MIDDLE = np.array([0.5, 3.0, 2.0])


@pytest.mark.parametrize("earth_radius", [np.inf, 8.5e6], ids=["flat", "curved"])
@pytest.mark.parametrize("by_sea", [False, True])
@pytest.mark.parametrize("heading", [0.0, 1.1])
def test_a_leg_is_straight_from_its_eye(by_sea: bool, heading: float, earth_radius: float) -> None:
    """Distances from the eye are lengths of the leg: over the flat sea to rounding, over the curved one, at 220 m, to 1e-5 m
    within 0.6 m of the middle: the sea spreads rays by some 1e-4 more, and they rise by 220 m / 8500 km more, over 1 m."""
    pose = BodyPose(np.array([130.0, 180.0, 1.0]), heading)
    leg = BodyLeg(by_sea, pose, ANTENNA, earth_radius)
    points = MIDDLE + np.random.default_rng(1).uniform(-0.6, 0.6, size=(20, 3))
    distance = np.linalg.norm(points - leg.eye(MIDDLE), axis=1)
    np.testing.assert_allclose(distance, leg.length(points), rtol=0.0, atol=1e-9 if earth_radius == np.inf else 5e-5)


# edge_limits: how fine fields of metal have to be, by what bounds edges and cells.
LIMITS = EdgeLimits(range_cell=7.5, beamwidth=math.radians(1.2), wavelength=0.032, extent=100.0)


def test_cells_are_the_same_throughout_half_an_octave_and_bounded() -> None:
    """A quarter of the range cell far away, the share of the beam near by, of a small body its own."""
    near, same, next_one = LIMITS.cell(np.array([300.0, 350.0, 400.0]))
    assert near == same < next_one
    assert near == pytest.approx(BEAM_SHARE * math.radians(1.2) * 2.0**8)
    assert LIMITS.cell(np.array(50_000.0)) == RANGE_SHARE * 7.5
    assert LIMITS._replace(extent=2.0).cell(np.array(50_000.0)) == EXTENT_SHARE * 2.0


@pytest.mark.parametrize("distance", [100.0, 1000.0, 4000.0])
def test_over_half_the_longest_edge_the_two_way_phase_bends_by_the_limit(distance: float) -> None:
    half = LIMITS.longest.bend * math.sqrt(distance) / 2.0
    there = 2.0 * math.pi / 0.032 * 2.0 * (math.hypot(distance, half) - distance)
    assert there == pytest.approx(MAX_BEND, rel=1e-3)


def test_coherence_is_the_longer_of_cell_and_edge() -> None:
    for nearest in (20.0, 500.0, 20_000.0):
        edge, wide, bend = LIMITS.longest
        longest = min(edge, wide * nearest, bend * math.sqrt(nearest))
        assert LIMITS.coherence(nearest) == max(float(LIMITS.cell(np.array(nearest))), longest)

"""Legs in a body's frame: straight from an eye, and turned with the body."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.world.poses import BodyPose

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

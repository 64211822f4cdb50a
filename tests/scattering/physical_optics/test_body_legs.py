"""Legs in a body's frame: turned with it, and expanded to second order."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.world.poses import BodyPose

ANTENNA = np.array([0.0, 0.0, 15.0])
POINTS = np.array([[0.5, 3.0, 2.0], [-1.0, 0.0, 7.0]])


@pytest.mark.parametrize("by_sea", [False, True])
@pytest.mark.parametrize("heading", [0.0, 1.1])
def test_detours_are_differences_of_lengths(by_sea: bool, heading: float) -> None:
    """1 m aside at 220 m: third order leaves 1 / 2 R^2 = 1e-5 m."""
    pose = BodyPose(np.array([130.0, 180.0, 1.0]), heading)
    leg = BodyLeg(by_sea, pose, ANTENNA, 8.5e6, lambda points, triangle: np.ones(len(points), dtype=np.bool_))
    rays = leg.rays(POINTS)
    rng = np.random.default_rng(1)
    offset = rng.uniform(-0.6, 0.6, size=(5, 2, 3))
    exact = np.stack([leg.length(POINTS + one) - rays.length for one in offset])
    ways = np.moveaxis(offset, -1, 0)
    np.testing.assert_allclose(rays.along(ways) - rays.sags(ways), exact, atol=1e-5)
    for one, other in ((rays.direction, rays.level), (rays.direction, rays.upright), (rays.level, rays.upright)):
        np.testing.assert_allclose(np.einsum("ij,ij->i", one, other), 0.0, atol=1e-12)
    assert (rays.upright[:, 2] > 0.9).all() and (rays.level[:, 2] == 0.0).all()

"""Occlusion by many bodies at an instant, against one body after the other."""

from typing import Any

import numpy as np
import pytest

from radar_service.trace.moving_occluders import MovingOccluders
from radar_service.trace.occluder import Occluder
from radar_service.world.poses import BodyPoses, pose_at
from tests.reference.legs import reflection_points
from tests.scenes import scene

EARTH = 4 / 3 * 6_371_000.0
ANTENNA = np.array([0.0, 0.0, 15.0])
BOX = {"shape": "box", "width_m": 20, "height_m": 12, "rcs_dbsm": 0, "speed_kn": 10}
FLEET = [
    {
        **BOX,
        "name": f"b{k}",
        "position_m": [45 * (k % 7) - 140, 150 + 31 * k, 0],
        "length_m": 20 + k % 3,
        "course_deg": 9 * k,
    }
    for k in range(40)
]


@pytest.mark.parametrize("sway", [{}, {"roll_deg": 8, "roll_period_s": 7}], ids=["upright", "rolling"])
@pytest.mark.parametrize("by_sea", [False, True], ids=["direct", "by sea"])
def test_many_at_once_occlude_what_each_occludes(by_sea: bool, sway: dict[str, Any]) -> None:
    """40 boxes, of three sizes, against one after the other: their own surfaces and those of others."""
    bodies = scene([{**body, **sway} for body in FLEET]).bodies
    made, time, earth, count = MovingOccluders(bodies, EARTH), 3.0, EARTH, 2000
    rng = np.random.default_rng(5)
    key, poses = rng.integers(len(bodies), size=count), BodyPoses(bodies).at(np.full(1, time))
    triangle = rng.integers(12, size=count)
    corners = np.array([bodies[k].mesh.vertices[bodies[k].mesh.faces[t]] for k, t in zip(key, triangle, strict=True)])
    position = poses.map_from_bodies(0, np.einsum("ec,eci->ei", rng.dirichlet(np.ones(3), count), corners), key)
    position[:, 2] = np.maximum(position[:, 2], 0.5)
    distance = np.hypot(position[:, 0], position[:, 1])
    foot = reflection_points(position, ANTENNA, earth)[0] if by_sea else None
    result = made.occluded_surfaces(
        key, position, distance, lambda own: (triangle[own], triangle[own] + 1), foot, ANTENNA, time
    )
    expected = np.zeros(count, dtype=np.bool_)
    for k, body in enumerate(bodies):
        one, pose, own = Occluder(body.mesh, earth), pose_at(body, time), key == k
        origin = np.broadcast_to(ANTENNA, position.shape) if foot is None else foot
        expected[own] |= one.self_occluded(pose, origin[own], position[own], (triangle[own], triangle[own] + 1))
        expected[~own] |= one.occludes(pose, origin[~own], position[~own])
        if foot is not None:
            expected |= one.occludes(pose, ANTENNA, foot)
    assert np.array_equal(result, expected)
    assert 100 < np.count_nonzero(result) < count - 100

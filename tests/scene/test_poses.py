"""Poses of many bodies are those of each body."""

import numpy as np
import pytest

from radar_service.frames import map_from_body
from radar_service.scene.poses import BodyPoses, map_from_bodies
from tests.scenes import point, scene


def test_poses_are_those_of_each_motion() -> None:
    """At rest, on a straight course, on a polygon and on arcs, before and after its end; to rounding of 1 km."""
    corners = [{"position_m": list(p), "speed_kn": 12} for p in [(190, 230), (320, 230)]]
    made = scene(
        [
            point("rest", 1, 2, heading_deg=-30), point("straight", 3, 4, course_deg=50, speed_kn=9, heading_deg=-20),
            point("legs", 190, 160, waypoints=corners), point("arcs", 190, 160, waypoints=corners, turn_radius_m=40),
        ]
    )  # fmt: skip
    time = np.linspace(0, 60, 23)
    poses = BodyPoses(made.bodies).at(time)
    for b, body in enumerate(made.bodies):
        pose = body.motion.pose(time)
        np.testing.assert_allclose(poses.position[:, b], pose.position, atol=1e-12)
        np.testing.assert_allclose(poses.heading[:, b], pose.heading, atol=1e-15)


def test_points_are_transformed_as_by_the_frame() -> None:
    rng = np.random.default_rng(1)
    points, body = rng.normal(size=(40, 3)), rng.integers(0, 3, 40)
    position, heading = rng.normal(size=(3, 3)) * 100, np.array([0.0, 1.2, 5.0])
    transformed = map_from_bodies(points, body, position, heading)
    for b in range(3):
        expected = map_from_body(points[body == b], position[b], float(heading[b]))
        assert transformed[body == b] == pytest.approx(expected, abs=1e-12)

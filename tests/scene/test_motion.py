"""Properties of a motion."""

import numpy as np
import pytest

from radar_service.constants import KNOT
from radar_service.scene.motion import Motion, Pose
from radar_service.scene.sway import Sway
from tests.scenes import point, scene


def test_the_top_speed_is_that_along_the_arcs() -> None:
    """A square whose corners' arcs meet is a circle: no leg is straight, and a chord of a quarter is 0.9 of its arc."""
    corners = [{"position_m": list(p), "speed_kn": 15.6} for p in [(0, 200), (200, 200), (200, 0)]]
    circle = point("t", 0, 0, waypoints=corners, turn_radius_m=100, loop=True)
    made = scene([circle], radar={"pulse_s": 1e-3})
    assert made.bodies[0].motion.top_speed == pytest.approx(15.6 * KNOT, rel=1e-12)  # rounding
    assert any("Doppler" in warning for warning in made.warnings)  # from 15.48 kn on: lambda / (4 T)


def test_the_course_of_a_body_at_rest_is_its_heading() -> None:
    pose = Pose(np.zeros((2, 3)), np.array([[0.0, 0, 0], [0, -3.0, 0]]), np.array([1.0, 1.0]))
    np.testing.assert_allclose(pose.course, [1.0, np.pi])
    np.testing.assert_array_equal(pose.speed, [0.0, 3.0])


def test_yaw_adds_to_the_heading_and_is_no_rest() -> None:
    sway = Sway(np.array([0.0, 0.0, 0.1, 0.0]), np.array([1.0, 1.0, 8.0, 1.0]))
    motion = Motion(np.zeros(1), np.zeros((1, 3)), np.array([1.0]), sway=sway)
    np.testing.assert_allclose(motion.pose(np.array([0.0, 2.0, 6.0])).heading, [1.0, 1.1, 0.9])
    assert not motion.at_rest and Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1)).at_rest


def test_a_motion_is_even_where_a_straight_line_over_time_fits_it() -> None:
    """One that starts at 5 s is so from then on; a sway never is; one at rest always."""
    around, after = np.array([4.0, 6.0, 8.0]), np.array([5.0, 6.0, 8.0])
    straight = Motion(np.array([5.0]), np.zeros((1, 3)), np.zeros(1), np.array([3.0, 4.0, 0.0]))
    swaying = Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), sway=Sway(np.full(4, 0.1), np.full(4, 8.0)))
    assert not straight.is_even(around) and straight.is_even(after)
    assert not swaying.is_even(after) and Motion(np.full(1, 5.0), np.zeros((1, 3)), np.zeros(1)).is_even(around)

"""Properties of a motion."""

from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.constants import KNOT
from radar_service.world.motion import Motion, Pose, segment_headings
from radar_service.world.sway import Sway
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


def test_corners_lie_between_legs_and_laps() -> None:
    """A loop of 10, 10 and 20 s; before the start a lap ends. At rest and on one leg there are none."""
    knots = np.array([(0.0, 0, 0), (0, 10, 0), (10, 10, 0), (0, 0, 0)])
    loop = Motion(np.array([0.0, 10.0, 20.0, 40.0]), knots, segment_headings(knots, None), period=40.0)
    times = np.array([-1.0, 0.0, 5.0, 10.0, 15.0, 19.9, 20.1, 39.0, 40.0, 41.0, 55.0, 79.9, 80.0])
    assert np.flatnonzero(loop.corners(times)).tolist() == [0, 2, 5, 7, 9, 10, 11]
    once = replace(loop, period=None)
    assert np.flatnonzero(once.corners(times)).tolist() == [0, 2, 5, 7]
    straight = Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), np.ones(3))
    assert np.flatnonzero(straight.corners(times)).tolist() == [0]
    assert not replace(straight, final_velocity=np.zeros(3)).corners(times).any()


def test_corners_are_where_the_pose_jumps_to_the_last_digit() -> None:
    """Laps of 0.1 s, which no time holds exactly: each jump of the heading has a corner, and no other step."""
    knots = np.array([(0.0, 0, 0), (0, 1, 0), (0, 0, 0)])
    loop = Motion(np.array([0.0, 0.05, 0.1]), knots, segment_headings(knots, None), period=0.1)
    times = np.arange(4000) * 0.05 / 7.0 + 1e5
    np.testing.assert_array_equal(loop.corners(times), np.diff(loop.pose(times).heading) != 0.0)

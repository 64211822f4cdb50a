"""Motion from course and speed, and from waypoints."""

import math

import numpy as np
import pytest

from radar_service.numerics.constants import KNOT
from radar_service.scene_file.describe import describe
from radar_service.scene_file.model.moving import WaypointModel
from radar_service.scene_file.routes import constant_motion, motion_from_waypoints
from radar_service.world.steered_motion import SteeredMotion, SteeringLimits
from tests.scenes import point, scene

START = np.array([100.0, -50.0, 2.0])

TINY = 1e-9  # m: rounding of positions of a few km in float64


def waypoints(*stops: tuple[float, float, float]) -> list[WaypointModel]:
    return [WaypointModel(position_m=(east, north), speed_kn=speed) for east, north, speed in stops]


@pytest.mark.parametrize(
    "heading, course, expected", [(30.0, None, (30, 30)), (None, 40.0, (40, 40)), (30.0, 40.0, (30, 40))]
)
def test_heading_and_course_default_to_each_other(
    heading: float | None, course: float | None, expected: tuple[float, float]
) -> None:
    pose = constant_motion(START, heading, course, 1.0).pose(0.0)
    np.testing.assert_allclose(np.rad2deg([pose.heading[0], pose.course[0]]), expected, rtol=1e-12)


def test_waypoints_use_the_speed_of_the_leg_that_leads_there() -> None:
    motion = motion_from_waypoints(waypoints((100, 950, 10), (600, 950, 20)), START, None, loop=False)
    first, second = 1000 / (10 * KNOT), 500 / (20 * KNOT)
    pose = motion.pose(np.array([0.0, first / 2, first + second / 2, first + second, first + second + 99]))
    np.testing.assert_allclose(pose.position[:, :2], [[100, -50], [100, 450], [350, 950], [600, 950], [600, 950]], atol=TINY)
    np.testing.assert_allclose(pose.speed / KNOT, [10, 10, 20, 0, 0], atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(pose.heading), [0, 0, 90, 90, 90], atol=1e-9)
    np.testing.assert_array_equal(pose.position[:, 2], 2.0)


def test_a_loop_returns_at_the_last_speed_and_repeats() -> None:
    motion = motion_from_waypoints(waypoints((100, 950, 10), (100, 450, 20)), START, None, loop=True)
    period = 1000 / (10 * KNOT) + 500 / (20 * KNOT) + 500 / (20 * KNOT)
    assert motion.period == pytest.approx(period)
    np.testing.assert_allclose(motion.pose(period - 10.0).position, [[100, -50 + 200 * KNOT, 2]], atol=TINY)
    np.testing.assert_allclose(motion.pose(7 * period + 30.0).position, motion.pose(30.0).position, atol=1e-6)


def test_a_waypoint_at_the_position_makes_no_leg_and_a_given_heading_stays() -> None:
    motion = motion_from_waypoints(waypoints((100, -50, 10), (100, -150, 10), (100, -150, 5)), START, 45.0, loop=False)
    assert motion.time.size == 2
    np.testing.assert_allclose(np.rad2deg(motion.pose([0.0, 1.0, 1e4]).heading), 45.0)
    still = motion_from_waypoints(waypoints((100, -50, 10)), START, None, loop=True)
    assert still.at_rest and still.period is None


def test_what_is_declared_steerable_has_its_limits_in_si_units() -> None:
    ship = scene([point("t", 0, 300, speed_kn=5, course_deg=90, steerable={"max_speed_kn": 7, "max_turn_rate_deg_s": 3})])
    motion = ship.bodies[0].motion
    assert isinstance(motion, SteeredMotion) and motion.pose(10.0).position[0, 0] == pytest.approx(50 * KNOT)
    assert motion.limits == SteeringLimits(7 * KNOT, math.radians(3))
    assert "steerable up to 7 kn and 3 degrees/s" in describe(ship)
    defaults = scene(own_ship={"steerable": {}}).own_ship
    assert isinstance(defaults, SteeredMotion) and defaults.limits == SteeringLimits(30 * KNOT, math.radians(5))
    assert not isinstance(scene(own_ship={}).own_ship, SteeredMotion)

"""Rounded corners against the geometry of circles."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.constants import KNOT
from radar_service.world.motion import Motion
from tests.scenes import point, scene

CORNERS = [{"position_m": list(p), "speed_kn": 10} for p in [(0, 400), (300, 400), (500, 200)]]


def motion(**more: object) -> Motion:
    return scene([point("t", 0, 0, waypoints=CORNERS, **more)]).bodies[0].motion


def test_the_route_is_smooth_and_tangent_to_circles() -> None:
    """Speed is 10 kn throughout, position and course never jump, the turn rate is v / r or 0; tolerances are those of the
    differences taken: v dt, and v dt / r of course per step."""
    track, dt = motion(turn_radius_m=80), 0.01
    time = np.arange(0.0, track.time[-1] - dt, dt)
    pose = track.pose(time)
    steps = np.linalg.norm(np.diff(pose.position, axis=0), axis=1)
    np.testing.assert_allclose(steps, 10 * KNOT * dt, rtol=1e-6)  # a chord is shorter than its arc by (v dt / r)^2 / 24
    np.testing.assert_allclose(pose.speed, 10 * KNOT, rtol=1e-12)
    turned = np.diff(np.unwrap(pose.heading)) / dt
    rate = 10 * KNOT / 80
    assert np.all(
        np.isclose(turned, rate, rtol=1e-6) | np.isclose(turned, 0, atol=1e-9) | (np.abs(turned - rate / 2) < rate / 2)
    )
    assert np.count_nonzero(np.isclose(turned, rate, rtol=1e-6)) == pytest.approx((np.pi / 2 + np.pi / 4) / rate / dt, abs=6)
    np.testing.assert_allclose(pose.heading, pose.course, atol=1e-9)
    corner = np.hypot(pose.position[:, 0] - 80, pose.position[:, 1] - 320)
    inside = (pose.position[:, 0] > 0) & (pose.position[:, 0] < 80) & (pose.position[:, 1] > 320)
    assert inside.any()
    np.testing.assert_allclose(corner[inside], 80, rtol=1e-12)


def test_the_period_of_a_loop_is_its_length_over_speed() -> None:
    """A loop of 4 legs: perimeter less 2 r tan(d/2) at each corner, plus r d for the arc; it closes on itself."""
    track = motion(turn_radius_m=50, loop=True)
    stops = np.array([(0, 0), (0, 400), (300, 400), (500, 200), (0, 0)], dtype=float)
    legs = np.diff(stops, axis=0)
    course = np.arctan2(legs[:, 0], legs[:, 1])
    corner = np.abs((np.roll(course, -1) - course + np.pi) % (2 * np.pi) - np.pi)
    length = np.linalg.norm(legs, axis=1).sum() - np.sum(2 * 50 * np.tan(corner / 2)) + np.sum(50 * corner)
    assert track.period == pytest.approx(length / (10 * KNOT), rel=1e-12)
    ends = track.pose(np.array([0.0, track.period * (1 - 1e-12)]))
    np.testing.assert_allclose(ends.position[0], ends.position[1], atol=1e-6)
    np.testing.assert_allclose(ends.heading[0], ends.heading[1], atol=1e-6)


def test_a_given_heading_stays_and_a_straight_waypoint_makes_no_arc() -> None:
    crab = motion(turn_radius_m=80, heading_deg=33).pose(np.linspace(0, 100, 50))
    np.testing.assert_allclose(crab.heading, np.deg2rad(33), rtol=1e-15)
    straight = [{"position_m": [0, y], "speed_kn": 10} for y in (100, 200)]
    track = scene([point("t", 0, 0, waypoints=straight, turn_radius_m=80)]).bodies[0].motion
    assert len(track.time) == 3 and track.pose(track.time[-1] + 5).speed[0] == 0


@pytest.mark.parametrize(
    ("corners", "more", "message"),
    [
        (CORNERS, {"turn_radius_m": 800}, r"leg of 300.0 m to waypoints\[1\]; at most 212.1 m is possible there"),
        ([CORNERS[0], {"position_m": [0, 1], "speed_kn": 9}], {"turn_radius_m": 5}, "reverses its course"),
        ([], {"turn_radius_m": 5}, "turn_radius_m: only corners at waypoints are rounded"),
    ],
    ids=["too wide", "right about", "no waypoints"],
)  # fmt: skip
def test_radii_that_do_not_fit_are_refused(corners: list[object], more: dict[str, float], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        scene([point("t", 0, 0, waypoints=corners, **more)])

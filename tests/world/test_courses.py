"""Manoeuvres and constant turns against small steps of time, and rounded corners against the geometry of circles."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.closest_approach import closest_approach
from radar_service.numerics.constants import KNOT
from radar_service.plan.body_errors import body_run
from radar_service.world.motion import Motion
from tests.scenes import point, scene

DT = 1e-3  # s; the mean of two ends makes each step's error of third order: below 1e-6 m in these runs


def motion(**keys: Any) -> Motion:
    return scene([point("t", 100, -50, **keys)]).bodies[0].motion


def test_manoeuvres_are_the_sum_of_small_steps() -> None:
    """Course 20 at 10 kn; from 5 s on to 300 by port at 4 degrees/s, 12 kn from 10 s on, cut off at 20 s by a turn to starboard
    at 2 degrees/s, straight on from 50 s."""
    track = motion(
        course_deg=20, speed_kn=10,
        manoeuvre=[{"time_s": 5, "course_deg": 300, "turn_rate_deg_s": 4}, {"time_s": 10, "speed_kn": 12},
                   {"time_s": 20, "turn_rate_deg_s": 2}, {"time_s": 50, "turn_rate_deg_s": 0}],
    )  # fmt: skip
    time = np.arange(0.0, 60.0, DT)
    middle = time + DT / 2
    turned = [20 - 4 * np.clip(middle - 5, 0, 15), 2 * np.clip(middle - 20, 0, 30)]
    course = np.deg2rad(np.sum(turned, axis=0))
    speed = np.where(middle < 10, 10, 12) * KNOT
    steps = DT * speed[:, None] * np.stack([np.sin(course), np.cos(course)], axis=1)
    expected = np.concatenate([[[100.0, -50.0]], [100.0, -50.0] + np.cumsum(steps, axis=0)])[:-1]
    pose = track.pose(time)
    np.testing.assert_allclose(pose.position[:, :2], expected, atol=1e-4)
    np.testing.assert_allclose(np.exp(1j * pose.heading), np.exp(1j * course), atol=np.deg2rad(4 * DT))
    np.testing.assert_array_equal(pose.position[:, 2], 15.0)


def test_a_speed_change_keeps_the_turn_that_is_under_way_to_its_course() -> None:
    """The manoeuvre at 10 s changes the speed alone: the turn goes on as it was, and ends at its course."""
    keys: dict[str, Any] = {"course_deg": 20, "speed_kn": 10}
    turn = {"time_s": 5, "course_deg": 300, "turn_rate_deg_s": 4}
    track = motion(**keys, manoeuvre=[turn, {"time_s": 10, "speed_kn": 12}])
    np.testing.assert_allclose(
        np.rad2deg(track.pose(np.array([5.0, 15.0, 25.0, 99.0])).heading), [20, 340, 300, 300], atol=1e-9
    )
    np.testing.assert_allclose(track.pose(np.array([9.0, 11.0, 99.0])).speed, np.array([10, 12, 12]) * KNOT, rtol=1e-12)


def test_a_course_without_a_rate_is_taken_at_once_and_half_a_circle_turns_to_starboard() -> None:
    track = motion(course_deg=0, speed_kn=10, manoeuvre=[{"time_s": 10, "course_deg": 180, "turn_rate_deg_s": 3}])
    assert np.rad2deg(track.pose(40.0).heading[0]) == pytest.approx(90)
    at_once = motion(course_deg=0, speed_kn=10, manoeuvre=[{"time_s": 10, "course_deg": 90, "speed_kn": 20}])
    pose = at_once.pose(np.array([9.999, 10.0, 11.0]))
    np.testing.assert_allclose(np.rad2deg(pose.heading), [0, 90, 90], atol=1e-9)
    np.testing.assert_allclose(pose.speed, np.array([10, 20, 20]) * KNOT)


def test_a_manoeuvre_at_time_0_holds_from_the_start() -> None:
    track = motion(course_deg=0, speed_kn=10, manoeuvre=[{"time_s": 0, "course_deg": 90}])
    np.testing.assert_allclose(track.pose(np.array([0.0, 5.0])).heading, np.pi / 2)
    assert len(track.time) == 1


@pytest.mark.parametrize("rate", [3.0, -0.5])
def test_a_constant_turn_goes_round_a_circle_for_ever(rate: float) -> None:
    track = motion(course_deg=30, speed_kn=20, turn_rate_deg_s=rate)
    radius, turn = 20 * KNOT / np.deg2rad(rate), np.deg2rad(30)
    centre = np.array([100, -50]) + radius * np.array([np.cos(turn), -np.sin(turn)])
    time = np.linspace(0, 3000, 100)
    pose = track.pose(time)
    np.testing.assert_allclose(np.hypot(*(pose.position[:, :2] - centre).T), abs(radius), rtol=1e-12)
    np.testing.assert_allclose(track.turn_rate(time), np.deg2rad(rate))
    assert not track.at_rest and track.top_speed == pytest.approx(20 * KNOT)
    np.testing.assert_allclose(np.rad2deg(pose.heading), (30 + rate * time) % 360, atol=1e-7)


def test_a_buoy_may_turn_in_place() -> None:
    track = motion(course_deg=0, turn_rate_deg_s=6)
    assert not track.at_rest and track.pose(15.0).heading[0] == pytest.approx(np.pi / 2)
    np.testing.assert_array_equal(track.pose(15.0).position, [[100.0, -50.0, 15.0]])


def test_drift_is_course_minus_heading_on_every_route() -> None:
    route = [{"position_m": [100, 500], "speed_kn": 9}, {"position_m": [600, 500], "speed_kn": 9}]
    for keys in (
        {"course_deg": 50, "speed_kn": 8}, {"course_deg": 50, "speed_kn": 8, "turn_rate_deg_s": 2},
        {"waypoints": route}, {"waypoints": route, "turn_radius_m": 60}, {"waypoints": route, "turn_rate_deg_s": 5},
        {"course_deg": 50, "speed_kn": 8, "manoeuvre": [{"time_s": 3, "course_deg": 90, "turn_rate_deg_s": 2}]},
    ):  # fmt: skip
        pose = motion(**keys, drift_deg=7).pose(np.linspace(0, 60, 50))
        drift = np.angle(np.exp(1j * (pose.course - pose.heading)))
        np.testing.assert_allclose(np.rad2deg(drift), 7, atol=1e-9, err_msg=str(keys))


def test_corners_turn_at_the_rate_that_the_scene_says() -> None:
    corners = [{"position_m": [100, 950], "speed_kn": 10}, {"position_m": [1000, 950], "speed_kn": 20},
               {"position_m": [1000, 0], "speed_kn": 5}]  # fmt: skip
    track = motion(waypoints=corners, turn_rate_deg_s=1.5)
    rates = np.rad2deg(np.unique(track.turn_rate(np.linspace(0, 500, 5001))).round(12))
    np.testing.assert_allclose(rates, [0, 1.5], atol=1e-9)
    with pytest.raises(rs.SceneError, match=r"turn_rate_deg_s: too slow for the leg of .* times as fast is possible there"):
        motion(waypoints=corners, turn_rate_deg_s=0.1)


@pytest.mark.parametrize("rate", [1.0, 4.0])
def test_the_plan_knows_how_near_a_body_comes_that_turns_for_ever(rate: float) -> None:
    made = scene([point("t", 0, 2000, course_deg=90, speed_kn=20, turn_rate_deg_s=rate)])
    body = made.bodies[0]
    time = np.linspace(0, 2 * 360 / rate, 20001)
    nearest = np.hypot(*body.motion.pose(time).position[:, :2].T).min()
    assert closest_approach(made.own_ship, body.motion) <= nearest
    run = body_run(body, made)
    assert run.nearest == pytest.approx(nearest, rel=1e-2)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"manoeuvre": [{"time_s": 5}]}, "time_s: nothing changes then"),
        ({"manoeuvre": [{"time_s": 5, "course_deg": 1, "turn_rate_deg_s": -1}]}, "turn_rate_deg_s: -1 to a course"),
        ({"manoeuvre": [{"time_s": 5, "speed_kn": 1}, {"time_s": 5, "speed_kn": 2}]}, r"manoeuvre\[1\].time_s: 5 is not after 5"),
        ({"heading_deg": 5, "turn_rate_deg_s": 1}, "heading_deg: with turn_rate_deg_s the heading follows"),
        ({"heading_deg": 5, "drift_deg": 1}, "heading_deg: with drift_deg"),
        ({"track": "t.csv", "turn_rate_deg_s": 1}, "turn_rate_deg_s: the track already"),
        ({"waypoints": [{"position_m": [1, 1], "speed_kn": 1}], "manoeuvre": [{"time_s": 1, "speed_kn": 2}]}, "manoeuvre: "),
        ({"waypoints": [{"position_m": [1, 1], "speed_kn": 1}], "turn_rate_deg_s": -1}, "turn_rate_deg_s: -1, where"),
        ({"waypoints": [{"position_m": [1, 1], "speed_kn": 1}], "turn_rate_deg_s": 1, "turn_radius_m": 5}, "turn_radius_m"),
        ({"turn_rate_deg_s": 61}, "turn_rate_deg_s"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(rs.SceneError, match=message):
        scene([{"name": "t", "shape": "point", "rcs_dbsm": 1, **keys}])


CORNERS = [{"position_m": list(p), "speed_kn": 10} for p in [(0, 400), (300, 400), (500, 200)]]


def route(**more: object) -> Motion:
    return scene([point("t", 0, 0, waypoints=CORNERS, **more)]).bodies[0].motion


def test_the_route_is_smooth_and_tangent_to_circles() -> None:
    """Speed is 10 kn throughout, position and course never jump, the turn rate is v / r or 0; tolerances are those of the
    differences taken: v dt, and v dt / r of course per step."""
    track, dt = route(turn_radius_m=80), 0.01
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
    track = route(turn_radius_m=50, loop=True)
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
    crab = route(turn_radius_m=80, heading_deg=33).pose(np.linspace(0, 100, 50))
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

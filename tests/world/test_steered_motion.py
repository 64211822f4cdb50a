"""Motion under command: segments and arcs by closed form, continuous, and remembered."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from radar_service.numerics.types import Floats
from radar_service.scene_file.routes import constant_motion
from radar_service.world.motion import Motion
from radar_service.world.seaway import Sway
from radar_service.world.steered_motion import MAX_SEGMENTS, MotionSegment, SteeredMotion, SteeringLimits

LIMITS = SteeringLimits(15.0, math.radians(5.0))
NANOMETRE = 1e-9  # m: positions of some km have a rounding of 1e-12 m, and a segment sums a few of them


def steered(motion: Motion | None = None) -> SteeredMotion:
    return SteeredMotion.under(motion or constant_motion(np.array([100.0, 200.0, 3.0]), None, 40.0, 5.0), LIMITS)


def integrated(segment: MotionSegment, time: float) -> Floats:
    """The position at `time` by summing small steps along the course: none of the closed form."""
    steps = 200_000
    elapsed = (np.arange(steps) + 0.5) / steps * (time - segment.start)
    course = segment.course + segment.turn_rate * np.minimum(elapsed, segment.turn_time)
    return segment.position[:2] + segment.speed * (time - segment.start) * np.array(
        [np.sin(course).mean(), np.cos(course).mean()]
    )


@pytest.mark.parametrize("rate, turn_time", [(0.0, math.inf), (0.05, math.inf), (-0.08, 12.0), (0.03, 40.0)])
@pytest.mark.parametrize("time", [30.0, 33.0, 61.5])
def test_a_leg_is_the_integral_of_its_course(rate: float, turn_time: float, time: float) -> None:
    segment = MotionSegment(30.0, np.array([10.0, -20.0, 4.0]), 2.5, 8.0, rate, turn_time, drift=0.2)
    motion = segment.motion(None)
    pose = motion.pose(time)
    # the midpoint rule errs by the square of its step, (2e-4 s * 0.08 rad/s)^2 / 24 of some 250 m
    assert pose.position[0, :2] == pytest.approx(integrated(segment, time), abs=1e-7)
    assert pose.position[0, 2] == 4.0
    course = 2.5 + rate * min(time - 30.0, turn_time)
    assert pose.heading[0] == pytest.approx((course + 0.2) % (2 * math.pi), abs=1e-12)
    assert pose.speed[0] == pytest.approx(8.0, abs=1e-9)
    assert math.remainder(pose.course[0] - course, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert motion.turn_rate(time)[0] == (rate if time - 30.0 < turn_time else 0.0)
    rest = segment.at(time)
    assert rest.position[:2] == pytest.approx(pose.position[0, :2], abs=NANOMETRE)
    later = time + 25.0
    assert rest.motion(None).pose(later).position[0] == pytest.approx(motion.pose(later).position[0], abs=NANOMETRE)


@pytest.mark.parametrize("rate", [0.0, 0.05])
def test_a_leg_continues_backward_without_a_corner(rate: float) -> None:
    segment = MotionSegment(1000.0, np.array([10.0, -20.0, 0.0]), 2.5, 8.0, rate)
    pose = segment.motion(None).pose(np.array([980.0, 1000.0]))
    course = 2.5 - rate * 20.0
    back = MotionSegment(980.0, pose.position[0], course, 8.0, rate)
    assert back.at(1000.0).position == pytest.approx(segment.position, abs=NANOMETRE)
    assert pose.heading[0] == pytest.approx(course, abs=1e-9)


def test_it_begins_as_the_motion_of_the_scene() -> None:
    first = constant_motion(np.array([100.0, 200.0, 3.0]), 10.0, 40.0, 5.0)
    time = np.array([0.0, 3.0, 50.0])
    for made, given in zip(steered(first).pose(time), first.pose(time), strict=True):
        np.testing.assert_array_equal(made, given)
    segment = steered(first).segment_at(7.0)
    assert (segment.start, segment.speed, segment.turn_rate) == (7.0, pytest.approx(5.0), 0.0)
    assert math.degrees(segment.course) == pytest.approx(40.0)
    assert math.degrees(segment.drift) == pytest.approx(-30.0)


def test_it_counts_as_moving_at_its_highest_speed() -> None:
    resting = SteeredMotion.under(constant_motion(np.zeros(3), 10.0, None, 0.0), LIMITS)
    assert not resting.at_rest and not resting.is_straight and not resting.past.at_rest and not resting.past.is_straight
    assert resting.top_speed == 15.0
    assert steered(constant_motion(np.zeros(3), None, 0.0, 20.0)).top_speed == 20.0


def test_its_past_keeps_each_leg_and_its_pose_the_latest() -> None:
    motion = steered()
    before = motion.pose(np.array([1.0, 2.0]))
    turning = motion.segment_at(10.0)._replace(turn_rate=0.05)
    motion.steer(turning)
    assert motion.pose(12.0).heading[0] == pytest.approx(math.radians(40.0))  # `follow` comes first
    motion.follow()
    straight = motion.segment_at(20.0)._replace(turn_rate=0.0)
    motion.steer(straight)
    motion.follow()
    times = np.array([1.0, 2.0, 10.0, 15.0, 20.0, 30.0])
    past = motion.past.pose(times)
    np.testing.assert_array_equal(past.position[:2], before.position)
    np.testing.assert_array_equal(past.position[2:4], turning.motion(None).pose(times[2:4]).position)
    np.testing.assert_array_equal(past.position[4:], straight.motion(None).pose(times[4:]).position)
    np.testing.assert_array_equal(motion.past.turn_rate(times), [0.0, 0.0, 0.05, 0.05, 0.0, 0.0])
    np.testing.assert_array_equal(motion.pose(times).position, straight.motion(None).pose(times).position)
    assert motion.turn_rate(15.0)[0] == 0.0
    # continuous where a segment ends
    joints = motion.past.pose(np.array([10.0 - 1e-9, 10.0, 20.0 - 1e-9, 20.0])).position
    assert np.abs(np.diff(joints, axis=0)[::2]).max() < 1e-7  # 5 m/s in 1e-9 s, and rounding
    assert len(motion.past.pose(np.zeros(0)).position) == 0
    motion.forget()
    motion.follow()
    np.testing.assert_array_equal(motion.pose(times[:2]).position, before.position)


def test_it_remembers_so_many_legs_and_no_more() -> None:
    motion = steered()
    for second in range(MAX_SEGMENTS + 10):
        motion.steer(motion.segment_at(float(second))._replace(speed=float(second % 3)))
    motion.follow()
    whole = [motion.past.pose(float(second)).speed[0] for second in (11, MAX_SEGMENTS // 2, MAX_SEGMENTS + 9)]
    assert whole == pytest.approx([11 % 3, MAX_SEGMENTS // 2 % 3, (MAX_SEGMENTS + 9) % 3], abs=1e-9)
    assert len(motion.segments_at(np.arange(0.5, MAX_SEGMENTS + 20))) == MAX_SEGMENTS + 1  # and what was before them


def test_sway_goes_on_under_command() -> None:
    sway = Sway(np.array([0.02, 0.0, 0.1, 0.5]), np.array([10.0, 7.0, 20.0, 8.0]))
    motion = steered(replace(constant_motion(np.zeros(3), None, 40.0, 5.0), sway=sway))
    segment = motion.segment_at(5.0)
    assert math.degrees(segment.course) == pytest.approx(40.0) and segment.drift == pytest.approx(0.0, abs=1e-12)
    motion.steer(segment._replace(course=1.0))
    motion.follow()
    assert motion.pose(30.0).heading[0] == pytest.approx(1.0 + motion.sway_state(np.array([30.0])).values[0, 2])
    times = np.array([30.0, 2.0, 31.0])
    past = motion.past.pose(times)
    for k, time in enumerate(times):
        for column, values in zip(past, motion.segments_at(np.array([time]))[0][1].pose(time), strict=True):
            assert column is not None and values is not None
            np.testing.assert_array_equal(column[k], values[0])


def test_a_copy_and_a_pickled_one_are_steered_alone() -> None:
    motion = steered()
    motion.steer(motion.segment_at(1.0)._replace(speed=0.0))
    motion.follow()
    assert replace(motion).pose(9.0).speed[0] == pytest.approx(5.0)
    assert pickle.loads(pickle.dumps(motion)).pose(9.0).speed[0] == 0.0


def test_a_command_makes_a_corner_in_what_was_and_none_in_what_is_followed() -> None:
    """The motion that is followed continues backward; the past has the course before the command."""
    motion = steered()
    motion.steer(MotionSegment(30.0, motion.pose(30.0).position[0], 2.0, 5.0, 0.1, 4.0))
    motion.follow()
    times = np.array([10.0, 29.0, 30.0, 33.0, 34.5, 40.0])
    assert np.flatnonzero(motion.past.corners(times)).tolist() == [1, 3]
    headings = motion.pose(times).heading
    assert headings[1] == pytest.approx(1.9) and np.flatnonzero(motion.corners(times)).tolist() == [1, 3]
    motion.forget()
    assert not motion.past.corners(times).any()

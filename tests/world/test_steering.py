"""The commands to a world: their order, what the motions follow when, and the segments that commands begin."""

import math
import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.numerics.constants import KNOT
from radar_service.numerics.result_cache import STEADY
from radar_service.world.commands import Command, CommandError
from radar_service.world.steered_motion import MotionSegment, SteeringLimits
from radar_service.world.steering import Steering, begun_segment, same_at_first
from tests.scenes import point, scene

MADE = scene([point("a", 0, 500, steerable={}), point("b", 0, 900)], own_ship={"steerable": {"max_speed_kn": 12}})
LIMITS = SteeringLimits(20.0 * KNOT, math.radians(4.0))
BEFORE = MotionSegment(10.0, np.array([1.0, 2.0, 3.0]), math.radians(350.0), 5.0, drift=math.radians(3.0))


def course(steering: Steering, time: float = 100.0) -> float:
    return math.degrees(steering.scene.bodies[0].motion.pose(time).course[0])


def segment(before: MotionSegment = BEFORE, **values: Any) -> MotionSegment:
    return begun_segment(Command(7, 10.0, None, **values), before, LIMITS)


def goes_to(steering: Steering, spoke: int) -> bool:
    """Goes there; whether that has changed a motion or a presence."""
    before = steering.scene.revision.number
    steering.go_to(spoke)
    return steering.scene.revision.number != before


def test_only_what_is_declared_is_steered() -> None:
    assert set(MADE.steered) == set(MADE.steerable.limits) == {None, "a"} and MADE.steerable.names == {"a", "b"}
    other = scene([point("b", 0, 900)])
    made = Steering(other)
    assert made.scene is other and made.past is other and made.due == math.inf and not goes_to(made, 0)


def test_commands_act_by_spoke_and_then_in_order_of_arrival() -> None:
    made = Steering(MADE)
    for spoke, angle in ((50, 10), (20, 20), (50, 30), (35, 40)):
        made.add(spoke, "a", {"course_deg": angle, "speed_kn": 5, "at_once": True})
    assert [(c.spoke, c.course_deg) for c in made.commands] == [(20, 20), (35, 40), (50, 10), (50, 30)]
    assert made.due == 20 and not goes_to(made, 19)
    for spoke, expected, due in ((20, 20, 35), (34, 20, 35), (60, 30, math.inf)):
        made.go_to(spoke)
        assert course(made) == pytest.approx(expected) and made.due == due


def test_going_back_follows_the_commands_until_there() -> None:
    made = Steering(MADE)
    for spoke, angle in ((20, 20), (50, 30)):
        made.add(spoke, "a", {"course_deg": angle, "speed_kn": 5, "at_once": True})
    made.go_to(100)
    assert goes_to(made, 20) and course(made) == pytest.approx(20) and made.due == 50
    assert goes_to(made, 3) and made.scene.bodies[0].motion.pose(100.0).speed[0] == 0.0


def test_a_command_before_others_is_due_again_and_they_follow_it() -> None:
    made = Steering(MADE)
    made.add(50, "a", {"speed_kn": 5})
    made.go_to(60)
    made.add(30, "a", {"course_deg": 45, "at_once": True})
    assert made.due == 30 and goes_to(made, 60)
    assert course(made) == pytest.approx(45)


def test_the_past_takes_commands_when_they_come_and_the_engine_when_it_gets_there() -> None:
    made = Steering(MADE)
    made.go_to(10)
    made.add(16, "a", {"speed_kn": 5}, reached=16)
    assert made.past.bodies[0].motion.pose(100.0).speed[0] > 0.0 and made.scene.bodies[0].motion.pose(100.0).speed[0] == 0.0
    made.add(40, None, {"speed_kn": 5}, reached=16)
    assert made.past.own_ship.pose(100.0).speed[0] == 0.0
    made.go_to(16)
    assert made.scene.bodies[0].motion.pose(100.0).speed[0] > 0.0
    made.go_to(40)
    assert made.past.own_ship.pose(100.0).speed[0] > 0.0


def test_a_replay_replaces_all_commands() -> None:
    made, other = Steering(MADE), Steering(MADE)
    made.add(20, "a", {"speed_kn": 5})
    made.go_to(30)
    other.add(40, "a", {"course_deg": 60, "at_once": True, "speed_kn": 6})
    with pytest.raises(CommandError):
        made.replay([replace(other.commands[0], speed_kn=99.0)])
    assert made.count == 1 and made.due == math.inf
    made.replay(other.commands)
    assert made.commands == other.commands and made.due == 40
    assert goes_to(made, 30) and made.scene.bodies[0].motion.pose(100.0).speed[0] == 0.0
    assert goes_to(made, 40) and course(made) == pytest.approx(60)


def test_commands_of_one_spoke_act_in_the_order_of_their_times() -> None:
    """A radar that turns slowly shows both from the same spoke, and a fast one each from its own."""
    made = Steering(MADE)
    period = made.scene.radar.spoke_period
    made.add(None, "a", {"course_deg": 30, "at_once": True}, time=9.8 * period)
    made.add(None, "a", {"course_deg": 10, "at_once": True, "speed_kn": 5}, time=9.2 * period)
    assert [(c.spoke, c.course_deg) for c in made.commands] == [(10, 10), (10, 30)]
    assert made.due == 10 and goes_to(made, 10) and course(made) == pytest.approx(30)
    east, north, _ = made.past.bodies[0].motion.pose(9.8 * period).position[0]
    way = 5 * 1852 / 3600 * 0.6 * period  # from the time of the first one on, not from the spoke
    assert (east, north - 500) == pytest.approx((way * math.sin(math.radians(10)), way * math.cos(math.radians(10))))


def test_each_change_of_motions_is_counted_where_it_is_seen() -> None:
    """Of the past when a command is taken, of what is computed when the engine gets there, of own ship apart."""
    made = Steering(MADE)

    def counts() -> tuple[int, ...]:
        return tuple(r.number for s in (made.scene, made.past) for r in (s.revision, s.own_revision))

    assert counts() == (0, 0, 0, 0) and MADE.revision is STEADY and MADE.own_revision is STEADY
    made.add(20, "a", {"speed_kn": 5}, reached=10)
    assert counts() == (0, 0, 0, 0)
    made.add(5, "a", {"speed_kn": 6}, reached=10)
    assert counts()[:2] == (0, 0) and counts()[2] > 0
    past = counts()[2]
    made.go_to(10)
    assert counts()[:3] == (1, 0, past)
    made.add(30, None, {"speed_kn": 5}, reached=10)
    made.go_to(30)
    assert counts()[:2] == (2, 1) and counts()[3] > 0
    made.go_to(31)
    assert counts()[:2] == (2, 1)
    numbers = counts()
    assert made.scene.for_radar(made.scene.radar_id).revision is made.scene.revision
    assert counts() == numbers and made.past.revision is not made.scene.revision


def test_a_course_is_reached_by_the_shorter_way_at_the_highest_rate() -> None:
    made = segment(course_deg=30)
    assert math.degrees(made.turn_rate) == pytest.approx(4.0) and made.turn_time == pytest.approx(10.0)
    made = segment(course_deg=300)
    assert math.degrees(made.turn_rate) == pytest.approx(-4.0) and made.turn_time == pytest.approx(12.5)
    end = made.at(BEFORE.start + 100.0)
    assert math.degrees(end.course) == pytest.approx(300.0) and end.turn_rate == 0.0 and end.turn_time == math.inf


@pytest.mark.parametrize(("rate", "seconds"), [(2.0, 20.0), (-2.0, 160.0), (1.0, 40.0)])
def test_a_course_with_a_rate_is_reached_by_the_side_of_the_rate(rate: float, seconds: float) -> None:
    made = segment(course_deg=30, turn_rate_deg_s=rate)
    assert math.degrees(made.turn_rate) == pytest.approx(rate) and made.turn_time == pytest.approx(seconds)


def test_the_present_course_ends_a_turn() -> None:
    turning = BEFORE._replace(turn_rate=0.05)
    assert segment(turning, course_deg=350).turn_rate == 0.0
    assert segment(turning, course_deg=350, turn_rate_deg_s=3).turn_rate == 0.0
    assert segment(turning, turn_rate_deg_s=0).turn_rate == 0.0


def test_a_speed_changes_at_once_and_a_turn_goes_on() -> None:
    turning = BEFORE._replace(turn_rate=0.05, turn_time=6.0)
    slower = segment(turning, speed_kn=2)
    assert slower == turning._replace(speed=2 * KNOT, excess=slower.excess)


def test_a_rate_alone_turns_without_end() -> None:
    made = segment(BEFORE._replace(turn_rate=-0.05, turn_time=3.0), turn_rate_deg_s=3)
    assert math.degrees(made.turn_rate) == pytest.approx(3.0) and made.turn_time == math.inf


def test_a_position_jumps_and_keeps_its_height() -> None:
    assert segment(position_m=(50.0, -60.0)).position.tolist() == [50.0, -60.0, 3.0]


def test_a_pose_sets_its_course_at_once_and_turns_on() -> None:
    made = segment(course_deg=90, turn_rate_deg_s=-2, heading_deg=95, at_once=True)
    assert math.degrees(made.course) == pytest.approx(90) and made.turn_time == math.inf
    assert math.degrees(made.turn_rate) == pytest.approx(-2) and math.degrees(made.drift) == pytest.approx(5)
    assert segment(BEFORE._replace(turn_rate=0.05), course_deg=90, at_once=True).turn_rate == 0.0


def test_a_heading_stays_at_its_angle_to_the_course() -> None:
    made = segment(heading_deg=10, course_deg=30)
    assert math.degrees(made.drift) == pytest.approx(20.0)
    assert math.degrees(made.motion(None).pose(200.0).heading[0]) == pytest.approx(50.0)
    assert segment(course_deg=30).drift == BEFORE.drift


@pytest.mark.parametrize("seed", range(4))
def test_a_copy_follows_what_the_original_follows(seed: int) -> None:
    """Commands in any order of times, and steps ahead and back: the copy has the course and the speed of the original."""
    random, original, copy = np.random.default_rng(seed), Steering(MADE), Steering(MADE)
    for _ in range(12):
        values = {"course_deg": float(random.uniform(0, 360)), "speed_kn": float(random.uniform(0, 20)), "at_once": True}
        original.add(int(random.integers(0, 200)), "a", values)
        original.go_to(int(random.integers(0, 200)))
        copy.follow(original.followed)
        for time in (1.0, 5.0, 100.0):
            motions = (each.scene.bodies[0].motion.pose(time) for each in (original, copy))
            first, second = ((float(pose.course[0]), float(pose.speed[0])) for pose in motions)
            assert first == second
        assert copy.due == math.inf and copy.followed == original.followed
    changes = copy.scene.revision.number
    copy.follow(original.followed)
    assert copy.scene.revision.number == changes


def test_no_command_is_added_while_a_steering_is_unchanged() -> None:
    made = Steering(MADE)
    with made.unchanged():
        thread = threading.Thread(target=made.add, args=(0, "a", {"speed_kn": 5}))
        thread.start()
        assert thread.is_alive() and made.count == 0
    thread.join(60.0)
    assert made.count == 1


def test_sequences_of_commands_are_alike_up_to_the_first_difference() -> None:
    first, second, third = (Command(spoke, float(spoke), None) for spoke in (1, 2, 3))
    assert same_at_first([first, second], [Command(1, 1.0, None), third]) == 1
    assert (
        same_at_first([first, second], [first, second, third]) == same_at_first([first, second, third], [first, second]) == 2
    )
    assert same_at_first([], [first]) == same_at_first([second], [first]) == 0

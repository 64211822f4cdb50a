"""Commands: which are refused, in which words, and the legs of the others."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.constants import KNOT
from radar_service.radar.parameters import Origin
from radar_service.scene.commands import (
    CHECKS,
    KEYS,
    Command,
    CommandError,
    NotSteerableError,
    Steerable,
    UnknownBodyError,
    command_from,
)
from radar_service.scene.steered_motion import Leg, SteeringLimits
from tests.scenes import radar

LIMITS = SteeringLimits(20.0 * KNOT, math.radians(4.0))
ALL = Steerable({None: LIMITS, "ferry": LIMITS}, {"ferry", "rock"}, radar(azimuths=120, rpm=1))
BEFORE = Leg(10.0, np.array([1.0, 2.0, 3.0]), math.radians(350.0), 5.0, drift=math.radians(3.0))


def leg(before: Leg = BEFORE, **values: Any) -> Leg:
    return Command(7, 10.0, None, **values).leg(before, LIMITS)


def test_each_key_is_checked() -> None:
    assert set(CHECKS) == set(KEYS)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"speed_kn": 20.1}, "speed_kn: 20.1 is not allowed; 0 to 20"),
        ({"speed_kn": -1}, "speed_kn: -1 is not allowed; 0 to 20"),
        ({"turn_rate_deg_s": -4.01}, "turn_rate_deg_s: -4.01 is not allowed; -4 to 4"),
        ({"course_deg": 361}, "course_deg: 361 is not allowed; -360 to 360"),
        ({"heading_deg": float("nan")}, "heading_deg: nan is not a number"),
        ({"speed_kn": float("inf")}, "speed_kn: inf is not a number"),
        ({"speed_kn": True}, "speed_kn: True is not a number"),
        ({"speed_kn": "5"}, "speed_kn: 5 is not a number"),
        ({"position_m": [1.0]}, "position_m: [1.0] is not a position; give [east, north]"),
        ({"position_m": [1.0, float("nan")]}, "position_m[1]: nan is not a number"),
        ({"position_m": [1.0, 3e6]}, "position_m[1]: 3e+06 is not allowed"),
        ({"position_m": "here"}, "position_m: here is not a position"),
        ({"present": False}, "present: own ship is always present; leave it out"),
        ({"at_once": 1, "course_deg": 3}, "at_once: 1 is not allowed; true or false"),
        ({}, "a command without a value: give at least one of course_deg"),
        ({"at_once": True}, "a command without a value"),
        ({"speed_kn": None}, "a command without a value"),
        ({"spede_kn": 3}, "spede_kn: not a key of a command; allowed are course_deg, speed_kn"),
        ({"turn_rate_deg_s": 0, "course_deg": 10}, "turn_rate_deg_s: 0 never reaches course_deg 10"),
    ],
)
def test_values_that_are_refused(values: dict[str, Any], words: str) -> None:
    with pytest.raises(CommandError) as refused:
        ALL.checked(None, values)
    assert words in str(refused.value)


def test_bodies_that_cannot_be_steered() -> None:
    with pytest.raises(UnknownBodyError, match='scene has no "frery"; bodies that may be steered: "ferry"'):
        ALL.checked("frery", {"speed_kn": 1})
    with pytest.raises(NotSteerableError, match='body "rock" is not steerable in this scene; add steerable'):
        ALL.checked("rock", {"speed_kn": 1})
    with pytest.raises(NotSteerableError, match="own ship is not steerable"):
        Steerable({}, {"rock"}, None).checked(None, {"speed_kn": 1})


def test_the_limits_themselves_are_allowed() -> None:
    values = {"speed_kn": 20, "turn_rate_deg_s": -4, "course_deg": -360, "position_m": (1, 2), "heading_deg": None}
    assert ALL.checked("ferry", values) == {
        "speed_kn": 20.0, "turn_rate_deg_s": -4.0, "course_deg": -360.0, "position_m": (1.0, 2.0)
    }  # fmt: skip


def test_a_course_is_reached_by_the_shorter_way_at_the_highest_rate() -> None:
    made = leg(course_deg=30)
    assert math.degrees(made.turn_rate) == pytest.approx(4.0) and made.turn_time == pytest.approx(10.0)
    made = leg(course_deg=300)
    assert math.degrees(made.turn_rate) == pytest.approx(-4.0) and made.turn_time == pytest.approx(12.5)
    end = made.at(BEFORE.start + 100.0)
    assert math.degrees(end.course) == pytest.approx(300.0) and end.turn_rate == 0.0 and end.turn_time == math.inf


@pytest.mark.parametrize(("rate", "seconds"), [(2.0, 20.0), (-2.0, 160.0), (1.0, 40.0)])
def test_a_course_with_a_rate_is_reached_by_the_side_of_the_rate(rate: float, seconds: float) -> None:
    made = leg(course_deg=30, turn_rate_deg_s=rate)
    assert math.degrees(made.turn_rate) == pytest.approx(rate) and made.turn_time == pytest.approx(seconds)


def test_the_present_course_ends_a_turn() -> None:
    turning = BEFORE._replace(turn_rate=0.05)
    assert leg(turning, course_deg=350).turn_rate == 0.0
    assert leg(turning, course_deg=350, turn_rate_deg_s=3).turn_rate == 0.0
    assert leg(turning, turn_rate_deg_s=0).turn_rate == 0.0


def test_a_speed_changes_at_once_and_a_turn_goes_on() -> None:
    turning = BEFORE._replace(turn_rate=0.05, turn_time=6.0)
    assert leg(turning, speed_kn=2) == turning._replace(speed=2 * KNOT)


def test_a_rate_alone_turns_without_end() -> None:
    made = leg(BEFORE._replace(turn_rate=-0.05, turn_time=3.0), turn_rate_deg_s=3)
    assert math.degrees(made.turn_rate) == pytest.approx(3.0) and made.turn_time == math.inf


def test_a_position_jumps_and_keeps_its_height() -> None:
    assert leg(position_m=(50.0, -60.0)).position.tolist() == [50.0, -60.0, 3.0]


def test_a_pose_sets_its_course_at_once_and_turns_on() -> None:
    made = leg(course_deg=90, turn_rate_deg_s=-2, heading_deg=95, at_once=True)
    assert math.degrees(made.course) == pytest.approx(90) and made.turn_time == math.inf
    assert math.degrees(made.turn_rate) == pytest.approx(-2) and math.degrees(made.drift) == pytest.approx(5)
    assert leg(BEFORE._replace(turn_rate=0.05), course_deg=90, at_once=True).turn_rate == 0.0


def test_a_heading_stays_at_its_angle_to_the_course() -> None:
    made = leg(heading_deg=10, course_deg=30)
    assert math.degrees(made.drift) == pytest.approx(20.0)
    assert math.degrees(made.motion(None).pose(200.0).heading[0]) == pytest.approx(50.0)
    assert leg(course_deg=30).drift == BEFORE.drift


@pytest.mark.parametrize("spoke", [-1, 1.5, True, None, 2**60])
def test_a_spoke_is_a_whole_number(spoke: Any) -> None:
    with pytest.raises(CommandError, match="spoke: .* is not allowed; a whole number from 0"):
        ALL.command(spoke, "ferry", {"speed_kn": 5})


def test_plain_data_become_a_command_again() -> None:
    command = ALL.command(7, "ferry", {"speed_kn": 3, "position_m": [1, 2]})
    assert command.time == 3.5
    again = command_from(command.as_dict())
    assert ALL.command(again.spoke, again.body, again.values) == command
    with pytest.raises(CommandError, match="wheel: not a key"):
        command_from({"spoke": 7, "wheel": 1})


def test_it_is_plain_data() -> None:
    command = Command(7, 0.5, "ferry", speed_kn=3.0, position_m=(1.0, 2.0))
    assert command.as_dict() == {"spoke": 7, "time": 0.5, "body": "ferry", "speed_kn": 3.0, "position_m": (1.0, 2.0)}
    assert Command(7, 0.5, None, course_deg=1.0).as_dict()["body"] is None


def test_a_time_stands_for_the_first_spoke_not_before_it() -> None:
    """Spokes are 0.5 s apart."""
    assert ALL.command(None, "ferry", {"speed_kn": 3}, 3.2) == Command(7, 3.2, "ferry", speed_kn=3.0)
    assert ALL.command(None, "ferry", {"speed_kn": 3}, 3.5).spoke == 7
    recorded = Command(7, 3.2, "ferry", speed_kn=3.0).as_dict()
    again = command_from(recorded)
    assert ALL.command(again.spoke, again.body, again.values, again.time).as_dict() == recorded


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (-0.1, "time: -0.1 is not allowed; 0 to"),
        (math.nan, "time: nan is not a number"),
        (1e300, "time: 1e+300 is not allowed"),
        ("3", "time: 3 is not a number"),
        (3.6, "time: 3.6 s is that of spoke 8, not of spoke 7; give one of both alone"),
        (2.9, "time: 2.9 s is that of spoke 6, not of spoke 7"),
    ],
)
def test_times_that_are_refused(time: Any, words: str) -> None:
    with pytest.raises(CommandError) as refused:
        ALL.command(7, "ferry", {"speed_kn": 3}, time)
    assert words in str(refused.value)


def test_commands_before_a_change_of_rpm_keep_their_spokes() -> None:
    """From 60 s on, the start of scan 1, spokes are 0.25 s apart."""
    after = replace(ALL, radar=replace(radar(azimuths=120, rpm=2), origin=Origin(60.0, 1)))
    assert after.radar
    commands = [ALL.command(spoke, "ferry", {"speed_kn": 3}) for spoke in (7, 119, 120, 122)]
    kept = [command.after_change_of_rpm(after.radar) for command in commands]
    assert [each.spoke for each in kept] == [7, 119, 120, 124] and [each.time for each in kept] == [3.5, 59.5, 60.0, 61.0]
    for each in kept:
        assert after.command(each.spoke, each.body, each.values, each.time) == each
    assert after.command(None, "ferry", {"speed_kn": 3}, 59.0).spoke == 120  # the first that there is

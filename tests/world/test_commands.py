"""Commands: which are refused, in which words, and all that a source has been given."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import pytest

from radar_service.numerics.constants import KNOT
from radar_service.simulator import Simulator
from radar_service.world.commands import (
    CHECKS,
    KEYS,
    Command,
    CommandError,
    CommandLog,
    NotSteerableError,
    Steerable,
    UnknownBodyError,
    command_from,
)
from radar_service.world.steered_motion import SteeringLimits
from radar_service.world.steering import Steering
from tests.scenes import point, radar, scene

LIMITS = SteeringLimits(20.0 * KNOT, math.radians(4.0))
ALL = Steerable({None: LIMITS, "ferry": LIMITS}, {"ferry", "rock"}, radar(azimuths=120, rpm=1))


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


@pytest.mark.parametrize("spoke", [-1, 1.5, True, None, 2**60])
def test_a_spoke_is_a_whole_number(spoke: Any) -> None:
    with pytest.raises(CommandError, match="spoke: .* is not allowed; a whole number from 0"):
        ALL.command(spoke, "ferry", {"speed_kn": 5})


def test_it_is_plain_data() -> None:
    command = Command(7, 0.5, "ferry", speed_kn=3.0, position_m=(1.0, 2.0))
    assert command.as_dict() == {"spoke": 7, "time": 0.5, "body": "ferry", "speed_kn": 3.0, "position_m": (1.0, 2.0)}
    assert Command(7, 0.5, None, course_deg=1.0).as_dict()["body"] is None
    sent = Command(7, 0.5, None, course_deg=1.0, by="nmea")
    assert sent.as_dict()["by"] == "nmea" and command_from(sent.as_dict()) == sent and sent.values == {"course_deg": 1.0}
    with pytest.raises(CommandError, match="wheel: not a key"):
        command_from({"spoke": 7, "wheel": 1})


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


def added(log: CommandLog, spoke: int, body: str | None, values: dict[str, float]) -> Command:
    command = log.command(spoke, body, values)
    log.add(command)
    return command


def test_commands_come_in_order_and_the_latest_of_each_body_is_known() -> None:
    log = CommandLog(ALL)
    assert len(log) == 0 and log.latest(None) is None
    first = added(log, 5, "ferry", {"speed_kn": 3})
    second = added(log, 7, None, {"course_deg": 10})
    third = added(log, 9, "ferry", {"speed_kn": 4})
    assert list(log) == [first, second, third] and log.latest("ferry") is third and log.latest(None) is second
    other = CommandLog(ALL, log)
    assert list(other) == list(log) and other.latest("ferry") is third


MADE = scene([point("ferry", 0, 300, steerable={"max_speed_kn": 20}), point("rock", 0, 200)], own_ship={"steerable": {}})
Entrance = tuple[
    Callable[[int, str, dict[str, Any]], object], Callable[[], Sequence[Command]]
]  # gives one; all that are kept


def of_log() -> Entrance:
    log = CommandLog(MADE.steerable)
    return lambda spoke, body, values: added(log, spoke, body, values), lambda: list(log)


def of_steering() -> Entrance:
    made = Steering(MADE)
    return made.add, lambda: made.commands


def of_simulator() -> Entrance:
    sim = Simulator(MADE, "fast")
    return lambda spoke, body, values: sim.command(body, spoke=spoke, **values), lambda: sim.commands


@pytest.mark.parametrize("entrance", [of_log, of_steering, of_simulator])
def test_every_entrance_keeps_no_refused_command_and_not_too_many(
    entrance: Callable[[], Entrance], monkeypatch: pytest.MonkeyPatch
) -> None:
    give, kept = entrance()
    for body, values, words in (
        ("nobody", {"speed_kn": 1}, 'no "nobody"'), ("rock", {"speed_kn": 1}, "not steerable"),
        ("ferry", {"speed": 1}, "speed: not"), ("ferry", {"speed_kn": 21}, "speed_kn: 21 is not allowed; 0 to 20"),
    ):  # fmt: skip
        with pytest.raises(CommandError, match=words):
            give(5, body, values)
    assert not kept()
    monkeypatch.setattr("radar_service.world.commands.MAX_COMMANDS", 2)
    for _ in range(2):
        give(5, "ferry", {"speed_kn": 20})
    with pytest.raises(CommandError, match="takes 2 commands, and has had as many; start the scene anew"):
        give(5, "ferry", {"speed_kn": 20})
    assert len(kept()) == 2


def test_it_says_what_a_block_does_not_know_and_what_acts_until_a_spoke() -> None:
    log = CommandLog(ALL)
    assert log.first_unknown(0) == math.inf and log.acting_at(99) == 0
    made = [added(log, spoke, "ferry", {"speed_kn": 3}) for spoke in (5, 7, 7, 20)]
    assert [log.first_unknown(count) for count in range(5)] == [5, 7, 7, 20, math.inf]
    assert [log.acting_at(spoke) for spoke in (4, 5, 7, 19, 20)] == [0, 1, 3, 3, 4]
    assert list(log.since(2)) == made[2:]


def test_own_ship_that_is_a_body_has_one_latest_command() -> None:
    log = CommandLog(replace(ALL, own_ship="ferry", limits={**ALL.limits, None: ALL.limits["ferry"]}))
    first = added(log, 5, None, {"speed_kn": 3})
    assert log.latest("ferry") is first
    assert added(log, 6, "ferry", {"speed_kn": 4}) is log.latest(None)


def test_the_latest_of_each_body_after_some() -> None:
    log = CommandLog(ALL)
    made = [added(log, 5 + k, body, {"speed_kn": 3}) for k, body in enumerate(("ferry", None, "ferry", "ferry"))]
    assert log.latest_after(0) == [made[3], made[1]] and log.latest_after(1) == [made[1], made[3]]
    assert log.latest_after(2) == [made[3]] and log.latest_after(4) == []

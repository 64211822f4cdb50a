"""The commands that a source has been given."""

import math
from dataclasses import replace

import pytest

from radar_service.scene.commands import Command, CommandError
from radar_service.stream import command_log
from radar_service.stream.command_log import CommandLog
from tests.stream.fake import steerable_scene

STEERABLE = steerable_scene().steerable


def added(log: CommandLog, spoke: int, body: str | None, values: dict[str, float]) -> Command:
    command = log.made(spoke, body, values)
    log.add(command)
    return command


def test_commands_come_in_order_and_the_latest_of_each_body_is_known() -> None:
    log = CommandLog(STEERABLE)
    assert len(log) == 0 and log.latest(None) is None
    first = added(log, 5, "buoy", {"speed_kn": 3})
    second = added(log, 7, None, {"course_deg": 10})
    third = added(log, 9, "buoy", {"speed_kn": 4})
    assert list(log) == [first, second, third] and log.latest("buoy") is third and log.latest(None) is second
    other = CommandLog(STEERABLE, log)
    assert list(other) == list(log) and other.latest("buoy") is third


def test_a_refused_command_is_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_log, "MAX_COMMANDS", 1)
    log = CommandLog(STEERABLE)
    with pytest.raises(CommandError, match="speed_kn: 21 is not allowed; 0 to 20"):
        added(log, 5, "buoy", {"speed_kn": 21})
    added(log, 5, "buoy", {"speed_kn": 20})
    with pytest.raises(CommandError, match="takes 1 commands"):
        added(log, 5, "buoy", {"speed_kn": 20})
    assert len(log) == 1


def test_it_says_what_a_block_does_not_know_and_what_acts_until_a_spoke() -> None:
    log = CommandLog(STEERABLE)
    assert log.first_unknown(0) == math.inf and log.acting_at(99) == 0
    made = [added(log, spoke, "buoy", {"speed_kn": 3}) for spoke in (5, 7, 7, 20)]
    assert [log.first_unknown(count) for count in range(5)] == [5, 7, 7, 20, math.inf]
    assert [log.acting_at(spoke) for spoke in (4, 5, 7, 19, 20)] == [0, 1, 3, 3, 4]
    assert list(log.since(2)) == made[2:]


def test_to_make_a_command_adds_nothing() -> None:
    log = CommandLog(STEERABLE)
    assert log.made(3, "buoy", {"speed_kn": 20}).speed_kn == pytest.approx(20.0)
    assert len(log) == 0


def test_own_ship_that_is_a_body_has_one_latest_command() -> None:
    log = CommandLog(replace(STEERABLE, own_ship="buoy", limits={**STEERABLE.limits, None: STEERABLE.limits["buoy"]}))
    first = added(log, 5, None, {"speed_kn": 3})
    assert log.latest("buoy") is first
    assert added(log, 6, "buoy", {"speed_kn": 4}) is log.latest(None)


def test_the_latest_of_each_body_after_some() -> None:
    log = CommandLog(STEERABLE)
    made = [added(log, 5 + k, body, {"speed_kn": 3}) for k, body in enumerate(("buoy", None, "buoy", "buoy"))]
    assert log.latest_after(0) == [made[3], made[1]] and log.latest_after(1) == [made[1], made[3]]
    assert log.latest_after(2) == [made[3]] and log.latest_after(4) == []

"""The commands that a source has been given."""

import pytest

from radar_service.scene.commands import CommandError
from radar_service.stream import command_log
from radar_service.stream.command_log import CommandLog
from tests.stream.fake import steerable_scene

STEERABLE = steerable_scene().steerable


def test_commands_come_in_order_and_the_latest_of_each_body_is_known() -> None:
    log = CommandLog(STEERABLE)
    assert len(log) == 0 and log.latest(None) is None
    first = log.add(5, "buoy", {"speed_kn": 3})
    second = log.add(7, None, {"course_deg": 10})
    third = log.add(9, "buoy", {"speed_kn": 4})
    assert list(log) == [first, second, third] and log.latest("buoy") is third and log.latest(None) is second
    other = CommandLog(STEERABLE, log)
    assert list(other) == list(log) and other.latest("buoy") is third


def test_a_refused_command_is_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_log, "MAX_COMMANDS", 1)
    log = CommandLog(STEERABLE)
    with pytest.raises(CommandError, match="speed_kn: 21 is not allowed; 0 to 20"):
        log.add(5, "buoy", {"speed_kn": 21})
    log.add(5, "buoy", {"speed_kn": 20})
    with pytest.raises(CommandError, match="takes 1 commands"):
        log.add(5, "buoy", {"speed_kn": 20})
    assert len(log) == 1

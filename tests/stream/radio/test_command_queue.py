"""Commands that wait for the transmitter."""

from collections.abc import Mapping
from typing import Any

import pytest

from radar_service.scene.commands import Command, CommandError
from radar_service.stream.radio import command_queue
from radar_service.stream.radio.command_queue import CommandQueue, NoRadarError, TooManyCommandsError


def speed(value: float) -> Any:
    return lambda time: {"speed_kn": value + time}


def carry_out(body: str | None, values: Mapping[str, Any]) -> Command:
    if values["speed_kn"] > 50:
        raise CommandError("too fast")
    return Command(3, 1.5, body, **values)


def test_commands_are_taken_in_order_and_answered() -> None:
    calls: list[int] = []
    queue = CommandQueue(lambda: calls.append(len(queue)))
    answers = [queue.put(body, speed(value)) for body, value in (("a", 1), (None, 2), ("a", 99), ("a", 4))]
    assert calls == [1, 2, 3, 4]
    cancelled = queue.put("b", speed(5))
    cancelled.cancel()
    assert [waiting.carry_out(1.5, carry_out) for waiting in queue.take()] == [True, True, False, True, True]
    assert len(queue) == 0 and queue.take() == []
    assert [answers[n].result().speed_kn for n in (0, 1, 3)] == [2.5, 3.5, 5.5] and answers[1].result().body is None
    with pytest.raises(CommandError, match="too fast"):
        answers[2].result()


def test_a_pose_supersedes_the_pose_of_its_body_that_waits_and_no_command() -> None:
    queue = CommandQueue(lambda: None)
    command = queue.put("a", speed(1))
    old, other, new = (queue.put(body, speed(n), supersedes=True) for n, body in enumerate(("a", "b", "a")))
    assert [waiting.carry_out(0.0, carry_out) for waiting in queue.take()] == [True, True, True]
    assert command.result().speed_kn == 1 and other.result().speed_kn == 1
    assert old.result() is new.result() and new.result().speed_kn == 2


def test_too_many_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_queue, "MAX_WAITING", 2)
    queue = CommandQueue(lambda: None)
    for _ in range(2):
        queue.put("a", speed(1))
    with pytest.raises(TooManyCommandsError, match="2 commands wait already; send fewer"):
        queue.put("a", speed(1))


def test_a_closed_queue_refuses_all_until_it_is_open_again() -> None:
    queue = CommandQueue(lambda: None)
    waiting = queue.put("a", speed(1))
    queue.close("the radar has stopped")
    with pytest.raises(NoRadarError, match="the radar has stopped"):
        waiting.result()
    with pytest.raises(NoRadarError, match="the radar has stopped"):
        queue.put("a", speed(1))
    queue.close(None)
    queue.put("a", speed(1))
    assert len(queue) == 1

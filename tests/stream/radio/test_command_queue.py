"""Commands that wait for the transmitter."""

from collections.abc import Mapping
from typing import Any

import pytest

from radar_service.scene.commands import Command, CommandError
from radar_service.stream.radio import command_queue
from radar_service.stream.radio.command_queue import CommandQueue, NoRadarError, TooManyCommandsError


def speed(value: float) -> Any:
    return lambda time: {"speed_kn": value + time}


def carried_out(queue: CommandQueue, time: float = 1.5) -> list[bool]:
    """Carries out and answers all commands that wait and are awaited; returns whether each was accepted."""
    outcomes = [(each, each.carry_out(time, carry_out)) for each in queue.take() if each.begin()]
    for each, outcome in outcomes:
        each.answer(outcome)
    return [isinstance(outcome, Command) for _, outcome in outcomes]


def carry_out(body: str | None, values: Mapping[str, Any]) -> Command:
    if values["speed_kn"] > 50:
        raise CommandError("too fast")
    return Command(3, 1.5, body, **values)


def test_commands_are_taken_in_order_and_answered() -> None:
    calls: list[int] = []
    queue = CommandQueue(lambda: calls.append(len(queue)))
    answers = [queue.put(body, speed(value)) for body, value in (("a", 1), (None, 2), ("a", 99), ("a", 4))]
    assert calls == [1, 2, 3, 4]
    assert carried_out(queue) == [True, True, False, True]
    assert len(queue) == 0 and queue.take() == []
    assert [answers[n].result().speed_kn for n in (0, 1, 3)] == [2.5, 3.5, 5.5] and answers[1].result().body is None
    with pytest.raises(CommandError, match="too fast"):
        answers[2].result()


def test_what_nobody_waits_for_is_not_carried_out() -> None:
    """Whoever was told that it took too long may have ordered something else since."""
    queue = CommandQueue(lambda: None)
    late, first, second = queue.put("a", speed(1)), *(queue.put("b", speed(n), supersedes=True) for n in (2, 3))
    late.cancel()
    first.cancel()
    (waiting,) = [each for each in queue.take() if each.begin()]
    assert not second.cancel() and waiting.body == "b"
    waiting.answer(waiting.carry_out(0.0, carry_out))
    assert second.result().speed_kn == 3


def test_commands_of_several_queues_are_numbered_together() -> None:
    one, other = CommandQueue(lambda: None), CommandQueue(lambda: None)
    for queue, value in ((one, 1), (other, 2), (one, 3)):
        queue.put("a", speed(value))
    waiting = sorted(one.take() + other.take(), key=lambda each: each.number)
    assert [each.values(0.0)["speed_kn"] for each in waiting] == [1, 2, 3]


def test_a_pose_supersedes_the_pose_of_its_body_that_waits_and_no_command() -> None:
    queue = CommandQueue(lambda: None)
    command = queue.put("a", speed(1))
    old, other, new = (queue.put(body, speed(n), supersedes=True) for n, body in enumerate(("a", "b", "a")))
    assert carried_out(queue, 0.0) == [True, True, True]
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

"""RunControl and the wait for spokes, on a clock that the test moves."""

import threading
from dataclasses import replace

import pytest

from radar_service.service.radio.pacer import Pacer
from radar_service.service.settings import Pace, Settings
from tests.service.fake import FakeEngine, scene
from tests.service.radio.recording import SOON

TIMES = FakeEngine(scene()).block(0, 3).time


@pytest.mark.parametrize(("state", "idle"), [("run", False), ("pause", True)])
def test_a_pause_without_steps_is_idle(state: str, idle: bool) -> None:
    assert Pacer(Settings(pace=Pace(state)), lambda: 0.0).idle is idle  # type: ignore[arg-type]


def test_steps_go_at_once_and_are_counted_down() -> None:
    pacer = Pacer(Settings(), lambda: 0.0)
    pacer.step(5)
    assert pacer.settings.pace.state == "pause" and not pacer.idle
    assert pacer.wait_until_due(TIMES, pacer.run_control()) and pacer.run_control().steps == 2


def test_spokes_that_are_refused_at_last_cost_no_steps() -> None:
    pacer, answers = Pacer(Settings(), lambda: 0.0), iter((False, True))
    pacer.step(5)
    assert [pacer.wait_until_due(TIMES, pacer.run_control(), lambda: next(answers)) for _ in range(2)] == [False, True]
    assert not list(answers) and pacer.run_control().steps == 2


def test_a_wait_lets_the_command_worker_know() -> None:
    pacer, answers = Pacer(Settings(pace=Pace("pause")), lambda: 0.0), list[bool]()
    orders = pacer.run_control()
    waiting = threading.Thread(target=lambda: answers.append(pacer.wait_until_due(TIMES, orders)))
    with pacer.group_clock.changed:
        waiting.start()
        assert pacer.group_clock.may_command.wait_for(lambda: pacer.waiting, SOON)
    pacer.interrupt()
    waiting.join(SOON)
    assert answers == [False] and not pacer.waiting


@pytest.mark.parametrize("order", ["set", "step", "interrupt", "stop"])
def test_an_order_ends_a_wait(order: str) -> None:
    pacer, answers = Pacer(Settings(pace=Pace("pause")), lambda: 0.0), list[bool]()
    orders = pacer.run_control()
    waiting = threading.Thread(target=lambda: answers.append(pacer.wait_until_due(TIMES, orders)))
    waiting.start()
    arguments = {"set": (replace(pacer.settings, transmit=False),), "step": (1,)}.get(order, ())
    getattr(pacer, order)(*arguments)
    waiting.join(SOON)
    assert answers == [False]


def test_a_change_of_pace_makes_the_next_spoke_due_at_once_and_others_do_not() -> None:
    now = 0.0
    pacer = Pacer(Settings(), lambda: now)
    assert pacer.group_clock.schedule.delay(0.0, 0.0, 1.0) == 0.0
    pacer.set(replace(pacer.settings, transmit=False))
    assert pacer.group_clock.schedule.delay(0.0, 1.0, 1.0) == 1.0
    pacer.set(replace(pacer.settings, pace=Pace(factor=2.0)))
    assert pacer.group_clock.schedule.delay(0.0, 1.0, 1.0) == 0.0


def test_waiting_for_a_condition_ends_with_it_or_with_the_radar() -> None:
    pacer, ready = Pacer(Settings(), lambda: 0.0), False
    waiting = threading.Thread(target=lambda: pacer.wait_for(lambda: ready))
    waiting.start()
    ready = True
    pacer.interrupt()
    waiting.join(SOON)
    assert not waiting.is_alive()
    pacer.stop()
    pacer.wait_for(lambda: False)  # returns


def test_nothing_is_due_while_it_is_held() -> None:
    pacer, answers = Pacer(Settings(), lambda: 0.0, held=True), list[bool]()
    assert pacer.idle
    pacer.step(3)
    orders = pacer.run_control()
    waiting = threading.Thread(target=lambda: answers.append(pacer.wait_until_due(TIMES, orders)))
    waiting.start()
    pacer.release()
    waiting.join(SOON)
    assert answers == [False] and not pacer.idle and not pacer.held  # the release is an order, too
    assert pacer.wait_until_due(TIMES, pacer.run_control())

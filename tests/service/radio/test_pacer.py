"""The wait for spokes, on a clock that the test moves, and two radars on one clock: a scan of 2.5 s and one of 5/3 s."""

import contextlib
import math
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from radar_service.service.radio.command_worker import CommandWorker
from radar_service.service.radio.pacer import MAX_LEAD, GroupClock, Pacer
from radar_service.service.radio.scene_process import prepared
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.settings import Pace, Settings
from tests.processes.test_fork_server import until
from tests.service.fake import AZIMUTHS, FakeEngine, factory, scene
from tests.service.radio.recording import SOON, RecordingSink

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


PAUSED, FLAT_OUT = Pace("pause", math.inf), Pace("run", math.inf)
SLOW, FAST = scene(rpm=24), scene(rpm=36)
PERIOD = {"slow": 2.5 / AZIMUTHS, "fast": 5.0 / 3.0 / AZIMUTHS}


class Radar(NamedTuple):
    transmitter: Transmitter
    sink: RecordingSink

    @property
    def pacer(self) -> Pacer:
        return self.transmitter.pacer

    @property
    def times(self) -> list[float]:
        """Times of the spokes sent in the present epoch [s]."""
        return [float(t) for batch in self.sink.batches if batch.epoch.name == self.transmitter.epoch.name
                for t in batch.block.time]  # fmt: skip


@contextlib.contextmanager
def world(pace: Pace = PAUSED, slow: Any = None, fast: Any = None, **options: Any) -> Iterator[tuple[Radar, Radar]]:
    """A slow and a fast radar on the air; slow, fast: other engines."""
    command_worker = CommandWorker(GroupClock())
    radars = []
    for engine in (slow or FakeEngine(SLOW), fast or FakeEngine(FAST)):
        sink = RecordingSink()
        made = Transmitter(
            engine, Settings(pace=pace), (sink,), time.monotonic, factory(), command_worker=command_worker, **options
        )
        radars.append(Radar(made, sink))
    try:
        for radar in radars:
            radar.transmitter.start()
        yield radars[0], radars[1]
    finally:
        for radar in radars:
            radar.transmitter.stop(SOON)


def settled(*radars: Radar) -> None:
    """Waits until radars that are paused have sent all that they are to send."""
    until(
        lambda: all(radar.pacer.next > radar.times[-1] for radar in radars if radar.times)
    )  # the clock knows what was sent
    until(lambda: all(radar.pacer.idle for radar in radars))


def test_a_step_of_one_radar_takes_the_others_to_the_same_time() -> None:
    with world() as (slow, fast):
        slow.pacer.step(6)
        slow.sink.wait_for(lambda: slow.sink.spokes == 6)
        settled(slow, fast)
        assert slow.sink.spokes == 6 and slow.times[-1] == pytest.approx(5 * PERIOD["slow"])
        assert fast.times[-1] <= slow.times[-1] < fast.times[-1] + PERIOD["fast"]
        fast.pacer.step(11)
        fast.sink.wait_for(lambda: fast.sink.spokes == 8 + 11)
        settled(slow, fast)
        assert slow.times[-1] <= fast.times[-1] < slow.times[-1] + PERIOD["slow"]
    assert fast.sink.numbers == list(range(19)) and slow.sink.numbers == list(range(slow.sink.spokes))


def test_pause_pace_and_run_act_on_all_radars() -> None:
    with world() as (slow, fast):
        slow.pacer.set(replace(slow.pacer.settings, pace=FLAT_OUT))
        assert fast.pacer.settings.pace == FLAT_OUT
        for radar in (slow, fast):
            radar.sink.wait_for(lambda r=radar: r.sink.spokes > 50)  # type: ignore[misc]
        fast.pacer.set(replace(fast.pacer.settings, transmit=True, pace=PAUSED))
        assert slow.pacer.settings.pace == PAUSED
        settled(slow, fast)
        front = max(slow.times[-1], fast.times[-1])
        assert front < slow.times[-1] + PERIOD["slow"] and front < fast.times[-1] + PERIOD["fast"]
        slow.pacer.set(replace(slow.pacer.settings, transmit=False))  # but standby is each radar's own
        assert fast.pacer.settings.transmit


def test_no_radar_runs_ahead_of_another() -> None:
    """As fast as possible, while one has no spokes: the other waits after the block that MAX_LEAD reaches into."""
    turns = threading.Semaphore(0)
    with world(FLAT_OUT, fast=FakeEngine(FAST, turns=turns)) as (slow, fast):
        until(lambda: slow.pacer.next == pytest.approx(5 * PERIOD["slow"]))
        assert slow.sink.spokes == 5 and 5 * PERIOD["slow"] > MAX_LEAD and not fast.sink.spokes
        for _ in range(100):
            turns.release()
        slow.sink.wait_for(lambda: slow.sink.spokes > 100)
        assert fast.times[-1] > slow.times[100] - MAX_LEAD - 5 * PERIOD["fast"]


def test_a_radar_that_has_failed_holds_nobody() -> None:
    with world(FLAT_OUT, fast=FakeEngine(FAST, dies_at=20), restarts=0) as (slow, fast):
        slow.sink.wait_for(lambda: slow.sink.spokes > 500)
        until(lambda: fast.transmitter.state.fault is not None)
        assert fast.sink.spokes <= 20


def test_a_radar_that_is_held_holds_all() -> None:
    clock = GroupClock()
    free, held = (Pacer(Settings(pace=FLAT_OUT), lambda: 0.0, clock, held=holds) for holds in (False, True))
    assert free.held and free.idle and free.delay(0.0, 0.0) == math.inf
    held.fail()
    assert not free.held  # as long as it has failed
    held.begin()
    assert free.held
    held.release()
    assert not free.held and not held.held and free.delay(0.0, 0.0) == 0.0


@pytest.mark.parametrize("pace", [PAUSED, FLAT_OUT])
def test_another_scene_begins_at_once_and_at_time_0_on_all_radars(pace: Pace) -> None:
    with world() as (slow, fast):
        fast.pacer.step(40)
        slow.sink.wait_for(lambda: slow.sink.spokes == 27)  # 39 x 2 / 3 and the one at time 0
        settled(slow, fast)
        slow.pacer.set(replace(slow.pacer.settings, pace=pace))
        before = [len(radar.sink.epochs) for radar in (slow, fast)]
        slow.pacer.group_clock.restart()
        for radar, engine in ((slow, FakeEngine(FAST)), (fast, FakeEngine(SLOW))):
            radar.transmitter.switch_to(prepared(engine))  # type: ignore[arg-type]
        for radar, epochs in zip((slow, fast), before, strict=True):
            radar.sink.wait_for(lambda r=radar, n=epochs: len(r.sink.epochs) == n + 1)  # type: ignore[misc]
        if pace == PAUSED:
            settled(slow, fast)
            assert slow.times == fast.times == []
            slow.pacer.step(1)
        for radar in (slow, fast):
            radar.sink.wait_for(lambda r=radar: len(r.times) >= 1)  # type: ignore[misc]
            assert radar.times[0] == 0.0


def test_one_schedule_serves_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second radar's first spoke is due when its time is, not at once. Each that is sent wakes the other radar."""
    now, clock, woken = 10.0, GroupClock(), list[float]()
    monkeypatch.setattr(clock.changed, "notify_all", lambda: woken.append(clock.front))
    one, other = (Pacer(Settings(), lambda: now, clock) for _ in range(2))
    assert one.delay(0.0, 0.0) == 0.0
    assert other.delay(0.2, 0.2) == pytest.approx(0.2)
    one.sent(0.0)
    other.sent(0.1)
    assert clock.front == 0.1 and woken == [0.0, 0.1]

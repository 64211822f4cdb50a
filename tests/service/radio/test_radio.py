"""The short modules of a radar on the air, each under its name."""

import contextlib
import math
import os
import signal
import socket
import threading
from collections.abc import Iterator
from dataclasses import replace

import pytest

from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import Child, ForkServer
from radar_service.service.radio import status
from radar_service.service.radio.forks import RUN, NewSpare, PlanChild, Spares, SpareTakesOver
from radar_service.service.radio.pacer import BATCH_SPOKES, LATE_LIMIT, WINDOW, Schedule, batch_spokes
from radar_service.service.radio.radio_state import Failed, State
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.processes.test_fork_server import is_gone, until
from tests.service.fake import FakeEngine, factory, scene
from tests.service.radio.recording import SOON


# status: the state of a radar, its readiness and its health.
def station(clock: float = 0.0, **settings: object) -> Station:
    made = replace(Settings(), **settings)  # type: ignore[arg-type]
    return Station("0", FakeEngine(scene()), factory(), settings=made, clock=lambda: clock)


@pytest.mark.parametrize(
    ("settings", "state", "ready"),
    [({}, "running", False), ({"pace": Pace("pause")}, "paused", True), ({"transmit": False}, "standby", True)],
)
def test_the_state_follows_the_settings(settings: dict[str, object], state: str, ready: bool) -> None:
    radar = station(**settings)
    assert (status.state(radar), status.is_ready(radar)) == (state, ready) and state in status.STATES


def test_a_fault_comes_before_a_restart_and_that_before_a_pause() -> None:
    radar = station(pace=Pace("pause"))
    radio = radar.transmitter.state
    radio.handle(Failed("it broke", 0.0))
    assert (status.state(radar), status.is_ready(radar)) == ("restarting", False)
    radio.now, radio.fault = State.FAILED, "it broke"
    assert status.state(radar) == "failed" and status.health(radar)["fault"] == "it broke"


@pytest.mark.parametrize(("reached", "state"), [(0.96, "behind"), (0.98, "running")])
def test_a_radar_below_its_pace_is_behind(reached: float, state: str) -> None:
    radar = station(clock=1.0)
    radar.transmitter.pacer.group_clock.schedule.sent(0.0, 0.0)
    radar.transmitter.pacer.group_clock.schedule.sent(1.0, reached)
    assert status.state(radar) == state and status.health(radar)["factor_reached"] == pytest.approx(reached)


def test_spokes_make_a_radar_ready_and_stopping_ends_that() -> None:
    radar = station()
    radar.transmitter.state.sent = 1
    assert status.is_ready(radar)
    radar.stopping = True
    assert not status.is_ready(radar)


# pacer: the arithmetic of pacing, on a clock that the test moves.
PERIOD = 2.5 / 720  # s per spoke at 24 rpm


def test_a_message_holds_ten_to_twenty_milliseconds() -> None:
    for factor in (0.1, 1.0, 2.0, 5.0):
        spokes = batch_spokes(factor, PERIOD)
        assert spokes == 1 or 0.010 <= spokes * PERIOD / factor <= 0.020
    assert batch_spokes(1.0, PERIOD) == 4 and batch_spokes(1.0, 1.0) == 1
    assert batch_spokes(1e5, PERIOD) == batch_spokes(1.7e308, PERIOD) == batch_spokes(math.inf, PERIOD) == BATCH_SPOKES
    assert batch_spokes(5e-324, PERIOD) == 1


def test_spokes_are_due_in_step_with_the_wall_clock() -> None:
    schedule = Schedule()
    assert schedule.delay(100.0, 7.0, 2.0) == 0.0  # whatever comes first is due now
    assert schedule.delay(100.0, 9.0, 2.0) == pytest.approx(1.0)
    assert schedule.delay(101.25, 9.0, 2.0) == pytest.approx(-0.25)
    assert schedule.delay(101.25, 1e9, math.inf) == 0.0


def test_a_little_late_is_caught_up_and_much_too_late_is_not() -> None:
    schedule = Schedule()
    schedule.delay(0.0, 0.0, 1.0)
    schedule.delay(1.0 + 0.9 * LATE_LIMIT, 1.0, 1.0)
    assert schedule.slips == 0 and schedule.delay(2.0, 2.0, 1.0) == pytest.approx(0.0)
    schedule.delay(3.0 + 1.1 * LATE_LIMIT, 3.0, 1.0)
    assert schedule.slips == 1 and schedule.delay(3.0 + 1.1 * LATE_LIMIT, 4.0, 1.0) == pytest.approx(1.0)


def test_the_factor_reached_is_measured_and_sinks_when_nothing_comes() -> None:
    schedule = Schedule()
    assert schedule.reached(0.0) is None
    for k in range(101):
        schedule.sent(k * 0.1, k * 0.3)
    assert schedule.reached(10.0) == pytest.approx(3.0)
    assert schedule.reached(10.0 + WINDOW) == pytest.approx(1.5, rel=0.02)  # a window's first sample lies up to 0.1 s early
    assert schedule.reached(1e6) == pytest.approx(0.0, abs=1e-4)


def test_lag_is_how_late_the_newest_spokes_are() -> None:
    schedule = Schedule()
    for now, simulated, lag in ((100.0, 0.0, 0.0), (100.1, 0.2, 0.0), (100.3, 0.2, 0.1), (100.2, 0.2, 0.0)):
        schedule.delay(now, simulated, 1.0)
        assert schedule.lag == pytest.approx(lag, abs=1e-9)


# forks: spares of processes.
def counting(control: Channel, data: Channel) -> None:
    """Counts what it is told, and so do its spares. It looks after its spare when it is told 0; not while it answers: -0.5."""
    count = control.receive()
    spares, answering = Spares(control, data), threading.Lock()
    while True:
        spares.first()
        with contextlib.suppress(SpareTakesOver):
            while True:
                count += (number := spares.ends[1].receive())
                if not number:
                    spares.renew(answering)
                if number == -0.5:
                    with answering:
                        spares.renew(answering)
                spares.ends[1].send((spares.is_spare, count))


@pytest.fixture
def child(fork_server: ForkServer) -> Iterator[Child]:
    child = fork_server.child(counting)
    child.control.send(5)
    yield child
    child.close()


def spare_of(child: Child) -> Child:
    return Child(child.control.receive(SOON), *child.control.receive_ends(2))


def told(child: Child, number: float) -> tuple[bool, float]:
    child.data.send(number)
    answer: tuple[bool, float] = child.data.receive(SOON)
    return answer


def test_a_spare_ends_with_its_channel_or_when_it_is_told_anything_else(child: Child) -> None:
    first = spare_of(child)
    first.control.send("something else")
    with pytest.raises(EOFError):
        first.control.receive(SOON)
    assert told(child, 1) == (False, 6)
    first.close()


def test_a_spare_that_has_died_is_replaced(child: Child) -> None:
    first = spare_of(child)
    assert told(child, 0) == (False, 5)  # there is nothing to do
    os.kill(first.process, signal.SIGKILL)
    until(lambda: is_gone(first.process))
    assert told(child, 1.5) == (False, 6.5)
    assert told(child, -0.5) == (False, 6)  # answers at once, without a new spare
    child.data.send(0)
    new = child.data.receive(SOON)
    assert isinstance(new, NewSpare)
    second = Child(new.process, *child.data.receive_ends(2))
    assert child.data.receive(SOON) == (False, 6)
    child.close()
    second.control.send(RUN)
    third = spare_of(second)
    assert told(second, 10) == (True, 16)
    for one in (first, second, third):
        one.close()
    until(lambda: all(is_gone(one.process) for one in (second, third)))


def measuring(control: Channel, data: Channel) -> None:
    """Has its own process measured; tells who did, and what comes after that."""
    child = PlanChild.forked(lambda: {"process": os.getpid()}, (control, data))
    assert child is not None
    until(lambda: (plan := child.measured()) is not None and control.send((os.getpid(), plan)) is None)
    control.send(child.measured())
    control.receive()


def left_waiting(control: Channel, data: Channel) -> None:
    """Tells which process measures, which it does for ever, and ends."""
    near, far = (Channel(end) for end in socket.socketpair())

    def wait() -> dict[str, object]:
        far.send(os.getpid())
        signal.pause()
        return {}

    child = PlanChild.forked(wait, (control, data))
    assert child is not None
    control.send((near.receive(), child.measured()))


def dies(control: Channel, data: Channel) -> None:
    """Has itself measured by a process that dies of it."""

    def die() -> dict[str, object]:
        os._exit(1)

    child = PlanChild.forked(die, (control, data))
    assert child is not None
    os.wait()
    assert child.measured() is None and child.measured() is None
    control.send("no plan")
    control.receive()


def test_the_plan_comes_once_from_another_process(fork_server: ForkServer) -> None:
    child = fork_server.child(measuring)
    process, plan = child.control.receive(SOON)
    assert process == child.process != plan["process"]
    assert child.control.receive(SOON) is None
    child.close()
    until(lambda: is_gone(plan["process"]))


def test_a_process_that_measures_holds_no_channel_open(fork_server: ForkServer) -> None:
    """The service learns at once that a scene's process is gone, though the one that measures lives."""
    child = fork_server.child(left_waiting)
    process, plan = child.control.receive(SOON)
    assert plan is None
    for end in (child.control, child.data):
        with pytest.raises(EOFError):
            end.receive(SOON)
    os.kill(process, signal.SIGKILL)
    until(lambda: is_gone(process))
    child.close()


def test_one_that_dies_leaves_no_plan(fork_server: ForkServer) -> None:
    child = fork_server.child(dies)
    assert child.control.receive(SOON) == "no plan"
    child.close()

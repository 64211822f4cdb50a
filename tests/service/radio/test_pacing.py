"""The arithmetic of pacing, on a clock that the test moves."""

import math

import pytest

from radar_service.service.radio.pacing import BATCH_SPOKES, LATE_LIMIT, WINDOW, Schedule, batch_spokes

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


def test_after_a_restart_the_next_spoke_is_due_at_once() -> None:
    schedule = Schedule()
    schedule.delay(0.0, 0.0, 1.0)
    schedule.restart()
    assert schedule.delay(50.0, 1.0, 1.0) == 0.0 and schedule.slips == 0


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

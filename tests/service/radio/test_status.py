"""The state of a radar, its readiness and its health."""

from dataclasses import replace

import pytest

from radar_service.service.radio import status
from radar_service.service.radio.radio_state import Failed, State
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.service.fake import FakeEngine, factory, scene


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
    radar.transmitter.pacer.schedule.sent(0.0, 0.0)
    radar.transmitter.pacer.schedule.sent(1.0, reached)
    assert status.state(radar) == state and status.health(radar)["factor_reached"] == pytest.approx(reached)


def test_spokes_make_a_radar_ready_and_stopping_ends_that() -> None:
    radar = station()
    radar.transmitter.state.sent = 1
    assert status.is_ready(radar)
    radar.stopping = True
    assert not status.is_ready(radar)

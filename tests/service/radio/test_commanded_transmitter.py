"""What commands to one transmitter act on, and when it takes them."""

import math
from dataclasses import replace

import pytest

from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio.commanded_transmitter import IN_SINKS, SPOKES_BETWEEN, CommandedTransmitter, CommandPace
from radar_service.service.radio.pacer import Pacer
from radar_service.service.radio.pacing import LATE_LIMIT
from radar_service.service.radio.prefetch import SpokeWorker
from radar_service.service.radio.transmitter_state import Event, TransmitterState
from radar_service.service.radio.worker_supervisor import RestartLimiter, WorkerSupervisor
from radar_service.service.settings import Settings
from radar_service.world.scene import Scene
from tests.service.fake import AZIMUTHS, FakeEngine, commanded, factory, scene, steerable_scene


class Parts:
    """A commanded transmitter, and the parts of the transmitter that it reads. The clock of the wall stands."""

    def __init__(self, of: Scene | None = None) -> None:
        def clock() -> float:
            return 0.0

        self.engine, self.state = FakeEngine(of or scene()), TransmitterState()
        self.pacer = Pacer(Settings(), clock)
        self.engines = WorkerSupervisor(self.engine, factory(), RestartLimiter(3, clock), self.pacer.group_clock.changed)
        self.radar = CommandedTransmitter(self.state, self.pacer, self.engines, clock)
        self.state.on(Event.START)

    def go_on(self) -> None:
        """Lets another engine wait that goes on with the second scan."""
        worker = SpokeWorker(engine := FakeEngine(self.engine.scene), first=AZIMUTHS)
        engine.scene_request = replace(self.engine.scene_request, goes_on=True)
        self.engines.switch_to(worker)

    def claim(self, part: SpokeBlock) -> bool:
        """Claims the spokes of a block."""
        return self.radar.claim(part.first, len(part), part.commands)


def test_after_commands_it_takes_others_when_enough_was_sent() -> None:
    its = Parts()
    assert its.radar.takes_commands
    its.radar.commanded()
    assert not its.radar.takes_commands
    for first in range(0, SPOKES_BETWEEN, 4):
        assert not its.radar.takes_commands
        assert its.claim(its.engine.block(first, 4))
        its.radar.pace.given()
    assert its.radar.takes_commands


def test_while_nothing_can_be_sent_it_takes_commands() -> None:
    its = Parts()
    its.radar.commanded()
    its.state.on(its.state.fail("it broke"))
    assert its.radar.takes_commands
    its.state.on(Event.RESTARTED)
    assert not its.radar.takes_commands


def test_commands_act_after_what_was_claimed_and_none_is_claimed_where_another_engine_goes_on() -> None:
    its = Parts()
    its.go_on()
    assert its.claim(its.engine.block(20, 4))
    period = its.engine.info.radar.spoke_period
    assert its.radar.steered == (its.engines.worker, AZIMUTHS, 23 * period)
    assert (
        not its.claim(its.engine.block(AZIMUTHS - 1, 2))
        and not its.claim(its.engine.block(AZIMUTHS, 4))
        and its.radar.unsent == AZIMUTHS
    )


def test_spokes_that_a_command_changes_are_not_claimed() -> None:
    its = Parts(steerable_scene())
    its.claim(its.engine.block(0, 5))
    part = its.engine.block(5, 5)
    commanded(its.engines.worker, 5, "buoy", {"speed_kn": 5})
    assert not its.claim(part) and its.radar.unsent == 5
    assert its.claim(its.engine.block(5, 5)) and its.radar.unsent == 10


def test_an_engine_that_goes_on_keeps_the_time_of_the_newest_spoke() -> None:
    its = Parts()
    its.claim(its.engine.block(20, 4))
    its.radar.go_on_from(48)
    assert its.radar.unsent == 48 and its.radar.newest > 0
    its.radar.go_on_from(0, same_scene=False)
    assert (its.radar.unsent, its.radar.newest) == (0, -math.inf)


def test_where_another_scene_is_about_to_begin_commands_act_on_its_engine() -> None:
    its = Parts()
    its.claim(its.engine.block(20, 4))
    its.pacer.group_clock.restart()
    assert its.radar.steered is None
    worker = SpokeWorker(FakeEngine(scene("second")))
    its.engines.switch_to(worker)
    assert its.radar.steered == (worker, 0, -math.inf)


def test_one_that_has_failed_or_is_to_stop_is_left_out() -> None:
    its = Parts()
    its.state.on(its.state.fail("it broke"))
    assert its.radar.is_commanded
    its.state.on(Event.GIVEN_UP)
    assert not its.radar.is_commanded
    its.state.on(Event.TAKEN_OVER)
    assert its.radar.is_commanded
    its.pacer.stop()
    assert not its.radar.is_commanded


class Played:
    """A radar that sends a spoke each `period`, after commands whose first spoke takes `cost` to compute [s]."""

    def __init__(self, cost: float, period: float = 0.003) -> None:
        self.now, self.cost, self.period = 100.0, cost, period
        self.pace = CommandPace(lambda: self.now)
        self.commands: list[float] = []
        self.sent: list[float] = []

    def run(self, seconds: float) -> None:
        """Takes a command whenever it may, as one always waits. It is never late: its schedule starts anew when it is."""
        end = self.now + seconds
        while self.now < end:
            if self.pace.allows(waits=True):
                self.commands.append(self.now)
                self.pace.commanded()
                self.now += self.cost
            self.pace.computed()
            self.now += self.period
            self.pace.give(1)
            self.pace.given()
            self.sent.append(self.now)


@pytest.mark.parametrize("cost", [0.26, 0.5, 1.0])
def test_a_flood_of_commands_leaves_the_feed_half_of_the_time(cost: float) -> None:
    """Between two commands as much time, or SPOKES_BETWEEN spokes, is for the feed."""
    played = Played(cost)
    played.run(20.0)
    assert len(played.commands) > 5
    between = min(cost, SPOKES_BETWEEN * played.period)
    for first, second in zip(played.commands[:-1], played.commands[1:], strict=True):
        assert second - first >= cost + between - 1e-9
        assert sum(first < time <= second for time in played.sent) >= between / played.period - 1


def test_a_command_is_taken_at_once_while_spokes_wait_until_they_are_due() -> None:
    now = [5.0]
    pace = CommandPace(lambda: now[0])
    assert pace.allows(waits=False)
    pace.commanded()
    assert not pace.allows(waits=False) and not pace.allows(waits=True)  # nothing is computed yet
    now[0] += LATE_LIMIT
    pace.computed()
    assert pace.allows(waits=True) and not pace.allows(waits=False)
    pace.commanded()
    now[0] += 0.5
    pace.computed()
    now[0] += 0.4
    pace.computed()  # the first one counts
    assert not pace.allows(waits=True)
    now[0] += 0.1 + 1e-9
    assert pace.allows(waits=True)


def test_what_the_sinks_keep_and_another_engine_let_commands_through() -> None:
    now = [5.0]
    pace = CommandPace(lambda: now[0])
    pace.commanded()
    pace.give(1)
    assert not pace.allows(waits=False)
    now[0] += 2.0 * IN_SINKS
    assert pace.allows(waits=False)
    pace.given()
    assert not pace.allows(waits=False)
    pace.begin()
    assert pace.allows(waits=False)

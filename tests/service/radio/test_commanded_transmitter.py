"""What commands to one transmitter act on, and when it takes them."""

import math

from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio.command_pace import SPOKES_BETWEEN
from radar_service.service.radio.commanded_transmitter import CommandedTransmitter
from radar_service.service.radio.handover import Handover
from radar_service.service.radio.pacer import Pacer
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

        self.engine, self.state, self.handover = FakeEngine(of or scene()), TransmitterState(), Handover()
        self.pacer = Pacer(Settings(), clock)
        self.engines = WorkerSupervisor(self.engine, factory(), RestartLimiter(3, clock), self.pacer.group_clock.changed)
        self.radar = CommandedTransmitter(self.state, self.pacer, self.engines, self.handover, clock)
        self.state.on(Event.START)

    def agree(self) -> None:
        """Agrees on a handover at the end of the scan."""
        self.handover.agree(1, self.engine.info.radar, 0, False, 0.0)

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
    its.agree()
    its.radar.unsent = AZIMUTHS
    assert its.radar.takes_commands


def test_commands_act_after_what_was_claimed_and_none_is_claimed_from_a_handover_on() -> None:
    its = Parts()
    its.agree()
    assert its.claim(its.engine.block(20, 4))
    period = its.engine.info.radar.spoke_period
    assert its.radar.steered == (its.engines.worker, AZIMUTHS, 23 * period)
    assert not its.claim(its.engine.block(AZIMUTHS, 4)) and its.radar.unsent == AZIMUTHS


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

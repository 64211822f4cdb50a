"""What a radar does next, by events and instructions alone: no thread, no socket, no clock."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from radar_service.service.radio.pacer import LATE_LIMIT, RunControl
from radar_service.service.radio.radio_state import (
    IN_SINKS,
    RESTART_WINDOW,
    SPOKES_BETWEEN,
    CommandPace,
    CommandsDone,
    Due,
    Failed,
    GiveUp,
    Instruction,
    Looked,
    Open,
    Opened,
    RadioState,
    Restart,
    Restarted,
    Send,
    Sent,
    Skip,
    State,
    Take,
    Taken,
    TakenOver,
    TakeOver,
    Wait,
)  # fmt: skip
from radar_service.service.settings import Pace, Settings
from tests.service.fake import AZIMUTHS, FakeEngine, power_of, scene

FLAT_OUT = RunControl(0, Settings(pace=Pace("run", math.inf)), 0)
LOOK = Looked(0.0, FLAT_OUT)
STANDBY = replace(FLAT_OUT, settings=replace(FLAT_OUT.settings, transmit=False))
SOURCE = FakeEngine(scene())
RADAR = SOURCE.scene.radar
BROKEN = Failed("it broke", 0.0)


class Played:
    """A radar on the air whose spoke source is always ready. sent: what its sinks were given, in standby what was dropped."""

    def __init__(self, restarts: int = 3) -> None:
        self.state = RadioState(RADAR, None, restarts)
        self.sent: list[Send] = []

    def send(self, look: Looked = LOOK, **due: float) -> Sequence[Instruction]:
        """Looks and sends what that gives; returns what the radar does in place of that."""
        instructions = self.state.handle(look)
        if instructions == (Take(),):
            self.state.handle(Taken(SOURCE.block(self.state.unsent, min(5, AZIMUTHS - self.state.unsent % AZIMUTHS))))
            instructions = self.state.handle(look)
        if not isinstance(instructions[0], Send):
            return instructions
        for each in self.state.handle(Due(look.time, **due)):
            assert isinstance(each, Send)
            self.sent.append(each)
            self.state.handle(Sent())
        return instructions

    def send_until(self, spoke: int) -> None:
        while self.state.unsent < spoke:
            self.send()

    def take_over(self, first: int = 0, goes_on: bool = False) -> None:
        """Another spoke source takes over, as an instruction says."""
        self.state.handle(TakenOver(RADAR, first, goes_on))

    @property
    def numbers(self) -> list[tuple[int, int]]:
        """Of the spokes that were sent: in their epoch, and from t = 0."""
        return [(each.number + k, each.part.first + k) for each in self.sent for k in range(len(each.part))]


def test_spokes_are_sent_in_order_with_the_spoke_before_them() -> None:
    played = Played()
    played.send_until(AZIMUTHS)
    assert played.numbers == [(n, n) for n in range(AZIMUTHS)] and played.state.sent == AZIMUTHS
    assert played.state.simulated == pytest.approx(AZIMUTHS * RADAR.spoke_period)
    for each in played.sent:
        expected = power_of([each.part.first - 1], RADAR.bins)[0] if each.number else None
        np.testing.assert_array_equal(each.before, expected)  # type: ignore[arg-type]


def test_a_change_before_spokes_are_due_leaves_them_for_the_next_look() -> None:
    played = Played()
    assert played.state.handle(LOOK) == (Take(),)
    played.state.handle(Taken(SOURCE.block(0, 5)))
    assert isinstance(played.state.handle(LOOK)[0], Send)  # an order comes; the spokes were not due
    one = replace(FLAT_OUT, steps=1)
    played.send(LOOK._replace(run=one))
    assert played.numbers == [(0, 0)]
    played.state.handle(Taken(None))  # they come again with labels
    assert played.state.handle(LOOK) == (Take(),)


def test_spokes_that_a_command_changes_are_not_sent() -> None:
    played = Played()
    played.send(unknown=3)  # the command came while they waited
    assert not played.sent and played.state.unsent == 0
    played.send(LOOK._replace(unknown=3))
    assert played.numbers == [(0, 0), (1, 1), (2, 2)]
    played.state.handle(Taken(SOURCE.block(3, 5)))
    assert played.state.handle(LOOK._replace(unknown=3)) == (Take(),)


def test_standby_uses_no_numbers_and_time_goes_on() -> None:
    played = Played()
    played.send(LOOK._replace(run=STANDBY))
    played.send()
    assert (played.sent[-1].number, played.sent[-1].part.first) == (0, 5) and played.state.sent == 5


def test_another_range_opens_an_epoch_at_once() -> None:
    played = Played()
    played.send()
    near = replace(FLAT_OUT, settings=replace(FLAT_OUT.settings, range=100.0))
    assert played.state.handle(LOOK._replace(run=near)) == (Open(100.0), Take())
    played.send(LOOK._replace(run=near))
    assert played.numbers[5] == (0, 5)


def test_another_scene_begins_when_the_scan_ends_or_at_once() -> None:
    played = Played()
    pending = LOOK._replace(pending=True)
    played.send()
    while (instructions := played.send(pending)) != (TakeOver(None),):
        assert isinstance(instructions[0], Send)
    assert played.state.unsent == AZIMUTHS
    played.take_over()
    assert (played.state.unsent, played.state.number, played.state.simulated) == (0, 0, 0.0)
    assert played.state.newest == -math.inf
    played.send()
    assert played.state.handle(pending._replace(at_once=True)) == (TakeOver(None),)


def test_one_that_goes_on_begins_with_its_first_spoke_and_keeps_the_time() -> None:
    played = Played()
    look = LOOK._replace(pending=True, due=RADAR.time_of_spokes(12.0))
    while played.send(look, due=look.due) != (TakeOver(None),):
        assert played.state.unsent <= 12
    assert played.state.unsent == 12
    newest = played.state.newest
    played.take_over(12, goes_on=True)
    assert played.state.newest == newest and played.state.unsent == 12
    played.send()
    assert played.sent[-1].before is None  # the spoke before it is of another radar


def test_a_failed_spoke_source_is_replaced_in_the_next_scan_and_leaves_a_gap() -> None:
    played = Played()
    played.send_until(10)
    played.state.handle(BROKEN)
    assert played.state.now is State.RESTARTING and played.state.unsent == AZIMUTHS
    assert played.state.handle(LOOK) == (Restart("it broke", 1),)
    played.state.handle(Failed("that too", 0.0))
    assert played.state.handle(LOOK) == (Restart("that too", 1),) and played.state.restarts == 2
    gap = Skip(10, AZIMUTHS - 10, "the radar was started again after: that too")
    assert played.state.handle(Restarted(transmit=True)) == (gap,)
    played.send()
    assert played.numbers[-1] == (AZIMUTHS + 4, AZIMUTHS + 4)


def test_in_standby_the_gap_has_no_numbers() -> None:
    played = Played()
    played.send(LOOK._replace(run=STANDBY))
    played.state.handle(BROKEN)
    assert not played.state.handle(Restarted(transmit=False))
    played.send()
    assert (played.sent[-1].number, played.sent[-1].part.first) == (0, AZIMUTHS)


def test_what_fails_too_often_gives_up_until_another_scene_begins() -> None:
    played = Played(restarts=1)
    for time in (0.0, RESTART_WINDOW + 1.0):  # the first one is forgotten
        played.state.handle(Failed("it broke", time))
        assert isinstance(played.state.handle(LOOK)[0], Restart)
    played.state.handle(Failed("it broke", RESTART_WINDOW + 2.0))
    assert played.state.fault is None and played.state.handle(LOOK) == (GiveUp("it broke"),)
    assert played.state.now is State.FAILED and played.state.fault == "it broke"
    assert played.state.handle(LOOK) == (Wait(),)
    assert played.state.handle(LOOK._replace(pending=True)) == (TakeOver(None),)
    played.take_over()
    assert (
        played.state.now is State.SENDING and played.state.fault == "it broke"
    )  # else who joins now is told of the old epoch
    played.state.handle(Opened())
    assert played.state.fault is None


def test_one_that_is_pending_takes_the_place_of_one_that_fails() -> None:
    played = Played(restarts=0)
    played.state.handle(BROKEN)
    assert played.state.handle(LOOK._replace(pending=True, due=1e9)) == (TakeOver(None),)
    assert played.state.restarts == 0


@pytest.mark.parametrize("failed", [False, True])
def test_a_radar_that_stops_keeps_its_fault(failed: bool) -> None:
    played = Played(restarts=0)
    if failed:
        played.state.handle(BROKEN)
        played.state.handle(LOOK)
    assert not played.state.handle(LOOK._replace(stopping=True, pending=True))
    assert played.state.now is State.STOPPED and played.state.fault == ("it broke" if failed else None)


def test_after_commands_it_takes_others_when_enough_was_sent_or_nothing_can_be() -> None:
    played = Played()
    assert played.state.takes_commands(0.0, waits=False)
    played.state.handle(CommandsDone(0.0))
    while played.state.unsent < SPOKES_BETWEEN:
        assert not played.state.takes_commands(0.0, waits=False)
        played.send()
    assert played.state.takes_commands(0.0, waits=False)
    played.state.handle(CommandsDone(0.0))
    played.state.handle(BROKEN)
    assert played.state.takes_commands(0.0, waits=False)


def test_a_command_is_taken_at_once_while_spokes_wait_until_they_are_due() -> None:
    pace = CommandPace()
    pace.commanded(5.0)
    assert not pace.allows(5.0, waits=True)  # nothing is computed yet
    pace.computed(5.0 + LATE_LIMIT)
    assert pace.allows(5.0 + LATE_LIMIT, waits=True) and not pace.allows(5.0 + LATE_LIMIT, waits=False)
    pace.commanded(6.0)
    pace.computed(6.5)
    pace.computed(6.9)  # the first one counts
    assert not pace.allows(6.9, waits=True) and pace.allows(7.0 + 1e-9, waits=True)


def test_what_the_sinks_keep_lets_commands_through() -> None:
    played = Played()
    played.state.handle(CommandsDone(5.0))
    played.state.handle(Taken(SOURCE.block(0, 1)))
    played.state.handle(LOOK)
    played.state.handle(Due(5.0))
    assert not played.state.takes_commands(5.0, waits=False)
    assert played.state.takes_commands(5.0 + 2.0 * IN_SINKS, waits=False)
    played.state.handle(Sent())
    assert not played.state.takes_commands(5.0 + 2.0 * IN_SINKS, waits=False)


@pytest.mark.parametrize("cost", [0.26, 0.5, 1.0])
def test_a_flood_of_commands_leaves_the_feed_half_of_the_time(cost: float) -> None:
    """Each block costs so much after a command, a spoke 3 ms. Between two commands as much, or SPOKES_BETWEEN spokes, is for the
    feed."""
    pace, now, commands, period = CommandPace(), 0.0, list[float](), 0.003
    while now < 20.0:
        if pace.allows(now, waits=True):
            commands.append(now)
            pace.commanded(now)
            now += cost
        pace.computed(now)
        now += period
        pace.sent += 1
    assert len(commands) > 5
    assert min(np.diff(commands)) >= cost + min(cost, SPOKES_BETWEEN * period) - 1e-9

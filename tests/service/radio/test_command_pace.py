"""When a radar takes commands: a flood of them leaves it half of its time, and a radar that waits takes one at once."""

import pytest

from radar_service.service.radio.command_pace import IN_SINKS, SPOKES_BETWEEN, CommandPace
from radar_service.service.radio.pacing import LATE_LIMIT


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

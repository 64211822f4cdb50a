"""A transmitter as the command worker has it: what commands act on, and whether they may come now.

After commands the spoke source computes anew. A radar that is late first sends spokes; one whose spokes wait until they are
due takes the next commands at once. Where commands take so long that the schedule starts anew, spokes wait although they are
late: then the radar sends for as long as the commands took.
"""

import math
from collections.abc import Callable

from radar_service.service.radio.command_worker import CommandQueue, Steered
from radar_service.service.radio.pacer import Pacer
from radar_service.service.radio.pacing import LATE_LIMIT
from radar_service.service.radio.transmitter_state import State, TransmitterState
from radar_service.service.radio.worker_supervisor import WorkerSupervisor

SPOKES_BETWEEN = 16  # that a radar which is late sends after commands before it takes others: half a block
IN_SINKS = 0.05  # s after which sinks that still have spokes are taken to wait for a client


class CommandPace:
    """Counts what one radar has sent since the last commands, and how long they took."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """clock: of the wall [s]."""
        self._clock = clock
        self._sent = SPOKES_BETWEEN  # since the last commands
        self._commanded = self._ready = 0.0  # when they came, and when the first spoke after them was computed
        self._given = math.inf  # since when the sinks have spokes; they may wait for clients

    def begin(self) -> None:
        """Begins anew: the spoke source goes on from elsewhere."""
        self._sent = SPOKES_BETWEEN

    def commanded(self) -> None:
        """Notes commands."""
        self._sent, self._commanded, self._ready = 0, self._clock(), math.inf

    def computed(self) -> None:
        """Notes that spokes which know all commands can be sent."""
        self._ready = min(self._ready, self._clock())

    def give(self, spokes: int) -> None:
        """Notes that the sinks are given so many spokes."""
        self._sent, self._given = self._sent + spokes, self._clock()

    def given(self) -> None:
        """Notes that the sinks have taken them."""
        self._given = math.inf

    def allows(self, waits: bool) -> bool:
        """Returns whether commands may come now. waits: whether spokes wait until they are due."""
        now, cost = self._clock(), self._ready - self._commanded
        has_rested = now - self._ready >= (cost if cost > LATE_LIMIT else 0.0)
        return self._sent >= SPOKES_BETWEEN or now - self._given >= IN_SINKS or (waits and has_rested)


class CommandedTransmitter:
    """A CommandedRadar. The transmitter's thread writes it with the clock's lock held, the command worker reads it so.

    commands: those that wait for the command worker.
    unsent: number of the first spoke that was not given to the sinks, from t = 0.
    newest: time of the last one that was [s].
    pace: how many commands the feed bears.
    """

    def __init__(
        self, state: TransmitterState, pacer: Pacer, supervisor: WorkerSupervisor, clock: Callable[[], float]
    ) -> None:
        """clock: of the wall [s]; the rest is the transmitter's."""
        self._state, self._pacer, self._supervisor = state, pacer, supervisor
        self.commands = CommandQueue(pacer.group_clock.let_command)
        self.unsent, self.newest = 0, -math.inf
        self.pace = CommandPace(clock)

    @property
    def is_commanded(self) -> bool:
        """Whether the transmitter runs: it has not failed, and does not stop."""
        return self._state.fault is None and not self._pacer.stopping

    @property
    def takes_commands(self) -> bool:
        """Whether commands may come: enough was sent since the last ones, or nothing can be sent now."""
        return self._state.now is State.RESTARTING or self.pace.allows(self._pacer.waiting)

    @property
    def steered(self) -> Steered | None:
        """What commands act on; None while another scene is about to begin."""
        if not self._pacer.is_outdated:
            return Steered(self._supervisor.worker, self.unsent, self.newest)
        pending = self._supervisor.pending
        return None if pending is None else Steered(pending, 0, -math.inf)

    def commanded(self) -> None:
        """Counts the commands that came, and lets the pacer go on."""
        self.pace.commanded()
        self._pacer.waiting = False

    def claim(self, first: int, count: int, commands: int) -> bool:
        """Whether so many spokes are still to be sent, and as they are; then commands act after them.

        commands: how many they know. The clock's lock is held.
        """
        worker, end = self._supervisor.worker, first + count
        last = worker.spoke_source.info.radar.time_of_spokes(float(end - 1))
        if worker.commands.first_unknown(commands) < end or last >= self._supervisor.due:
            return False
        self.unsent, self.newest = end, last
        self.pace.give(count)
        self._pacer.group_clock.let_command()
        return True

    def go_on_from(self, spoke: int, same_scene: bool = True) -> None:
        """Lets commands act from a spoke on. same_scene: whether its time goes on."""
        with self._pacer.group_clock.changed:
            self.unsent = spoke
            self.newest = self.newest if same_scene else -math.inf
            self.pace.begin()
            self._pacer.group_clock.let_command()

"""What one radar does next: events in, instructions out, without a thread, a lock, a clock or a socket.

The transmitter carries the instructions out in order and tells what comes of them. When there are no more it looks at what
other threads have ordered. It holds the clock's lock at each event.

When a change acts:
- gain, sea, rain, transmit, pace: from the next batch on. Standby sends no spokes and uses no numbers; time goes on.
- range: a new epoch at once; with a set that is sold it acts as rpm does. Another scene: a new epoch when the running scan ends;
  at once while paused or failed, and where the group has several radars, which all begin it together.
- commands: another thread (`command_worker`) carries them out. Spokes that a command changes are dropped, and come anew.
- labels and powers of sources: from the next spoke on; the blocks beyond it come again with them.
- rpm: a new epoch when the scan of a spoke source begins that is prepared meanwhile; the running scan ends there.
- the spoke source fails: another one continues the same epoch with the next scan, and the spokes between become a gap. After
  too many the radar fails and the sinks are closed, until the next scene. A spoke source that is ready takes over.
"""

import math
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from radar_service.numerics import Singles
from radar_service.radar import Radar
from radar_service.records import SpokeBlock
from radar_service.service.radio.pacer import LATE_LIMIT, RunControl, batch_spokes

RESTARTS = 3  # allowed within RESTART_WINDOW
RESTART_WINDOW = 60.0  # s: a spoke source that fails more often will fail again
SPOKES_BETWEEN = 16  # that a radar which is late sends after commands before it takes others: half a block
IN_SINKS = 0.05  # s after which sinks that still have spokes are taken to wait for a client


class State(Enum):
    """What a radar does. The value is a sentence for the documents.

    Standby, a pause and a radar that is held are no states: they are settings, which a radar obeys while it sends.
    """

    SENDING = "sends the spokes of the running spoke source when they are due; in standby it drops them then"
    RESTARTING = "has another spoke source made in place of the one that failed"
    FAILED = "has told all sinks why, and waits for another scene"
    STOPPED = "has ended"


class Looked(NamedTuple):
    """The transmitter has looked at what other threads have ordered.

    time: of the wall clock [s].
    run: settings, pace and steps.
    stopping: whether `stop` was called.
    pending: whether a spoke source waits to take over; at_once: without waiting for the end of the scan.
    due: simulated time from which its spokes replace the running ones [s]; inf where it brings another scene.
    unknown: first spoke of the block that does not know all commands, from t = 0; inf without one.
    """

    time: float
    run: RunControl
    stopping: bool = False
    pending: bool = False
    at_once: bool = False
    due: float = math.inf
    unknown: float = math.inf


class Taken(NamedTuple):
    """The spoke source has given its next block; None where it has none yet, or gives the present one again."""

    block: SpokeBlock | None


class Due(NamedTuple):
    """The spokes of `Send` are due. The fields are those of `Looked`."""

    time: float
    due: float = math.inf
    unknown: float = math.inf


class Sent(NamedTuple):
    """The sinks have taken the spokes of `Send`."""


class CommandsDone(NamedTuple):
    """Commands were carried out, at a time of the wall clock [s]."""

    time: float


class Failed(NamedTuple):
    """A spoke source or a sink has failed, at a time of the wall clock [s]."""

    reason: str
    time: float


class Restarted(NamedTuple):
    """Another spoke source has the next scan ready. transmit: whether the radar transmits."""

    transmit: bool


class TakenOver(NamedTuple):
    """The spoke source that was pending runs, from a spoke on. goes_on: whether with the scene, its time and its commands."""

    radar: Radar
    first: int
    goes_on: bool


class Opened(NamedTuple):
    """The sinks have the epoch of the spoke source that took over."""


Event = Looked | Taken | Due | Sent | CommandsDone | Failed | Restarted | TakenOver | Opened


class Take(NamedTuple):
    """Take the next block of the running spoke source: `Taken`."""


class Send(NamedTuple):
    """Wait until spokes are due, unless an order comes first. Where `Due` gives it again, the sinks take them: `Sent`.

    part: in standby dropped; number: of the first spoke in its epoch; before: power (N,) [W] of the spoke before.
    """

    part: SpokeBlock
    number: int
    run: RunControl
    before: Singles | None


class Open(NamedTuple):
    """Open a new epoch of the running spoke source, with another display range [m]."""

    range: float | None


class TakeOver(NamedTuple):
    """Let the pending spoke source take over, `TakenOver`; open its epoch with a display range [m]."""

    range: float | None


class Restart(NamedTuple):
    """Replace the failed spoke source from a scan on: `Restarted`."""

    reason: str
    scan: int


class Skip(NamedTuple):
    """Tell the sinks that spokes of this epoch never come."""

    number: int
    spokes: int
    reason: str


class GiveUp(NamedTuple):
    """End the spoke source and close the sinks."""

    reason: str


class Wait(NamedTuple):
    """Wait for another spoke source."""


Instruction = Take | Send | Open | TakeOver | Restart | Skip | GiveUp | Wait


class CommandPace:
    """What one radar has sent since the last commands, and how long they took. Times of the wall clock [s].

    A late radar sends SPOKES_BETWEEN spokes between commands; one whose spokes wait takes the next commands at once, or after
    as long as the last ones took where that is more than LATE_LIMIT: the schedule has then started anew.
    """

    def __init__(self) -> None:
        self.sent = SPOKES_BETWEEN  # since the last commands
        self.given = math.inf  # since when the sinks have spokes; they may wait for clients
        self._commanded = self._ready = 0.0  # when they came, and when the first spoke after them was computed

    def commanded(self, time: float) -> None:
        """Notes commands."""
        self.sent, self._commanded, self._ready = 0, time, math.inf

    def computed(self, time: float) -> None:
        """Notes that spokes which know all commands can be sent."""
        self._ready = min(self._ready, time)

    def allows(self, time: float, waits: bool) -> bool:
        """Returns whether commands may come now. waits: whether spokes wait until they are due."""
        cost = self._ready - self._commanded
        has_rested = time - self._ready >= (cost if cost > LATE_LIMIT else 0.0)
        return self.sent >= SPOKES_BETWEEN or time - self.given >= IN_SINKS or (waits and has_rested)


class RadioState:
    """The state of one radar. `handle` alone changes it; any thread may read `now`, `fault`, `sent`, `restarts` and `simulated`.

    now: what it does; reason: of the last failure; restarts: attempts to replace a failed spoke source.
    fault: why it has failed, from FAILED until the sinks have another epoch, also where it stops meanwhile.
    radar: of the running spoke source; block: what is still to be sent of the last one.
    unsent: first spoke not given to the sinks, from t = 0; newest: time of the one before [s], -inf without one.
    number: of the next spoke in this epoch; sent: spokes since the start; simulated: time of the next spoke [s].
    """

    def __init__(self, radar: Radar, range_max: float | None, restarts: int = RESTARTS, begins: float = 0.0) -> None:
        """range_max: of the first epoch [m]; restarts: allowed within RESTART_WINDOW; begins: time of the first spoke [s]."""
        self.now, self.reason, self.restarts = State.SENDING, "", 0
        self.fault: str | None = None
        self.radar = radar
        self.block: SpokeBlock | None = None
        self.unsent, self.newest = 0, -math.inf
        self.number, self.sent, self.simulated = 0, 0, begins
        self._range, self._limit = range_max, restarts
        self._pace = CommandPace()
        self._failures: list[float] = []  # times within RESTART_WINDOW
        self._gap = 0  # spokes that were given up with a scan
        self._send: Send | None = None
        self._last: tuple[int, Singles] | None = None  # number from t = 0 and power of the newest spoke, sent or not

    def takes_commands(self, time: float, waits: bool) -> bool:
        """Whether commands may come. time: of the wall clock [s]; waits: whether spokes wait until they are due."""
        return self.now is State.RESTARTING or self._pace.allows(time, waits)

    def handle(self, event: Event) -> Sequence[Instruction]:
        """Takes an event; returns what to do."""
        match event:
            case Looked():
                return self._look(event)
            case Taken():
                self.block = event.block
            case Due():
                return self._due(event)
            case Sent():
                self._sent()
            case CommandsDone():
                self._pace.commanded(event.time)
            case Failed():
                self._fail(event)
            case Restarted():
                return self._restarted(event.transmit)
            case TakenOver():
                self._taken_over(event)
            case Opened():
                self.fault = None
        return ()

    def _look(self, look: Looked) -> Sequence[Instruction]:
        if look.stopping:
            self.now = State.STOPPED
            return ()
        if look.pending and (self.now is not State.SENDING or self._may_begin(look)):
            self._range = look.run.settings.range
            return (TakeOver(self._range),)
        if self.now is State.SENDING:
            return self._next_spokes(look)
        if self.now is State.FAILED:
            return (Wait(),)
        if len(self._failures) <= self._limit:
            self.restarts += 1
            return (Restart(self.reason, self.unsent // self.radar.azimuths),)
        self.fault = self.reason  # before `now`: others read both without a lock
        self.now = State.FAILED
        return (GiveUp(self.reason),)

    def _may_begin(self, look: Looked) -> bool:
        """Whether the pending spoke source takes over before the next spoke."""
        if look.at_once or look.due < math.inf:
            return look.at_once or self.radar.time_of_spokes(float(self.unsent)) >= look.due
        return self.unsent % self.radar.azimuths == 0

    def _next_spokes(self, look: Looked) -> Sequence[Instruction]:
        """Takes the first spokes of the block that know all commands, one message at this pace."""
        opens: tuple[Instruction, ...] = ()
        if look.run.settings.range != self._range:
            self._range, self.number = look.run.settings.range, 0
            opens = (Open(self._range),)
        rest = self.block
        if rest is not None and look.unknown < rest.first + len(rest):
            rest = rest.part(0, int(look.unknown) - rest.first) if look.unknown > rest.first else None
        self.block = rest
        if rest is None:
            return (*opens, Take())
        self._pace.computed(look.time)
        size = batch_spokes(look.run.settings.pace.factor, self.radar.spoke_period)
        before = int(np.searchsorted(rest.time, look.due))  # a spoke source that is pending has the others
        part = rest.part(0, look.run.spokes(rest.time, min(size, max(1, before))))
        power = self._last[1] if self._last and self._last[0] == part.first - 1 else None
        self._send = Send(part, self.number, look.run, power)
        return (*opens, self._send)

    def _due(self, due: Due) -> Sequence[Instruction]:
        """Sends the spokes where they stay as they are; from now on commands act after them."""
        assert self._send
        part = self._send.part
        end = part.first + len(part)
        newest = self.radar.time_of_spokes(float(end - 1))
        if due.unknown < end or newest >= due.due:
            return ()
        self.unsent, self.newest = end, newest
        self.number += len(part) if self._send.run.settings.transmit else 0
        self._pace.sent, self._pace.given = self._pace.sent + len(part), due.time
        return (self._send,)

    def _sent(self) -> None:
        assert self._send and self.block
        part = self._send.part
        self.sent += len(part) if self._send.run.settings.transmit else 0
        self.simulated = float(part.time[-1]) + self.radar.spoke_period
        self._last = self.unsent - 1, part.power[-1].copy()
        self.block = self.block.part(len(part), len(self.block)) if len(part) < len(self.block) else None
        self._pace.given = math.inf

    def _fail(self, failed: Failed) -> None:
        """Gives up the rest of the scan: it would make the next spoke source fail, too."""
        self._failures = [time for time in self._failures if failed.time - time <= RESTART_WINDOW] + [failed.time]
        self.reason = failed.reason
        if self.now is State.SENDING:
            self.now = State.RESTARTING
            self._gap = self.radar.azimuths - self.unsent % self.radar.azimuths
            self._go_on_from(self.unsent + self._gap)

    def _restarted(self, transmit: bool) -> Sequence[Instruction]:
        self.now, self.fault = State.SENDING, None
        if not transmit:
            return ()
        first, self.number = self.number, self.number + self._gap
        return (Skip(first, self._gap, f"the radar was started again after: {self.reason}"),)

    def _taken_over(self, taken: TakenOver) -> None:
        self.now, self.radar = State.SENDING, taken.radar
        self.number, self._last = 0, None
        self.simulated = taken.radar.time_of_spokes(float(taken.first))
        self.newest = self.newest if taken.goes_on else -math.inf
        self._go_on_from(taken.first)

    def _go_on_from(self, spoke: int) -> None:
        self.unsent, self.block = spoke, None
        self._pace = CommandPace()

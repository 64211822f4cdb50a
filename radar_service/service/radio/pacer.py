"""When spokes are due: their schedule, the run control of a transmitter, its wait, and the clock of a group of radars.

Pace, pause, steps and the schedule act on all radars of a group together:
- Pause: radars that are behind follow up to the newest time that any of them has sent, so that all stop at one time.
- Steps count the spokes of the radar that was asked; the others follow in the same way.
- Run: no radar begins a spoke more than MAX_LEAD of simulated time before the next spoke of another one, at any pace.
- Another scene: `restart` ends the time of the running one; each radar begins the new one when it takes over.
"""

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radar_service.numerics import Floats
from radar_service.service.settings import Pace, Settings

MAX_LEAD = 0.25  # s of simulated time: some batches, so that radars need not wait for each other at each spoke
BATCH_SECONDS = 0.015  # of wall-clock time per message: eight to ten times the capacity of single spokes, and not visible
BATCH_SPOKES = 32  # at any speed: beyond it a message gains little (docs/accuracy.md#fan-out)
LATE_LIMIT = 0.25  # s behind after which the schedule starts anew: catching up would be a burst
WINDOW = 5.0  # s over which the achieved factor is measured
MIN_WINDOW = 0.5  # s; over less a single batch weighs too much
KEEPING_UP = 0.97  # of the requested factor: what start-up and rounding may cost before it counts as falling behind
MAX_WAIT = 3600.0  # s before the schedule is read again: a pace of 1e-300 is due in more seconds than a thread can wait


def batch_spokes(factor: float, spoke_period: float) -> int:
    """Returns how many spokes make a message: BATCH_SECONDS of them at this pace, at least one."""
    if math.isinf(factor):
        return BATCH_SPOKES
    return max(1, round(min(BATCH_SPOKES, BATCH_SECONDS * factor / spoke_period)))


class Schedule:
    """When a simulated time is due on the wall clock, and the factor that is achieved. Times in s.

    slips: times that the schedule started anew because the spoke source was late; lag: lateness at the last call of delay [s].
    """

    def __init__(self) -> None:
        self.slips = 0
        self.lag = 0.0
        self._anchor: tuple[float, float] | None = None  # wall, simulated
        self._sent: deque[tuple[float, float]] = deque()

    def restart(self) -> None:
        """Drops the anchor: the next spoke is due at once (after a pause, a change of pace, a new scene)."""
        self._anchor = None
        self._sent.clear()

    def delay(self, now: float, simulated: float, factor: float) -> float:
        """Returns the seconds until a simulated time is due, 0 or less for now. More than LATE_LIMIT late is a slip."""
        self.lag = 0.0
        if math.isinf(factor):
            return 0.0
        if self._anchor is None:
            self._anchor = (now, simulated)
        wall, start = self._anchor
        delay = wall + (simulated - start) / factor - now
        self.lag = max(0.0, -delay)
        if delay < -LATE_LIMIT:
            self.slips += 1
            self._anchor = (now, simulated)
        return delay

    def sent(self, now: float, simulated: float) -> None:
        """Counts the spoke of this simulated time as sent."""
        self._sent.append((now, simulated))
        while len(self._sent) > 2 and now - self._sent[1][0] >= WINDOW:
            self._sent.popleft()

    def reached(self, now: float) -> float | None:
        """Returns simulated seconds per second over the last WINDOW; None before there is enough to measure.

        While nothing is sent the value falls towards 0.
        """
        if len(self._sent) < 2 or now - self._sent[0][0] < MIN_WINDOW:
            return None
        return (self._sent[-1][1] - self._sent[0][1]) / (now - self._sent[0][0])


@dataclass(frozen=True)
class RunControl:
    """What the transmitter must do now.

    version: changes with every change; steps: spokes still to send while paused; until: while paused without steps, the time
    up to which other radars of the group have sent [s].
    """

    version: int
    settings: Settings
    steps: int
    until: float = math.inf

    def spokes(self, times: Floats, most: int) -> int:
        """Returns how many of the spokes at these times (K,) [s] to send together: 1 at least, `most` at most."""
        within = int(np.searchsorted(times, self.until, side="right"))
        return max(1, min(most, self.steps or most, within))


class GroupClock:
    """What the pacers of a group share. `changed` guards it and them.

    may_command: a condition of the same lock, for what the command worker waits for.
    schedule: of simulated time on the wall clock; version: changes with every change; front: newest time sent [s];
    generation: counts the restarts.
    """

    def __init__(self) -> None:
        lock = threading.RLock()
        self.changed, self.may_command = threading.Condition(lock), threading.Condition(lock)
        self.schedule = Schedule()
        self.version = self.generation = 0
        self.front = -math.inf
        self._members: list[Pacer] = []

    @property
    def held(self) -> bool:
        """Whether a radar holds all of them."""
        return any(member.holds for member in self._members if member.is_active)

    def join(self, member: "Pacer") -> None:
        """Adds a radar."""
        with self.changed:
            self._members.append(member)

    def leave(self, member: "Pacer") -> None:
        """Removes a radar: the others wait for it no longer."""
        with self.changed:
            self._members.remove(member)
            self.notify()

    def set_pace(self, pace: Pace) -> None:
        """Lets all radars take over a pace; with `changed` held."""
        self.schedule.restart()
        for member in self._members:
            member.adopt(pace)

    def may_begin(self, time: float, member: "Pacer") -> bool:
        """Whether a radar may begin a spoke of this time [s]; with `changed` held."""
        others = (other.next for other in self._members if other is not member and other.is_active)
        return time <= min(others, default=math.inf) + MAX_LEAD

    def sent(self, now: float, time: float) -> None:
        """Counts a spoke of this time [s] as sent at `now` [s]; with `changed` held."""
        self.schedule.sent(now, time)
        self.front = max(self.front, time)
        if len(self._members) > 1:
            self.changed.notify_all()

    def restart(self) -> None:
        """Ends the time of the running scene: until a radar begins the next one nothing that it sends is due or counts."""
        with self.changed:
            self.generation += 1
            self.front = -math.inf
            self.schedule.restart()
            for member in self._members:
                member.next = 0.0
            self.notify()

    def let_command(self) -> None:
        """Lets the command worker see whether it may carry out commands now."""
        with self.changed:
            self.may_command.notify_all()

    def notify(self) -> None:
        """Ends the present waits, because something has changed; with `changed` held."""
        self.version += 1
        self.changed.notify_all()


class Pacer:
    """Settings and steps of one transmitter on the clock of its group. Changes come from any thread; its own thread waits.

    The clock's `changed` guards everything here. `settings` is immutable and replaced whole, so it may be read without it.
    holds: whether nothing is due, whatever the settings say, until `release`; next: the time that its next spoke has at
    least [s]; is_active: whether the clock counts it.
    waiting: whether its thread waits until spokes are due.
    """

    def __init__(
        self, settings: Settings, clock: Callable[[], float], group_clock: GroupClock | None = None, held: bool = False
    ) -> None:
        self.settings, self.holds = settings, held
        self.group_clock = group_clock or GroupClock()
        self.stopping = self.waiting = False
        self.next, self.is_active = 0.0, True
        self._generation = self.group_clock.generation
        self._steps = 0
        self._clock = clock
        self._changed = self.group_clock.changed
        self.group_clock.join(self)

    @property
    def held(self) -> bool:
        """Whether this radar, or another one of its group, holds all of them."""
        return self.group_clock.held

    @property
    def idle(self) -> bool:
        """Whether the radar is held, or paused without spokes to send."""
        paused = self.settings.pace.state == "pause" and not self._steps and self.next > self.group_clock.front
        return self.held or paused

    @property
    def speed(self) -> float:
        """Simulated seconds per second: as set, or at pace `max` as reached."""
        factor = self.settings.pace.factor
        return factor if math.isfinite(factor) else self.reached() or 1.0

    @property
    def is_outdated(self) -> bool:
        """Whether the group runs another scene, which this radar has not begun."""
        return self._generation != self.group_clock.generation

    def set(self, settings: Settings) -> None:
        """Replaces the settings; the pace is that of all radars of the group."""
        with self._changed:
            if settings.pace != self.settings.pace:
                self.group_clock.set_pace(settings.pace)
            self.settings = settings
            self.group_clock.notify()

    def adopt(self, pace: Pace) -> None:
        """Takes over the pace of the group, and forgets steps."""
        self.settings, self._steps = replace(self.settings, pace=pace), 0

    def step(self, spokes: int) -> None:
        """Lets so many more spokes become due, and pauses then."""
        with self._changed:
            self.group_clock.set_pace(replace(self.settings.pace, state="pause"))
            self._steps = spokes
            self.group_clock.notify()

    def release(self) -> None:
        """Lets spokes become due."""
        with self._changed:
            self.holds = False
            self.group_clock.notify()

    def interrupt(self) -> None:
        """Ends the present wait, because something else has changed."""
        with self._changed:
            self.group_clock.notify()

    def stop(self) -> None:
        """Ends every wait, now and later."""
        with self._changed:
            self.stopping = True
            self.group_clock.notify()

    def fail(self) -> None:
        """Leaves the group's clock, until `begin`: the other radars do not wait for this one."""
        with self._changed:
            self.is_active = False
            self.group_clock.notify()

    def begin(self, time: float = 0.0) -> None:
        """Begins a scene, or goes on with it, at a time [s of simulation]: its first spoke is due at once."""
        with self._changed:
            if not self.is_outdated and time == 0.0:
                self.group_clock.front = -math.inf
            self._generation, self.is_active, self.next = self.group_clock.generation, True, time
            self.group_clock.schedule.restart()

    def restart_schedule(self) -> None:
        """Makes the next spoke due at once."""
        with self._changed:
            self.group_clock.schedule.restart()

    def run_control(self) -> RunControl:
        """Returns what the transmitter must do now."""
        with self._changed:
            follows = self.settings.pace.state == "pause" and not self._steps
            return RunControl(
                self.group_clock.version, self.settings, self._steps, self.group_clock.front if follows else math.inf
            )

    def wait_until_due(self, times: Floats, run_control: RunControl, claim: Callable[[], bool] = lambda: True) -> bool:
        """Waits until the spokes at these times (K,) [s] are due; returns False as soon as this has changed.

        claim: is asked last, with the lock held, and says whether they may be sent.
        """
        first, last = float(times[0]), float(times[-1])
        with self._changed:
            if not self.is_outdated and first != self.next:
                self.next = first
                self._changed.notify_all()
            try:
                while run_control.version == self.group_clock.version and not self.stopping and not self.is_outdated:
                    steps = not self.held and self._steps > 0
                    delay = 0.0 if steps else self.delay(first, last)
                    if delay <= 0:
                        may_go = claim()
                        self._steps -= (
                            len(times) if steps and may_go else 0
                        )  # a client that has them may request more at once
                        return may_go
                    self._wait(min(delay, MAX_WAIT))
            finally:
                self.waiting = False
        return False

    def _wait(self, timeout: float) -> None:
        """Waits for a change, at most `timeout` [s]; meanwhile commands stop nothing."""
        if not self.waiting:
            self.waiting = True
            self.group_clock.may_command.notify_all()
        self._changed.wait(timeout)

    def delay(self, first: float, last: float) -> float:
        """Returns the seconds until spokes from `first` to `last` [s of simulation] are due; with `changed` held."""
        pace = self.settings.pace
        if not self.held and pace.state == "pause" and last <= self.group_clock.front:
            return 0.0
        if self.held or pace.state == "pause" or not self.group_clock.may_begin(first, self):
            return math.inf
        return self.group_clock.schedule.delay(self._clock(), last, pace.factor)

    def wait_for(self, condition: Callable[[], bool]) -> None:
        """Waits until `condition` holds or the radar stops."""
        with self._changed:
            self._changed.wait_for(lambda: condition() or self.stopping)

    def sent(self, time: float) -> None:
        """Counts the spoke of this simulated time [s] as sent."""
        with self._changed:
            if not self.is_outdated:
                self.next = math.nextafter(time, math.inf)
                self.group_clock.sent(self._clock(), time)

    def reached(self) -> float | None:
        """Returns simulated seconds per second, measured; None before there is enough to measure."""
        with self._changed:
            return self.group_clock.schedule.reached(self._clock())

"""The clock that all radars of a group share: pace, pause, steps and the schedule act on all of them together.

- Pause: radars that are behind follow up to the newest time that any of them has sent, so that all stop at one time.
- Steps count the spokes of the radar that was asked; the others follow in the same way.
- Run: no radar begins a spoke more than MAX_LEAD of simulated time before the next spoke of another one, at any pace.
- Another scene: `restart` ends the time of the running one; each radar begins the new one when it takes over.
"""

import math
import threading
from typing import Protocol

from radar_service.service.radio.pacing import Schedule
from radar_service.service.settings import Pace

MAX_LEAD = 0.25  # s of simulated time: some batches, so that radars need not wait for each other at each spoke


class ClockMember(Protocol):
    """A radar as its group's clock has it: a `Pacer`. `next`: the time that its next spoke has at least [s]."""

    next: float
    holds: bool
    is_active: bool

    def adopt(self, pace: Pace) -> None:
        """Takes over the pace, and forgets its steps."""


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
        self._members: list[ClockMember] = []

    @property
    def held(self) -> bool:
        """Whether a radar holds all of them."""
        return any(member.holds for member in self._members if member.is_active)

    def join(self, member: ClockMember) -> None:
        """Adds a radar."""
        with self.changed:
            self._members.append(member)

    def leave(self, member: ClockMember) -> None:
        """Removes a radar: the others wait for it no longer."""
        with self.changed:
            self._members.remove(member)
            self.notify()

    def set_pace(self, pace: Pace) -> None:
        """Lets all radars take over a pace; with `changed` held."""
        self.schedule.restart()
        for member in self._members:
            member.adopt(pace)

    def may_begin(self, time: float, member: ClockMember) -> bool:
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

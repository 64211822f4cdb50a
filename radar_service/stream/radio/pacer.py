"""The orders to a transmitter, and the wait until spokes are due."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

from radar_service.records import SpokeBlock
from radar_service.stream.radio.pacing import Schedule
from radar_service.stream.settings import Settings

MAX_WAIT = 3600.0  # s before the schedule is read again: a pace of 1e-300 is due in more seconds than a thread can wait


@dataclass(frozen=True)
class Orders:
    """The present orders. version: changes with every order; steps: spokes still to send while paused."""

    version: int
    settings: Settings
    steps: int


class Pacer:
    """Settings, steps and schedule of one transmitter. Orders come from any thread; the transmitter's thread waits.

    `_changed` guards everything here. `settings` is immutable and replaced whole, so it may be read without the lock.
    held: whether nothing is due, whatever the settings say, until `release`.
    """

    def __init__(
        self, settings: Settings, clock: Callable[[], float], schedule: Schedule | None = None, held: bool = False
    ) -> None:
        self.settings, self.held = settings, held
        self.schedule = schedule or Schedule()
        self.stopping = False
        self._steps = 0
        self._version = 0
        self._clock = clock
        self._changed = threading.Condition()

    @property
    def idle(self) -> bool:
        """Whether the radar is held, or paused without steps to make."""
        return self.held or (self.settings.pace.state == "pause" and not self._steps)

    def set(self, settings: Settings) -> None:
        """Replaces the settings."""
        with self._changed:
            if settings.pace != self.settings.pace:
                self._steps = 0
                self.schedule.restart()
            self.settings = settings
            self._notify()

    def step(self, spokes: int) -> None:
        """Orders that many spokes more, and then a pause."""
        with self._changed:
            self.settings = replace(self.settings, pace=replace(self.settings.pace, state="pause"))
            self.schedule.restart()
            self._steps = spokes
            self._notify()

    def release(self) -> None:
        """Lets spokes become due."""
        with self._changed:
            self.held = False
            self._notify()

    def interrupt(self) -> None:
        """Ends the present wait, because something else has changed."""
        with self._changed:
            self._notify()

    def stop(self) -> None:
        """Ends every wait, now and later."""
        with self._changed:
            self.stopping = True
            self._notify()

    def restart_schedule(self) -> None:
        """Makes the next spoke due at once."""
        with self._changed:
            self.schedule.restart()

    def orders(self) -> Orders:
        """Returns the orders as they are now."""
        with self._changed:
            return Orders(self._version, self.settings, self._steps)

    def is_due(self, part: SpokeBlock, orders: Orders) -> bool:
        """Returns whether these spokes are due now."""
        with self._changed:
            if self.held or (orders.settings.pace.state == "pause" and not self._steps):
                return False
            return self._steps > 0 or self.schedule.is_due(self._clock(), float(part.time[-1]), orders.settings.pace.factor)

    def wait_until_due(self, part: SpokeBlock, orders: Orders) -> bool:
        """Waits until these spokes are due; returns False as soon as the orders have changed."""
        with self._changed:
            while orders.version == self._version and not self.stopping:
                if self.held:
                    self._changed.wait()
                    continue
                if self._steps:
                    self._steps -= len(part)  # before they are sent: a client that has received them may order more at once
                    return True
                if orders.settings.pace.state == "pause":
                    self._changed.wait()
                    continue
                delay = self.schedule.delay(self._clock(), float(part.time[-1]), orders.settings.pace.factor)
                if delay <= 0:
                    return True
                self._changed.wait(min(delay, MAX_WAIT))
        return False

    def wait_for(self, condition: Callable[[], bool]) -> None:
        """Waits until `condition` holds or the radar stops."""
        with self._changed:
            self._changed.wait_for(lambda: condition() or self.stopping)

    def sent(self, time: float) -> None:
        """Counts the spoke of this simulated time [s] as sent."""
        with self._changed:
            self.schedule.sent(self._clock(), time)

    def reached(self) -> float | None:
        """Returns simulated seconds per second, measured; None before there is enough to measure."""
        with self._changed:
            return self.schedule.reached(self._clock())

    def _notify(self) -> None:
        self._version += 1
        self._changed.notify_all()

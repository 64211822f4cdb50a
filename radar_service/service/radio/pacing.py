"""How fast simulated time runs against the wall clock: arithmetic only, without threads and without waiting."""

import math
from collections import deque

BATCH_SECONDS = 0.015  # of wall-clock time per message: eight to ten times the capacity of single spokes, and not visible
BATCH_SPOKES = 32  # at any speed: beyond it a message gains little (docs/accuracy.md#fan-out)
LATE_LIMIT = 0.25  # s behind after which the schedule starts anew: catching up would be a burst
WINDOW = 5.0  # s over which the achieved factor is measured
MIN_WINDOW = 0.5  # s; over less a single batch weighs too much
KEEPING_UP = 0.97  # of the requested factor: what start-up and rounding may cost before it counts as falling behind


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

"""How fast simulated time runs against the wall clock. Arithmetic only: whoever owns the thread does the waiting."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Any, Literal

BATCH_SECONDS = 0.015  # of wall-clock time per message: eight to ten times the capacity of single spokes, unseen by the eye
BATCH_SPOKES = 32  # however fast it goes: beyond it a message gains little (reference/streaming.md, section 2)
LATE_LIMIT = 0.25  # s behind after which the schedule starts afresh: catching up would be a burst
WINDOW = 5.0  # s over which the factor reached is measured
WINDOW_LEAST = 0.5  # s; over less a single batch weighs too much
KEEPING_UP = 0.97  # of the factor asked for: what start-up and rounding may cost before it counts as falling behind


@dataclass(frozen=True)
class Pace:
    """run or pause, and simulated seconds per second; factor inf is as fast as possible."""

    state: Literal["run", "pause"] = "run"
    factor: float = 1.0

    def __post_init__(self) -> None:
        if not self.factor > 0:
            raise ValueError(f'pace.factor: {self.factor:g} is not above 0; give a number, or "max"')

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as REST and the feed say it."""
        return {"state": self.state, "factor": "max" if math.isinf(self.factor) else self.factor}


def batch_spokes(factor: float, spoke_period: float) -> int:
    """How many spokes make a message: BATCH_SECONDS of them at this pace, at least one."""
    if math.isinf(factor):
        return BATCH_SPOKES
    return max(1, round(min(BATCH_SPOKES, BATCH_SECONDS * factor / spoke_period)))


class Schedule:
    """When a simulated time is due on the wall clock, and what factor has really been reached. Times in s."""

    def __init__(self) -> None:
        self.slips = 0  # times the schedule had to start afresh because the engine was late
        self.lag = 0.0  # how late what was last asked about is, s
        self._anchor: tuple[float, float] | None = None  # wall, simulated
        self._seen: deque[tuple[float, float]] = deque()

    def restart(self) -> None:
        """Forget the anchor: the next spoke is due when it is asked for (after a pause, a change of pace, a new scene)."""
        self._anchor = None
        self._seen.clear()

    def delay(self, now: float, simulated: float, factor: float) -> float:
        """Seconds until this simulated time is due; 0 or less: now. Too late by LATE_LIMIT and the schedule slips."""
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
        """Note that the spoke of this simulated time went out."""
        self._seen.append((now, simulated))
        while len(self._seen) > 2 and now - self._seen[1][0] >= WINDOW:
            self._seen.popleft()

    def reached(self, now: float) -> float | None:
        """Simulated seconds per second over the last WINDOW; None before there is enough to measure.

        With nothing more being sent it sinks towards 0, as it should.
        """
        if len(self._seen) < 2 or now - self._seen[0][0] < WINDOW_LEAST:
            return None
        return (self._seen[-1][1] - self._seen[0][1]) / (now - self._seen[0][0])

"""When a radar takes the next commands, so that many of them do not stop its feed.

After commands the spoke source computes anew. A radar that is late first sends spokes; one whose spokes wait until they are
due takes the next commands at once. Where commands take so long that the schedule starts anew, spokes wait although they are
late: then the radar sends for as long as the commands took.
"""

import math
from collections.abc import Callable

from radar_service.service.radio.pacing import LATE_LIMIT

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

"""The helm: which sender steers by sentences, and its orders. The first sender holds it until that is silent."""

import math
from collections.abc import Hashable
from typing import NamedTuple

from radar_service.ports.nmea_in.sentence_reader import Reading, SentenceIgnoredError

SILENCE = 3.0  # s after which another sender may steer, and clocks may have been set back
DAY = 86_400.0  # s


class HelmOrder(NamedTuple):
    """motion: heading, course and speed of all sentences so far, by the keys of a command; position: of the newest one alone,
    latitude and longitude [degrees, WGS 84], or None."""

    motion: dict[str, float]
    position: tuple[float, float] | None


class Helm:
    """holder: the sender that steers, or was the last one to do so."""

    def __init__(self) -> None:
        self.holder: Hashable = None
        self._heard = -math.inf  # when the holder was followed
        self._motion: dict[str, float] = {}
        self._clock = (0.0, -math.inf)  # of the newest sentence with a time, and when it came

    def hear(self, sender: Hashable, reading: Reading, now: float) -> HelmOrder:
        """Returns what a sentence orders that arrives now [s]. Raises SentenceIgnoredError: holder, past."""
        if now - self._heard >= SILENCE:
            self.holder, self._motion, self._clock = sender, {}, (0.0, -math.inf)
        elif sender != self.holder:
            raise SentenceIgnoredError("holder")
        if reading.clock is not None:
            self._follow_clock(reading.clock, now)
        self._heard = now
        self._motion = self._motion | reading.motion
        return HelmOrder(self._motion, reading.position)

    def _follow_clock(self, clock: float, now: float) -> None:
        """Notes the time of a sentence; one that is up to half a day earlier than another one shortly before is of the past."""
        before, came = self._clock
        if now - came < SILENCE and 0.0 < (before - clock) % DAY < DAY / 2:
            raise SentenceIgnoredError("past")
        self._clock = clock, now

"""Applies errors on purpose to the spokes of one radar, and says in the truth what was done.

A timeline says which errors are in force at which spoke, where they change while the radar runs.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import groupby
from typing import Any

import numpy as np

from radar_service.errors.feed import FeedArranger, FeedLaw
from radar_service.errors.sensors import Earlier, SensorLaws
from radar_service.numerics import name_key, wrap_angle, wrap_bearing
from radar_service.radar import Radar
from radar_service.records import FeedErrorCounts, OwnShipTruth, ReportedOwnShip, SpokeBlock
from radar_service.world import NO_STREAM, ErrorSettings, Stream

MAX_CHANGES = 1000  # that are remembered: the errors of older spokes count as those of the oldest change
NONE: Any = np.array(None)
ONLY_RADAR = "0"  # id of a radar that is alone, whose random numbers need no key


class ErrorTimeline:
    """Errors from each of some spokes on. May be read from any thread: the entries are immutable and replaced whole."""

    def __init__(self, errors: ErrorSettings | None = None) -> None:
        self._entries: tuple[tuple[int, ErrorSettings | None], ...] = ((0, errors),)

    @property
    def errors(self) -> ErrorSettings | None:
        """The errors of the spokes to come."""
        return self._entries[-1][1]

    @property
    def has_errors(self) -> bool:
        """Whether there are errors at some spoke."""
        return any(errors is not None for _, errors in self._entries)

    def set(self, errors: ErrorSettings | None, number: int) -> None:
        """Puts errors into force from the spoke of this number on, in place of all that was to be from there on."""
        kept = tuple(entry for entry in self._entries if entry[0] < number)
        if errors != (kept[-1][1] if kept else None) or not kept:
            kept = (*kept, (number if kept else 0, errors))
        self._entries = kept[-MAX_CHANGES:]

    def at(self, number: int) -> ErrorSettings | None:
        """Returns the errors in force at a spoke."""
        return self._entries[max(0, bisect_right(self._entries, number, key=lambda entry: entry[0]) - 1)][1]

    def since(self, number: int, part: Callable[[ErrorSettings | None], object]) -> int:
        """Returns the number of the spoke since which a part of the errors has been as it is at the spoke `number`."""
        begin = 0
        for first, errors in reversed(self._entries):
            if first <= number:
                if part(errors) != part(self.at(number)):
                    break
                begin = first
        return begin

    def changes(self, first: int, end: int) -> list[int]:
        """Returns the numbers above `first` and below `end` at which errors change."""
        return [number for number, _ in self._entries if first < number < end]


class ErrorReporter(ErrorTimeline):
    """The errors of one radar's run, which `set` changes from one of its spokes on.

    radar_id: of the radar, whose antenna and feed have random numbers of their own; first: number of the first spoke of the run;
    ship: name of the body that carries the radar, whose sensors have noise of their own, or None; stream: as of SensorLaws.
    """

    def __init__(
        self, radar: Radar, seed: int, errors: ErrorSettings | None, radar_id: str = ONLY_RADAR, first: int = 0,
        ship: str | None = None, stream: Stream = NO_STREAM,
    ) -> None:  # fmt: skip
        super().__init__(errors)
        self._radar, self._seed, self._first = radar, seed, first
        self._same_run = partial(ErrorReporter, radar, seed, radar_id=radar_id, ship=ship, stream=stream)
        self._key = key = 0 if radar_id == ONLY_RADAR else name_key(radar_id)
        self._arranger = FeedArranger(radar)
        self._sensor_laws = lru_cache(4)(lambda settings: SensorLaws(settings, radar, seed, key, ship, stream))

    def restarted(self, first: int) -> "ErrorReporter":
        """Returns a reporter with the errors now in force, for a run that begins with spoke `first`."""
        return self._same_run(errors=self.errors, first=first)

    def reported(self, block: SpokeBlock, earlier: Earlier) -> SpokeBlock:
        """Returns a true block as sensors and antenna report it. earlier: gives true readings of earlier spokes."""
        errors = self.at(block.first)
        if errors is None:
            return block
        number = block.first + np.arange(len(block))
        reported = self._sensor_laws(errors).reported(number, block.time, block.readings, earlier)
        return replace(block, **reported._asdict(), true=block.readings)

    def laws_at(self, number: int) -> SensorLaws | None:
        """Returns the laws of the sensors at a spoke; None where no errors are in force."""
        errors = self.at(number)
        return None if errors is None else self._sensor_laws(errors)

    def sent(self, block: SpokeBlock) -> list[SpokeBlock]:
        """Returns what the feed sends when the spokes of a block are due: blocks of consecutive spokes, in order."""
        return self._arranger.arranged(block, self._feed_law(block.first))

    def own_ships(
        self, own: Sequence[OwnShipTruth], spokes: Sequence[int], earlier: Earlier
    ) -> list[ReportedOwnShip | None]:  # fmt: skip
        """Returns own ship (K,) with the errors of spokes (K,); None where none are in force."""
        result: list[ReportedOwnShip | None] = []
        for errors, group in groupby(zip(own, spokes, strict=True), lambda each: self.at(each[1])):
            some, numbers = zip(*group, strict=True)
            if errors is None:
                result += [None] * len(some)
                continue
            true = earlier(number := np.array(numbers))
            there = self._sensor_laws(errors).reported(number, self._radar.schedule(number)[1], true, earlier)
            offset, lost = np.pad(there.position - true.position, ((0, 0), (0, 1))), np.isnan(there.heading)
            turned = wrap_bearing([each.heading for each in some] + wrap_angle(there.heading - true.heading))
            course_turned = wrap_bearing([each.course for each in some] + wrap_angle(there.course - true.course))
            heading, course = (np.where(lost, NONE, angles) for angles in (turned, course_turned))
            error = wrap_angle(there.azimuth - (true.azimuth - np.where(lost, true.heading, 0.0)))
            position = ([each.position for each in some] + offset).tolist()
            speed = [each.speed for each in some] + (there.speed - true.speed)
            columns = map(tuple, position), heading.tolist(), course.tolist(), speed.tolist(), error.tolist()
            names = "position", "heading", "course", "speed", "azimuth_error"
            result += [ReportedOwnShip(**dict(zip(names, row, strict=True))) for row in zip(*columns, strict=True)]
        return result

    def counts(self, scan: int) -> FeedErrorCounts | None:
        """Returns what happens to the spokes of a scan; None where no errors of the feed are in force."""
        first, end = scan * self._radar.azimuths, (scan + 1) * self._radar.azimuths
        total: FeedErrorCounts | None = None
        edges = [first, *self.changes(first, end), end]
        for start, stop in zip(edges, edges[1:], strict=False):
            law = self._feed_law(start)
            if law:
                total = law.counts(start, stop - start, self._stuck_from(start)).plus(total)
        return total

    def last_spoke(self, scan: int) -> int:
        """Number of the last spoke of a scan."""
        return (scan + 1) * self._radar.azimuths - 1

    def _feed_law(self, number: int) -> FeedLaw | None:
        errors = self.at(number)
        if errors is None or errors.feed is None:
            return None
        return FeedLaw(errors.feed, self._radar, self._seed, self._key)

    def _stuck_from(self, number: int) -> int:
        """Number of the first spoke from which on the stuck sector that is in force at a spoke has not changed."""
        since = self.since(number, lambda errors: errors and errors.feed and errors.feed.stuck_sector)
        return max(self._first, since)

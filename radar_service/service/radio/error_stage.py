"""Errors on purpose between the spoke source and the clients: a sink that passes on what the radar reports, as the feed sends it.

The spoke sources of the service compute true spokes. Errors change here, so a change acts from the first spoke not yet sent.
"""

import json
import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import override

from radar_service.numerics import Indices, Singles
from radar_service.records import OwnShipTruth, Readings, SpokeBlock
from radar_service.scene_file import MAX_LATENCY_S
from radar_service.service.spokes import RadarInfo, SinkGroup, SpokeBatch, SpokeSink
from radar_service.spoke_source import SpokeSource, SpokeSourceInfo, TruthLine
from radar_service.world import ErrorSettings

NEVER = -1


class ReadingsHistory:
    """Keeps the readings of the newest `size` spokes. Spokes are added in the order of their numbers."""

    def __init__(self, size: int) -> None:
        self._number = np.full(size, NEVER, dtype=np.int64)
        self._table = np.empty((size, 6))

    def add(self, first: int, readings: Readings) -> None:
        """Keeps the readings of consecutive spokes."""
        number = first + np.arange(len(readings.azimuth))
        rows = number % len(self._number)
        azimuth, heading, position, course, speed = readings
        self._number[rows] = number
        self._table[rows] = np.column_stack([azimuth, heading, position, course, speed])

    def readings(self, number: Indices) -> Readings:
        """Returns the readings of spokes of these numbers (K,); for one that is not kept, of the newest kept before it, or else
        of the oldest kept. At least one is kept."""
        rows = number % len(self._number)
        if not np.array_equal(self._number[rows], number):
            order = np.argsort(self._number, kind="stable")
            kept = order[np.count_nonzero(self._number == NEVER) :]
            rows = kept[np.maximum(np.searchsorted(self._number[kept], number, side="right") - 1, 0)]
        table = self._table[rows]
        return Readings(table[:, 0], table[:, 1], table[:, 2:4], table[:, 4], table[:, 5])


if TYPE_CHECKING:
    from radar_service.errors.reporter import ErrorReporter
    from radar_service.errors.sensors import SensorLaws

MAX_RUNS = 4  # spoke sources about whose spokes the truth may still ask
SCANS_KEPT = 2  # of true readings, besides the longest latency: the truth of a scan comes when it has been sent
MAX_KEPT = 2**18  # spokes: 15 MB


class ErrorStage(SinkGroup):
    """A sink of true spokes. The sinks of the feed receive from it what is reported and sent, under numbers of its own.

    `_lock` guards the reports; `set_errors` and `completed` may be called from any thread. `errors`, of the spokes to come, is
    immutable and replaced whole, so it may be read without the lock.
    """

    def __init__(self, spoke_source: SpokeSource, sinks: Sequence[SpokeSink]) -> None:
        super().__init__(sinks)
        self._lock = threading.Lock()
        self._reports: dict[SpokeSource, _Reports] = {}  # the last one is of the source that runs
        self._running = self._reports_of(spoke_source)
        self._number = 0  # of the next spoke in this epoch, as clients count
        self.errors = self._running.errors

    def set_errors(self, tables: Mapping[str, Any] | None) -> None:
        """Changes the errors of the spokes not yet sent, as Simulator.set_errors. Raises SceneError."""
        from radar_service.scene_file import (
            changed_errors,  # here and below: scipy would slow the start of every service
        )

        with self._lock:
            self.errors = changed_errors(self.errors, tables, self._running.has_sensors)
            self._running.set(self.errors)

    @override
    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch. Another source begins with the errors of its scene, or goes on with the errors in force."""
        with self._lock:
            is_new, self._number = radar.epoch.spoke_source not in self._reports, 0
            self._running = self._reports_of(radar.epoch.spoke_source)
            if is_new and radar.epoch.goes_on:
                self._running.set(self.errors)
            self.errors = self._running.errors
        super().open_epoch(radar)

    @override
    def send(self, batch: SpokeBatch) -> None:
        """Passes on what is sent when these spokes are due."""
        with self._lock:
            if batch.epoch.spoke_source not in self._reports:  # it continues the run of one that has failed
                self._keep(batch.epoch.spoke_source, self._running)
            sent, errors = self._running.sent(batch.block), self.errors
        for block in sent:
            same = block is batch.block and batch.first == self._number and errors is None
            before = batch.before if block.first == batch.block.first else _power_before(block, batch.block)
            passed = batch if same else replace(batch, first=self._number, block=block, before=before, errors=errors)
            self._number += len(block)  # also where a sink fails: the number is used, and the feed announces its loss
            super().send(passed)

    @override
    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Passes on the notice, under the numbers that clients count."""
        first, self._number = self._number, self._number + count
        super().skip(epoch, first, count, reason)

    def laws_at(self, number: int) -> "SensorLaws | None":
        """Returns the laws of own ship's sensors at a spoke; None where no errors are in force."""
        with self._lock:
            return self._running.laws_at(number)

    def completed(self, spoke_source: SpokeSource, line: TruthLine) -> str:
        """Returns a line of the truth of spokes that were sent, with what was reported and what happened to the spokes."""
        with self._lock:
            reports = self._reports.get(spoke_source)
            return reports.completed(line) if reports else line.text

    def _reports_of(self, spoke_source: SpokeSource) -> "_Reports":
        if spoke_source not in self._reports:
            self._keep(spoke_source, _Reports(spoke_source.info))
        return self._reports[spoke_source]

    def _keep(self, spoke_source: SpokeSource, reports: "_Reports") -> None:
        self._reports[spoke_source] = reports
        while len(self._reports) > MAX_RUNS:
            del self._reports[next(iter(self._reports))]


class _Reports:
    """What is reported in one run of a scene. `next` is the number of the first spoke not yet sent, from t = 0."""

    def __init__(self, of: SpokeSourceInfo) -> None:
        scene = of.scene
        self._radar, self._seed, self._radar_id = scene.radar, of.seed, scene.radar_id
        self._ship, self._stream, self.has_sensors = scene.steerable.own_ship, scene.stream, scene.has_sensors
        kept = math.ceil(MAX_LATENCY_S / self._radar.spoke_period) + SCANS_KEPT * self._radar.azimuths
        self._history = ReadingsHistory(min(kept, MAX_KEPT))
        self._next = 0
        self._reporter: ErrorReporter | None = None  # until there are errors
        self.set(scene.errors)

    @property
    def errors(self) -> ErrorSettings | None:
        return None if self._reporter is None else self._reporter.errors

    def set(self, errors: ErrorSettings | None) -> None:
        if self._reporter is None and errors is not None:
            from radar_service.errors.reporter import ErrorReporter

            self._reporter = ErrorReporter(
                self._radar, self._seed, None, self._radar_id, ship=self._ship, stream=self._stream
            )
        if self._reporter is not None:
            self._reporter.set(errors, self._next)

    def laws_at(self, number: int) -> "SensorLaws | None":
        return None if self._reporter is None else self._reporter.laws_at(number)

    def sent(self, block: SpokeBlock) -> list[SpokeBlock]:
        """What is sent when these spokes are due."""
        self._next = block.first + len(block)
        self._history.add(block.first, block.readings)
        if self._reporter is None:
            return [block]
        return self._reporter.sent(self._reporter.reported(block, self._history.readings))

    def completed(self, line: TruthLine) -> str:
        if self._reporter is None or not self._reporter.has_errors:
            return line.text
        content = json.loads(line.text)
        if content["type"] == "header":
            return line.text
        scan = content["scan"]
        last = self._reporter.last_spoke(scan)
        own = OwnShipTruth(**content["own_ship"])
        (reported,) = self._reporter.own_ships([own], [min(content.get("spoke", last), last)], self._history.readings)
        content["own_ship"]["reported"] = reported and asdict(reported)
        counts = self._reporter.counts(scan) if content["type"] == "snapshot" else None
        return json.dumps(content | ({"feed_errors": asdict(counts)} if counts else {}), allow_nan=False)


def _power_before(block: SpokeBlock, sent: SpokeBlock) -> Singles | None:
    """The power of the spoke before a part of a block; None where that is not in the block."""
    at = block.first - sent.first - 1
    return sent.power[at] if 0 <= at < len(sent) else None

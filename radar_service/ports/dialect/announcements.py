"""What a radar of another maker sends: what it is found by, reports and spokes, each from the port of its destination.

Of spokes no peak is lost. An echo moves by half of our spoke at most, rounded to one of theirs, and by half of their sample or,
where that is the longer one, of our cell.
"""

import math
import threading
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from radar_service.display.video import Bytes
from radar_service.numerics import Floats
from radar_service.ports.dialect.dialect import SPINNING_UP, TRANSMIT, Dialect, SampleForm, Setting, Spoke
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.capture import Capture, CaptureSender
from radar_service.ports.udp.sender import UdpSender
from radar_service.ports.udp.udp_port import Sender
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, SpokeSink
from radar_service.world import true_bearing

REPORTS, FOUND_BY = 0.5, 1.0  # s between two of each


class Samples:
    """How the cells of an epoch become samples that end at the range shown, in whole metres: a cell counts where its middle is.
    Samples shorter than a cell have the one that their middle is in.

    metres: that range.
    """

    def __init__(self, epoch: Epoch, form: SampleForm) -> None:
        to, range_max = epoch.layout(None), epoch.info.radar.range_max
        self.metres = round(min(epoch.range or range_max, range_max, to.range))
        count = form.most if form.fills else min(form.most, max(1, math.floor(self.metres / to.step + 1e-9)))
        width = self.metres / count
        edges = np.arange(count + 1) * width
        if width < to.step:
            edges += 0.5 * (width - to.step)
        cells = np.ceil((edges - to.first) / to.step - 1e-9).astype(np.intp)
        self._layout, self._levels = to, form.levels
        self._starts = np.clip(cells[:-1], 0, to.bins - 1)
        self._end = max(int(self._starts[-1]) + 1, int(cells[-1]))

    def of(self, batch: SpokeBatch) -> Bytes:
        """Returns the samples of a batch (K, samples), as readers take them."""
        cells = batch.video_bytes(self._layout)[:, : self._end]
        samples: Bytes = self._levels[np.maximum.reduceat(cells, self._starts, axis=1)]
        return samples


class BowSpokes:
    """Joins or repeats spokes, as theirs are. lost: those that are left out, as their number or angle does not rise."""

    def __init__(self, azimuths: int, spokes: int, note_break: Callable[[], None] = lambda: None) -> None:
        """azimuths, spokes: in a revolution of ours and of theirs; note_break: is told that what comes does not follow."""
        self.lost, self._azimuths, self._spokes, self._number = 0, azimuths, spokes, -1
        self._note_break = note_break
        self._width = spokes / azimuths  # of a spoke of the radar
        self._half = 0.5 * max(self._width, 1.0)
        self._restart()

    def _restart(self) -> None:
        self._note_break()
        self._angle = math.nan  # of the last spoke, in spokes of theirs, counted on from turn to turn
        self._next, self._open = 0, dict[int, Bytes]()  # the next one to be ended, and what is known of those from it on
        self._last: Bytes | None = None

    def ended(self, batch: SpokeBatch, rows: Bytes, metres: int, headings: Floats) -> list[Spoke]:
        """Returns the spokes that are complete with a batch. rows: its samples; metres: where these end; headings: true."""
        if batch.block.first <= self._number:
            self.lost += len(rows)
            return []
        if batch.block.first - self._number > self._azimuths // 2:  # after standby: which way round is not known
            self._restart()
        self._number = batch.block.first + len(rows) - 1
        bow = np.where(np.isnan(batch.block.heading), 0.0, batch.block.heading)  # lost: the azimuth counts from the bow
        angles = np.mod((batch.block.azimuth - bow) * (self._spokes / (2.0 * math.pi)), self._spokes)
        return [
            Spoke(number, metres, heading, samples)
            for angle, row, heading in zip(angles.tolist(), rows, headings.tolist(), strict=True)
            for number, samples in self._taken(angle, row)
        ]

    def _taken(self, angle: float, row: Bytes) -> list[tuple[int, Bytes]]:
        step = 0.0
        if not math.isnan(self._angle):
            step = math.remainder(angle - self._angle, self._spokes)
            if step <= 0.0:
                self.lost += 1
                return []
            angle = self._angle + step
        low, high = math.ceil(angle - self._half), math.ceil(angle + self._half)
        result = self._ended_before(low, step <= 2.0 * self._half + 1.0) if step else []
        self._angle, self._next, self._last = angle, low, row
        for number in range(low, high):
            self._open[number] = np.maximum(self._open[number], row) if number in self._open else row
        return result

    def _ended_before(self, low: int, fills: bool) -> list[tuple[int, Bytes]]:
        """Ends the spokes before a number. fills: whether those that nothing fell into repeat the last one: own ship turns."""
        result = list[tuple[int, Bytes]]()
        for number in range(self._next, low) if fills else sorted(self._open):
            row = self._open.pop(number, self._last)
            if row is not None:
                result.append((number % self._spokes, row))
        self._open = {number: row for number, row in self._open.items() if number >= low}
        return result


def true_headings(batch: SpokeBatch) -> Floats:
    """Returns headings (K,) [rad] from true north, or from the map's where a scene has no origin; NaN while they are lost."""
    block, origin = batch.block, batch.epoch.info.scene.origin
    north = true_bearing(0.0, block.position, origin) if origin else 0.0
    headings: Floats = block.heading + north
    return headings


class Senders(NamedTuple):
    """Where each kind of datagram goes."""

    found_by: Sender
    reports: Sender
    spokes: Sender


def senders_of(dialect: Dialect, here: str, capture: Capture | None = None) -> Senders:
    """Returns senders from an address of this machine; each has the port of its destination. Raises UsageError."""
    ways = [(Address(group, port, here), Address(here, port)) for group, port in dialect.destinations]
    return Senders(*(UdpSender(f"--{dialect.name}", to, joined=0, source=own, capture=capture) for to, own in ways))


class Announcements:
    """Reports a setting, by the clock and as it changes. Any thread may change it; `spokes` belongs to one.

    setting: what is reported; nothing is before the controls are known.
    """

    def __init__(self, dialect: Dialect, here: str, senders: Senders, clock: Callable[[], float] = time.monotonic) -> None:
        """here: the radar's address."""
        self.setting, self.dialect, self._here = Setting(), dialect, here
        self._to, self._clock, self._lock = senders, clock, threading.Lock()
        self._reported = self._announced = float("-inf")  # when reports, and what it is found by, were sent last
        self._count = 0

    def report(self, **changes: Any) -> None:
        """Sends all reports, with changes of the setting."""
        with self._lock:
            if changes:
                self.setting = replace(self.setting, **changes)
            if self.setting.controls is not None:
                self._to.reports.send(self.dialect.reports(self.setting))

    def become(self, state: int) -> None:
        """Reports a state of the scanner, which spins up before it transmits."""
        if state != self.setting.state:
            if state == TRANSMIT:
                self.report(state=SPINNING_UP)
            self.report(state=state)

    def spokes(self, datagrams: Sequence[bytes], transmits: bool = True) -> None:
        """Sends spokes, after the reports that it transmits. transmits: whether it still does, once these are sent."""
        if transmits:
            self.become(TRANSMIT)
        self._to.spokes.send(datagrams)

    def what_is_due(self, radar: str, at_once: bool = False, sought: bool = False) -> None:
        """Sends what it is found by, and reports, when they are due. radar: its id, by which readers know it again; at_once: the
        reports are; sought: the first is."""
        now = self._clock()
        if sought or now >= self._announced + FOUND_BY:
            self._announced = now
            identity = zlib.crc32(f"radar-service {radar}".encode())
            self._to.found_by.send([self.dialect.found_by(identity, self._count, self._here)])
            self._count += 1
        if at_once or now >= self._reported + REPORTS:
            self._reported = now
            self.report()


class DialectSink(SpokeSink):
    """The spokes of one radar."""

    def __init__(
        self, to: Announcements, is_sent: Callable[[], bool], transmits: Callable[[], bool], note_lost: Callable[[int], None]
    ) -> None:
        """is_sent: whether this radar is the one that is sent; transmits: whether it is not in standby, where last spokes may
        still come; note_lost: counts spokes that are left out."""
        self._to, self._is_sent, self._transmits, self._note_lost = to, is_sent, transmits, note_lost
        self._samples: Samples | None = None
        self._spokes: BowSpokes | None = None
        self._frames = to.dialect.frames()

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins spokes of another range, which is reported before they come."""
        known, dialect = radar.epoch.info.radar, self._to.dialect
        self._samples = Samples(radar.epoch, dialect.samples)
        self._spokes = BowSpokes(known.azimuths, dialect.spokes, self._frames.clear)
        if self._is_sent():
            self._to.report(range=self._samples.metres, range_max=known.longest_range)

    def send(self, batch: SpokeBatch) -> None:
        """Sends the spokes that are complete."""
        assert self._samples is not None and self._spokes is not None, "open_epoch comes first"
        if self._is_sent():
            lost = self._spokes.lost
            ended = self._spokes.ended(batch, self._samples.of(batch), self._samples.metres, true_headings(batch))
            self._to.spokes(self._frames.of(ended), self._transmits())
            self._note_lost(self._spokes.lost - lost)


class DialectExport(DialectSink):
    """The spokes of a recorded radar, with what it is found by and reports by the time of the capture that they go into."""

    def __init__(self, dialect: Dialect, capture: Capture) -> None:
        senders = Senders(*(CaptureSender(capture, (dialect.radar, to[1]), to) for to in dialect.destinations))
        self._announced, self._radar = Announcements(dialect, dialect.radar, senders, lambda: capture.clock()), ""
        super().__init__(self._announced, lambda: True, lambda: True, lambda count: None)

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch with its controls."""
        self._radar = radar.identity
        super().open_epoch(radar)
        self._announced.report(controls=radar.controls)

    def send(self, batch: SpokeBatch) -> None:
        """Sends what is due, and spokes."""
        self._announced.what_is_due(self._radar)
        super().send(batch)

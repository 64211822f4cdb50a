"""What a radar of another maker sends: what it is found by, reports and spokes, each from the port of its destination."""

import threading
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from radar_service.ports.dialect.dialect import SPINNING_UP, TRANSMIT, Dialect, Setting
from radar_service.ports.dialect.spokes import BowSpokes, Samples, true_headings
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.capture import Capture, CaptureSender
from radar_service.ports.udp.sender import UdpSender
from radar_service.ports.udp.udp_port import Sender
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink

REPORTS, FOUND_BY = 0.5, 1.0  # s between two of each


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

"""What an xHD sends: heartbeats, reports and spokes, each from the port of its destination."""

import threading
import time
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from radar_service.ports.garmin_xhd.datagrams import (
    FINDERS,
    GROUP,
    SPINNING_UP,
    TRANSMIT,
    Setting,
    heartbeat,
    reports,
    spoke,
)
from radar_service.ports.garmin_xhd.spokes import BowSpokes, Samples
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.capture import Capture, CaptureSender
from radar_service.ports.udp.sender import UdpSender
from radar_service.ports.udp.udp_port import Sender
from radar_service.service.spokes import RadarInfo, SpokeBatch

DESTINATIONS = ((FINDERS, 50050), (GROUP, 50100), (GROUP, 50102))  # of heartbeats, reports and spokes
RADAR = "172.16.2.0"  # address of a real one, for captures that nobody has sent
REPORTS, HEARTBEATS = 0.5, 1.0  # s between two of each


class XhdSenders(NamedTuple):
    """Where each kind of datagram goes."""

    heartbeats: Sender
    reports: Sender
    spokes: Sender


def xhd_senders(option: str, here: str, capture: Capture | None = None) -> XhdSenders:
    """Returns senders from an address of this machine; each has the port of its destination. Raises UsageError."""

    def sender(group: str, port: int) -> UdpSender:
        return UdpSender(option, Address(group, port, here), joined=0, source=Address(here, port), capture=capture)

    return XhdSenders(*(sender(*to) for to in DESTINATIONS))


class Announcements:
    """Reports a setting, by the clock and as it changes. Any thread may change it; `spokes` belongs to one.

    setting: what is reported; nothing is before the controls are known.
    """

    def __init__(self, senders: XhdSenders, clock: Callable[[], float] = time.monotonic) -> None:
        self.setting = Setting()
        self._to, self._clock, self._lock = senders, clock, threading.Lock()
        self._reported = self._beaten = float("-inf")  # when reports and heartbeats were sent last
        self._beats = 0

    def report(self, **changes: Any) -> None:
        """Sends all reports, with changes of the setting."""
        with self._lock:
            if changes:
                self.setting = replace(self.setting, **changes)
            if self.setting.controls is not None:
                self._to.reports.send(reports(self.setting))

    def become(self, state: int) -> None:
        """Reports a state of the scanner, which spins up before it transmits."""
        if state != self.setting.state:
            if state == TRANSMIT:
                self.report(state=SPINNING_UP)
            self.report(state=state)

    def spokes(self, spokes: Sequence[bytes], transmits: bool = True) -> None:
        """Sends spokes, after the reports that it transmits. transmits: whether it still does, once these are sent."""
        if transmits:
            self.become(TRANSMIT)
        self._to.spokes.send(spokes)

    def what_is_due(self, radar: str, at_once: bool = False) -> None:
        """Sends a heartbeat and reports when they are due. radar: its id, by which readers know it again."""
        now = self._clock()
        if now >= self._beaten + HEARTBEATS:
            self._beaten = now
            self._to.heartbeats.send([heartbeat(zlib.crc32(f"radar-service {radar}".encode()), self._beats)])
            self._beats += 1
        if at_once or now >= self._reported + REPORTS:
            self._reported = now
            self.report()


class XhdSink:
    """The spokes of one radar."""

    def __init__(
        self, to: Announcements, is_sent: Callable[[], bool], transmits: Callable[[], bool], note_lost: Callable[[int], None]
    ) -> None:
        """is_sent: whether this radar is the one that is sent; transmits: whether it is not in standby, where last spokes may
        still come; note_lost: counts spokes that are left out."""
        self._to, self._is_sent, self._transmits, self._note_lost = to, is_sent, transmits, note_lost
        self._samples: Samples | None = None
        self._spokes: BowSpokes | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins spokes of another range, which is reported before they come."""
        known = radar.epoch.info.radar
        self._samples, self._spokes = Samples(radar.epoch), BowSpokes(known.azimuths)
        if self._is_sent():
            self._to.report(range=self._samples.metres, range_max=known.longest_range)

    def send(self, batch: SpokeBatch) -> None:
        """Sends the spokes that are complete."""
        assert self._samples is not None and self._spokes is not None, "open_epoch comes first"
        if self._is_sent():
            lost, metres = self._spokes.lost, self._samples.metres
            ended = self._spokes.ended(batch, self._samples.of(batch))
            self._to.spokes([spoke(number, metres, row.tobytes()) for number, row in ended], self._transmits())
            self._note_lost(self._spokes.lost - lost)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Sends nothing: readers see it by the angles."""

    def close(self, reason: str) -> None:
        """Sends nothing."""


class XhdExport(XhdSink):
    """The spokes of a recorded radar, with heartbeats and reports by the time of the capture that they go into."""

    def __init__(self, capture: Capture) -> None:
        senders = XhdSenders(*(CaptureSender(capture, (RADAR, to[1]), to) for to in DESTINATIONS))
        self._announced, self._radar = Announcements(senders, lambda: capture.clock()), ""
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

"""The port of Garmin xHD: one radar of a service is found, shown and commanded as if it were one.

Reports and heartbeats come by the wall clock, at any pace, from a thread of their own, which also takes commands.
"""

import asyncio
import logging
import select
import socket
import threading
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import replace
from typing import Any, NamedTuple

from typing_extensions import override

from radar_service.ports.garmin_xhd.datagrams import (
    FINDERS,
    GROUP,
    SPINNING_UP,
    STANDBY,
    TRANSMIT,
    IgnoredError,
    Setting,
    changed_by,
    heartbeat,
    reports,
    spoke,
)
from radar_service.ports.garmin_xhd.spokes import BowSpokes, Samples
from radar_service.ports.port import Service
from radar_service.ports.port_thread import described
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.capture import Capture
from radar_service.ports.udp.sender import UdpSender
from radar_service.ports.udp.udp_port import Sender, UdpPort
from radar_service.service.logs import Refusals, log_event
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.radio.station import Station, Stations
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink
from radar_service.terminal.arguments import UsageError

REPORTS, HEARTBEATS = 0.5, 1.0  # s between two of each
BETWEEN = 0.005  # s between two readings of commands: so a flood takes a few per cent of a core
LOOK = 0.1  # s between two looks at what is due
MAX_DATAGRAMS = 64  # at once
MAX_COMMAND = 64  # bytes; longer ones are cut, and then of no form
DESTINATIONS = ((FINDERS, 50050), (GROUP, 50100), (GROUP, 50102))  # of heartbeats, reports and spokes


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


class XhdPort(UdpPort):
    """Sends the first radar, or `radar`. The thread of the port sends its spokes; what is reported changes under a lock."""

    name = "garmin-xhd"

    def __init__(
        self, senders: XhdSenders, commands: socket.socket, radar: str | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        """commands: the socket that takes them, which does not wait."""
        super().__init__(senders)
        self._to, self._commands, self._radar, self._clock = senders, commands, radar, clock
        self._stations, self._refused, self._told = Stations(), Refusals(), set[str]()
        self._setting, self._lock = Setting(), threading.Lock()
        self._reported = self._beaten = -HEARTBEATS  # when reports and heartbeats were sent last
        self._beats = 0
        self._changes: dict[str, Any] = {}  # of our controls, not carried out yet
        self._answer: Future[None] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ends = threading.Event()
        self._own_thread = threading.Thread(target=self._run, name="garmin xhd", daemon=True)

    @override
    def check(self, stations: Mapping[str, Station]) -> None:
        if self._radar not in (None, *stations):
            raise UsageError(f"--garmin-xhd-of: {self._radar} is no radar of this service; it has {', '.join(stations)}")

    @override
    async def start(self, service: Service) -> None:
        await super().start(service)
        self._loop, self._stations, self._refused = asyncio.get_running_loop(), service.stations, service.refused
        self._own_thread.start()

    @override
    async def stop(self) -> None:
        self._ends.set()
        await asyncio.to_thread(self._own_thread.join)

    @override
    def close(self) -> None:
        super().close()
        self._commands.close()

    @override
    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        return (XhdSink(radar, self),)

    def is_of(self, radar: str) -> bool:
        """Whether it is the radar of that id that is sent."""
        station = self._stations.of(self._radar)
        return station is not None and station.identity == radar

    def show(self, metres: int, range_max: float) -> None:
        """Reports the range [m] of the spokes that come next."""
        self._report(range=metres, range_max=range_max)

    def send_spokes(self, spokes: Sequence[bytes]) -> None:
        """Sends spokes, after the reports that it transmits."""
        self._become(TRANSMIT)
        self._to.spokes.send(spokes)
        self.count_lost()

    @override
    def changed(self, change: StateChange) -> None:
        if not self.is_of(change.radar):
            return
        if change.kind == "controls":
            has = {**(self._setting.controls or {}), **change.values}
            self._report(controls=has, range=round(has["range_m"]))
        if change.kind == "status":
            self._become(TRANSMIT if change.values["state"] in ("running", "behind") else STANDBY)

    def _become(self, state: int) -> None:
        """Reports a state of the scanner, which spins up before it transmits."""
        if state != self._setting.state:
            if state == TRANSMIT:
                self._report(state=SPINNING_UP)
            self._report(state=state)

    def _report(self, **changes: Any) -> None:
        """Sends all reports, with changes."""
        with self._lock:
            if changes:
                self._setting = replace(self._setting, **changes)
            if self._setting.controls is not None:
                self._to.reports.send(reports(self._setting))
        self.count_lost()

    def _run(self) -> None:
        while not self._ends.wait(BETWEEN):
            try:
                if select.select([self._commands], [], [], LOOK)[0]:
                    self._read()
                self._carry_out()
                self._send_what_is_due()
            except Exception as error:  # of any kind: the next commands may be followed
                log_event("garmin xhd failed", logging.ERROR, reason=described(error))

    def _send_what_is_due(self) -> None:
        station, now = self._stations.of(self._radar), self._clock()
        if station is not None and now >= self._beaten + HEARTBEATS:
            self._beaten = now
            self._to.heartbeats.send([heartbeat(zlib.crc32(f"radar-service {station.identity}".encode()), self._beats)])
            self._beats += 1
        if station is not None and now >= self._reported + REPORTS:
            self._reported = now
            self._report()

    def _read(self) -> None:
        """Takes commands that have come. Of several for one control the last one holds."""
        for _ in range(MAX_DATAGRAMS):
            try:
                command = self._commands.recv(MAX_COMMAND)
            except OSError:  # none is left; or the interface is away
                return
            try:
                changes, level = changed_by(command, self._setting)
            except IgnoredError as reason:
                self._ignore(str(reason))
                continue
            self._changes.update(changes)
            with self._lock:
                self._setting = replace(self._setting, level=level)

    def _carry_out(self) -> None:
        """Changes controls, once the change before is made. The reports tell whether they have changed."""
        if self._answer is not None:
            if not self._answer.done():
                return
            if self._answer.exception() is not None:
                self._ignore("refused")
            self._answer = None
            self._reported = -REPORTS
        station = self._stations.of(self._radar)
        if self._changes and station is not None and self._loop is not None:
            requested, self._changes = self._changes, {}
            self._answer = asyncio.run_coroutine_threadsafe(station.change(requested), self._loop)

    def _ignore(self, word: str) -> None:
        """Counts a command that is not followed; the log has the first one of each kind."""
        self._refused(f"xhd-{word}", 1)
        if word not in self._told:
            self._told.add(word)
            log_event("command not followed", logging.WARNING, port=self.name, reason=word)


class XhdSink:
    """The spokes of one radar."""

    def __init__(self, radar: str, port: XhdPort) -> None:
        self._radar, self._port = radar, port
        self._samples: Samples | None = None
        self._spokes: BowSpokes | None = None

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins spokes of another range, which is reported before they come."""
        self._samples, self._spokes = Samples(radar.epoch), BowSpokes(radar.epoch.info.radar.azimuths)
        if self._port.is_of(self._radar):
            self._port.show(self._samples.metres, radar.epoch.info.radar.range_max)

    def send(self, batch: SpokeBatch) -> None:
        """Sends the spokes that are complete."""
        assert self._samples is not None and self._spokes is not None, "open_epoch comes first"
        if not self._port.is_of(self._radar):
            return
        lost, metres = self._spokes.lost, self._samples.metres
        ended = self._spokes.ended(batch, self._samples.of(batch))
        self._port.lost += self._spokes.lost - lost
        self._port.send_spokes([spoke(number, metres, row.tobytes()) for number, row in ended])

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """Sends nothing: readers see it by the angles."""

    def close(self, reason: str) -> None:
        """Sends nothing."""

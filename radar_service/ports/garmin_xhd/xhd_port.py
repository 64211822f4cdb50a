"""The port of Garmin xHD: one radar of a service is found, shown and commanded as if it were one."""

import asyncio
import logging
import select
import socket
import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from typing import Any

from typing_extensions import override

from radar_service.ports.garmin_xhd.announcements import Announcements, XhdSenders, XhdSink
from radar_service.ports.garmin_xhd.datagrams import STANDBY, TRANSMIT, IgnoredError, changed_by
from radar_service.ports.port import Service
from radar_service.ports.port_thread import described
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.service.logs import Refusals, log_event
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.radio.station import Station, Stations
from radar_service.service.radio.status import state
from radar_service.service.spokes import SpokeSink
from radar_service.terminal.arguments import UsageError

BETWEEN = 0.005  # s between two readings of commands: so a flood takes a few per cent of a core
LOOK = 0.1  # s between two looks at what is due
MAX_DATAGRAMS = 64  # at once
TRANSMITS = ("running", "behind")  # states of a radar
MAX_COMMAND = 64  # bytes; longer ones are cut, and then of no form


class XhdPort(UdpPort):
    """Sends the first radar, or `radar`. The thread of the port sends its spokes. A thread of its own sends reports and
    heartbeats by the wall clock, at any pace, and takes commands."""

    name = "garmin-xhd"

    def __init__(self, senders: XhdSenders, commands: socket.socket, radar: str | None = None) -> None:
        """commands: the socket that takes them, which does not wait."""
        super().__init__(senders)
        self._to, self._commands, self._radar = Announcements(senders), commands, radar
        self._stations, self._refused, self._told = Stations(), Refusals(), set[str]()
        self._changes: dict[str, Any] = {}  # of our controls, not carried out yet
        self._level = self._to.setting.level  # of auto gain, that was asked for
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
        return (XhdSink(self._to, lambda: self._is_of(radar), self._transmits, self._note_lost),)

    @override
    def changed(self, change: StateChange) -> None:
        if not self._is_of(change.radar):
            return
        if change.kind == "controls":
            has = {**(self._to.setting.controls or {}), **change.values}
            self._to.report(controls=has, range=round(has["range_m"]))
        if change.kind == "status":
            self._to.become(TRANSMIT if change.values["state"] in TRANSMITS else STANDBY)

    def _is_of(self, radar: str) -> bool:
        """Whether it is the radar of that id that is sent."""
        station = self._stations.of(self._radar)
        return station is not None and station.identity == radar

    def _transmits(self) -> bool:
        station = self._stations.of(self._radar)
        return station is not None and state(station) in TRANSMITS

    def _note_lost(self, spokes: int) -> None:
        self.lost += spokes
        self.count_lost()

    def _run(self) -> None:
        while not self._ends.wait(BETWEEN):
            try:
                if select.select([self._commands], [], [], LOOK)[0]:
                    self._read()
                if self._level != self._to.setting.level:
                    self._to.report(level=self._level)
                if (station := self._stations.of(self._radar)) is not None:
                    self._to.what_is_due(station.identity, self._has_answer())
                    self._carry_out(station)
            except Exception as error:  # of any kind: the next commands may be followed
                log_event("garmin xhd failed", logging.ERROR, reason=described(error))

    def _read(self) -> None:
        """Takes commands that have come. Of several for one control the last one holds."""
        for _ in range(MAX_DATAGRAMS):
            try:
                command = self._commands.recv(MAX_COMMAND)
            except OSError:  # none is left; or the interface is away
                return
            try:
                changes, level = changed_by(command, self._to.setting)
            except IgnoredError as reason:
                self._ignore(str(reason))
                continue
            self._changes.update(changes)
            self._level = self._level if level is None else level

    def _has_answer(self) -> bool:
        """Whether the last change of controls was made or refused, which reports then tell at once."""
        if self._answer is None or not self._answer.done():
            return False
        if self._answer.exception() is not None:
            self._ignore("refused")
        self._answer = None
        return True

    def _carry_out(self, station: Station) -> None:
        """Changes controls, once the change before is made."""
        if self._changes and self._answer is None and self._loop is not None:
            requested, self._changes = self._changes, {}
            self._answer = asyncio.run_coroutine_threadsafe(station.change(requested), self._loop)

    def _ignore(self, word: str) -> None:
        """Counts a command that is not followed; the log has the first one of each kind."""
        self._refused(f"xhd-{word}", 1)
        if word not in self._told:
            self._told.add(word)
            log_event("command not followed", logging.WARNING, port=self.name, reason=word)

"""The port of a dialect: one radar of a service is found, shown and commanded as if it were of that maker."""

import asyncio
import logging
import select
import threading
from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any

from radar_service.ports.dialect.announcements import Announcements, DialectSink, Senders
from radar_service.ports.dialect.dialect import STANDBY, TRANSMIT, Dialect, IgnoredError
from radar_service.ports.port import Service
from radar_service.ports.port_thread import described
from radar_service.ports.udp.addresses import UdpListener
from radar_service.ports.udp.udp_port import OneRadarPort
from radar_service.service.logs import Refusals, log_event
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.radio.station import Station
from radar_service.service.radio.status import state
from radar_service.service.spokes import SpokeSink

BETWEEN = 0.005  # s between two readings of commands: so a flood takes a few per cent of a core
LOOK = 100  # ms between two looks at what is due
TRANSMITS = ("running", "behind")  # states of a radar
MAX_COMMAND = 64  # bytes; longer ones are cut, and then of no form


class DialectPort(OneRadarPort):
    """Sends the first radar, or `radar`. The thread of the port sends its spokes. A thread of its own takes commands, and sends
    reports, and what it is found by, by the wall clock at any pace."""

    def __init__(
        self, dialect: Dialect, here: str, senders: Senders, listeners: Sequence[UdpListener], radar: str | None = None
    ) -> None:
        """here: the radar's address; listeners: take commands."""
        super().__init__(senders, f"--{dialect.name}-of", radar)
        self.name = dialect.name  # type: ignore[misc]
        self._to, self._listeners = Announcements(dialect, here, senders), listeners
        self._refused, self._told = Refusals(), set[str]()
        self._changes: dict[str, Any] = {}  # of our controls, not carried out yet
        self._level = self._to.setting.level  # of auto gain, that was asked for
        self._answer: Future[None] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ends = threading.Event()
        self._own_thread = threading.Thread(target=self._run, name=self.name.replace("-", " "), daemon=True)

    async def start(self, service: Service) -> None:
        """Begins to take commands."""
        await super().start(service)
        self._loop, self._refused = asyncio.get_running_loop(), service.refused
        self._own_thread.start()

    async def stop(self) -> None:
        """Takes no more commands."""
        self._ends.set()
        await asyncio.to_thread(self._own_thread.join)

    def close(self) -> None:
        """Closes all sockets."""
        super().close()
        for each in self._listeners:
            each.close()

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """Returns the sink of a radar."""

        def transmits() -> bool:
            return self.station is not None and state(self.station) in TRANSMITS

        return (DialectSink(self._to, lambda: self.is_of(radar), transmits, self.note_lost),)

    def changed(self, change: StateChange) -> None:
        """Reports a change."""
        if not self.is_of(change.radar):
            return
        if change.kind == "controls":
            has = {**(self._to.setting.controls or {}), **change.values}
            self._to.report(controls=has, range=round(has["range_m"]))
        if change.kind == "status":
            self._to.become(TRANSMIT if change.values["state"] in TRANSMITS else STANDBY)

    def _run(self) -> None:
        poll = select.poll()  # `select` takes no descriptor from 1024 on
        for socket in (socket for each in self._listeners for socket in each.sockets):
            poll.register(socket, select.POLLIN)
        while not self._ends.wait(BETWEEN):
            try:
                poll.poll(LOOK)
                sought = self._read()
                if self._level != self._to.setting.level:
                    self._to.report(level=self._level)
                if (station := self.station) is not None:
                    self._to.what_is_due(station.identity, self._has_answer(), sought)
                    self._carry_out(station)
            except Exception as error:  # of any kind: the next commands may be followed
                log_event(f"{self.name} failed", logging.ERROR, reason=described(error))

    def _read(self) -> bool:
        """Takes commands that have come, of several for one control the last one; returns whether readers look for radars."""
        sought = False
        for command, *_ in (datagram for each in self._listeners for datagram in each.datagrams(MAX_COMMAND)):
            try:
                changes = self._to.dialect.changed_by(command, self._to.setting)
            except IgnoredError as reason:
                self._ignore(str(reason))
                continue
            sought |= changes.pop("sought", False)
            self._level = changes.pop("level", self._level)
            self._changes.update(changes)
        return sought

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
        self._refused(f"{self.name.rpartition('-')[2]}-{word}", 1)
        if word not in self._told:
            self._told.add(word)
            log_event("command not followed", logging.WARNING, port=self.name, reason=word)

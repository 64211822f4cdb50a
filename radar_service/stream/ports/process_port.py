"""A port that works in a process of its own: worth it where it takes more than a few per cent of a processor.

Its thread in the service hands on what it is called with, by a channel; a process that is too slow holds it back there, so what
is too much is dropped and counted as for any port. A process that has died is followed by another one, which is told of the
numbers that were lost.
"""

import asyncio
import contextlib
from collections.abc import Sequence
from time import monotonic
from typing import Any

from radar_service.records.spokes import SpokeBlock
from radar_service.stream.ports.port import Port, Service
from radar_service.stream.ports.state_changes import StateChange
from radar_service.stream.processes.channel import Channel
from radar_service.stream.processes.fork_server import Child, ForkServer
from radar_service.stream.spokes import RadarInfo, SpokeBatch, SpokeSink

START_SECONDS = 20.0  # for the process to import what it needs, and to open the port
STOP_SECONDS = 0.8  # for it to do what was sent to it, within the time that a port has to stop
AFTER_DEATH = 5.0  # s between two starts: one that dies at once is not started without end
DIED = "the port's process has died"


class PortError(Exception):
    """The process of a port has failed. The text says why."""


class ProcessPort(Port):
    """A port without routes, which is made, called and closed in a process of its own."""

    def __init__(self, kind: type[Port], *arguments: object) -> None:
        """kind: of the port, made there with these arguments, which must be picklable. It has sinks, a clock and takes changes;
        raises TypeError for one that works with the service itself."""
        for name in ("routes", "start", "stop"):
            if getattr(kind, name) is not getattr(Port, name):
                raise TypeError(f"{kind.__name__}.{name}: it needs the service, which its own process does not have")
        self.name, self.period, self.sources = kind.name, kind.period, kind.sources  # type: ignore[misc]  # of this port alone
        self.starts = 0  # of processes
        self._kind, self._arguments = kind, arguments
        self._child: Child | None = None
        self._began = 0.0

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """As Port.sinks."""
        return () if self._kind.sinks is Port.sinks else (_FarSink(radar, self),)

    async def start(self, service: Service) -> None:
        """Starts the process. Raises PortError where it cannot make the port, and OSError."""
        await asyncio.to_thread(self._begin, service.fork_server)

    async def stop(self) -> None:
        """Ends the process when it has done what was sent to it, after STOP_SECONDS at the latest."""
        if child := self._child:
            await asyncio.to_thread(_end, child)

    def tick(self, radar: str, time: float) -> None:
        """As Port.tick."""
        self.tell("tick", radar, time)

    def changed(self, change: StateChange) -> None:
        """As Port.changed."""
        if self._kind.changed is not Port.changed:
            self.tell("changed", change)

    def tell(self, *message: object) -> None:
        """Hands a call on. Raises PortError for what has failed in the process, and where it has died; then another one starts.

        Is called by the port's thread alone.
        """
        if self._child is None:
            raise PortError("the port has not started")
        try:
            self._child.data.send(message)
            if self._child.control.wait(0.0):
                raise PortError(self._child.control.receive()[1])
        except (OSError, EOFError):
            if monotonic() - self._began >= AFTER_DEATH:
                self._child.close()
                self._begin(self._fork_server)
            raise PortError(DIED) from None

    def _begin(self, fork_server: ForkServer) -> None:
        self._fork_server, self._began = fork_server, monotonic()
        child = fork_server.child(work, self._kind, self._arguments)
        with contextlib.ExitStack() as on_failure:
            on_failure.callback(child.close)
            try:
                is_ready, text = child.control.receive(START_SECONDS)
            except TimeoutError:
                raise PortError(f"{self.name}: its process was not ready after {START_SECONDS:g} s") from None
            except (OSError, EOFError):
                raise PortError(f"{self.name}: {DIED}") from None
            if not is_ready:
                raise PortError(text)
            on_failure.pop_all()
        self._child, self.starts = child, self.starts + 1


class _FarSink:
    """Hands the spokes of one radar on. A process that follows another one is told of the epoch first."""

    def __init__(self, radar: str, port: ProcessPort) -> None:
        self._name, self._port = radar, port
        self._radar: RadarInfo | None = None
        self._next = self._starts = 0  # number of the next spoke; process that knows the epoch

    def open_epoch(self, radar: RadarInfo) -> None:
        """As SpokeSink.open_epoch."""
        self._radar, self._next, self._starts = radar, 0, self._port.starts
        self._port.tell("open_epoch", self._name, radar)

    def send(self, batch: SpokeBatch) -> None:
        """As SpokeSink.send."""
        self._make_known(batch.first)
        block = vars(batch.block) | {"range": None}  # the epoch has it
        self._port.tell("send", self._name, batch.first, block, batch.video, batch.before, batch.earlier)
        self._next = batch.first + len(batch)

    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        """As SpokeSink.skip."""
        self._make_known(first)
        self._port.tell("skip", self._name, epoch, first, count, reason)
        self._next = first + count

    def close(self, reason: str) -> None:
        """As SpokeSink.close."""
        self._port.tell("close", self._name, reason)

    def _make_known(self, first: int) -> None:
        """Tells a process that has not seen it of the epoch, and of all its numbers so far; any of those that were lost."""
        if self._radar is None:
            return
        if self._starts != self._port.starts:
            self.open_epoch(self._radar)
        if first > self._next:
            self._port.tell("skip", self._name, self._radar.epoch.name, self._next, first - self._next, DIED)
            self._next = first


def _end(child: Child) -> None:
    with contextlib.suppress(OSError, EOFError):  # TimeoutError is an OSError
        child.data.close()  # its end is what it waits for
        while True:
            child.control.receive(STOP_SECONDS)
    child.close()


class _NearSinks:
    """The sinks of one radar, in the process of the port."""

    def __init__(self, sinks: Sequence[SpokeSink]) -> None:
        self._sinks = tuple(sinks)
        self._radar: RadarInfo | None = None

    def call(self, name: str, *arguments: Any) -> None:
        """Calls all of them."""
        if name == "open_epoch":
            (self._radar,) = arguments
        if name == "send":
            arguments = (self._batch(*arguments),)
        for sink in self._sinks:
            getattr(sink, name)(*arguments)

    def _batch(self, first: int, block: dict[str, Any], *rest: Any) -> SpokeBatch:
        assert self._radar is not None, "open_epoch comes first"
        epoch = self._radar.epoch
        return SpokeBatch(epoch, first, SpokeBlock(**block | {"range": epoch.info.range}), *rest)


def work(control: Channel, data: Channel, kind: type[Port], arguments: Sequence[object]) -> None:
    """Is the life of the process: makes the port, calls it until the service closes the channel, and closes it."""
    try:
        port = kind(*arguments)
    except Exception as error:  # of any kind: the service must be notified
        return control.send((False, f"{kind.name}: {type(error).__name__}: {error}"))
    control.send((True, ""))
    radars: dict[str, _NearSinks] = {}
    with contextlib.closing(port), contextlib.suppress(OSError, EOFError):  # the service has ended, or the port
        while True:
            name, *rest = data.receive()
            try:
                if name in ("tick", "changed"):
                    getattr(port, name)(*rest)
                else:
                    radar, *rest = rest
                    if radar not in radars:
                        radars[radar] = _NearSinks(port.sinks(radar))
                    radars[radar].call(name, *rest)
            except Exception as error:  # of any kind: the port goes on
                control.send((False, f"{type(error).__name__}: {error}"))

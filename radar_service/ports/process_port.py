"""A port that works in a process of its own: worth it where it takes more than a few per cent of a processor.

Its thread in the service hands on what it is called with, by a channel; a process that is too slow holds it back there, so what
is too much is dropped and counted as for any port. A process that has died is followed by another one, which is told of the
numbers that were lost.
"""

import asyncio
import contextlib
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from time import monotonic
from typing import Any

from typing_extensions import override

from radar_service.ports.port import Port, Service
from radar_service.ports.port_thread import PortThread, described
from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import Child
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio.state_changes import Kind, StateChange
from radar_service.service.spokes import RadarInfo, SpokeBatch, SpokeSink

START_SECONDS = 10.0  # for the process to import what it needs, and to make the port
STOP_SECONDS = 0.8  # for it to do what was sent to it, within the time that a port has to stop
AFTER_DEATH = 5.0  # s between two starts: one that dies at once is not started without end
MAX_TEXT = 500  # characters of what a fault says
DIED = "the port's process has died"

Report = Callable[[BaseException], None]


class PortError(Exception):
    """The process of a port has failed. The text says why."""


class ProcessPort(Port):
    """A port without routes, which is made, called and closed in a process of its own. starts: of processes so far."""

    def __init__(
        self, kind: type[Port], *arguments: object, period: float | None = None, sources: SourceRequest | None = None
    ) -> None:
        """kind: of the port, made there with these arguments, which must be picklable; it has sinks, a clock and takes changes.
        period, sources: as of Port, by default those of the class.

        Raises TypeError for a port that works with the service itself, or that radars wait for.
        """
        for name in ("routes", "start", "stop"):
            if getattr(kind, name) is not getattr(Port, name):
                raise TypeError(f"{kind.__name__}.{name}: it needs the service, which its own process does not have")
        if kind.delays:
            raise TypeError(
                f"{kind.__name__}.delays: no radar waits for another process; make the port in the service itself"
            )
        self.name = kind.name  # type: ignore[misc]  # of this port alone
        self.period, self.sources = period or kind.period, sources or kind.sources
        self.starts = 0
        self._kind, self._arguments = kind, arguments
        self._child: Child | None = None
        self._began, self._is_ending = 0.0, False
        self._state: dict[tuple[str, Kind], StateChange] = {}  # for a process that follows another one

    @override
    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        return () if self._kind.sinks is Port.sinks else (_FarSink(radar, self),)

    async def start(self, service: Service) -> None:
        """Starts the process. Raises PortError where it cannot make the port, and OSError."""
        self._fork_server = service.fork_server
        self._thread = next(thread for thread in service.threads if thread.name == self.name)
        await asyncio.to_thread(self._begin)

    async def stop(self) -> None:
        """Ends the process when it has done what was sent to it, after STOP_SECONDS at the latest."""
        self._is_ending = True
        if child := self._child:
            child.data.end()
            await asyncio.to_thread(self._faults.join, STOP_SECONDS)
            child.close()

    @override
    def tick(self, radar: str, time: float) -> None:
        self.tell("tick", radar, time)

    @override
    def changed(self, change: StateChange) -> None:
        """A process that follows another one is told the state first."""
        if self._kind.changed is Port.changed:
            return
        place = change.radar, change.kind
        self._state[place] = change.after(self._state[place]) if place in self._state else change
        self.tell("changed", change)

    def tell(self, *message: object) -> None:
        """Hands a call on; it waits where the process is too slow. Is called by the port's thread alone.

        Raises PortError where the process has died; then another one starts, and the call is lost.
        """
        if self._child is None or self._is_ending:
            raise PortError("the port does not run")
        try:
            self._child.data.send(message)
        except OSError:
            if not self._is_ending and monotonic() - self._began >= AFTER_DEATH:
                self._child.close()
                self._begin()
                for change in self._state.values():
                    self.tell("changed", change)
            raise PortError(DIED) from None

    def _begin(self) -> None:
        self._began = monotonic()
        child = self._fork_server.child(work, self._kind, self._arguments)
        with contextlib.ExitStack() as on_failure:
            on_failure.callback(child.close)
            try:
                is_ready, text = child.control.receive(START_SECONDS)
            except TimeoutError:
                raise PortError(f"{self.name}: its process was not ready after {START_SECONDS:g} s") from None
            except (OSError, EOFError):
                raise PortError(
                    f"{self.name}: its process has died as it began; can {self._kind.__module__} be imported?"
                ) from None
            if not is_ready:
                raise PortError(text)
            on_failure.pop_all()
        self._child, self.starts = child, self.starts + 1
        name, arguments = f"port {self.name} faults", (child.control, self._thread)
        self._faults = threading.Thread(target=_count_faults, args=arguments, name=name, daemon=True)
        self._faults.start()


def _count_faults(control: Channel, thread: PortThread) -> None:
    """Counts what fails in a process until that has ended."""
    with contextlib.suppress(OSError, EOFError):
        while True:
            thread.note_fault(control.receive()[1])


class _FarSink(SpokeSink):
    """Hands the spokes of one radar on. A process that follows another one is told of the epoch first."""

    def __init__(self, radar: str, port: ProcessPort) -> None:
        self._name, self._port = radar, port
        self._radar: RadarInfo | None = None
        self._next = self._starts = 0  # number of the next spoke; process that knows the epoch

    @override
    def open_epoch(self, radar: RadarInfo) -> None:
        self._radar, self._next = radar, 0
        self._port.tell("open_epoch", self._name, radar)
        self._starts = self._port.starts

    @override
    def send(self, batch: SpokeBatch) -> None:
        self._make_known(batch.first)
        block = vars(batch.block) | {"range": None}  # the epoch has it
        self._port.tell("send", self._name, batch.first, block, batch.video, batch.before, batch.earlier)
        self._next = batch.first + len(batch)

    @override
    def skip(self, epoch: str, first: int, count: int, reason: str) -> None:
        self._make_known(first)
        self._port.tell("skip", self._name, epoch, first, count, reason)
        self._next = first + count

    @override
    def close(self, reason: str) -> None:
        self._make_known(self._next)
        self._port.tell("close", self._name, reason)

    def _make_known(self, first: int) -> None:
        """Tells a process that has not seen it of the epoch, and of all its numbers so far; any of those that were lost."""
        assert self._radar is not None, "open_epoch comes first"
        if self._starts != self._port.starts:
            self.open_epoch(self._radar)
        if first > self._next:
            self._port.tell("skip", self._name, self._radar.epoch.name, self._next, first - self._next, DIED)
            self._next = first


class _NearSinks:
    """The sinks of one radar, in the process of the port. report: takes what one of them raises."""

    def __init__(self, sinks: Sequence[SpokeSink], report: Report) -> None:
        self._sinks, self._report = tuple(sinks), report
        self._radar: RadarInfo | None = None

    def call(self, name: str, *arguments: Any) -> None:
        """Calls all of them."""
        if name == "open_epoch":
            (self._radar,) = arguments
        if name == "send":
            arguments = (self._batch(*arguments),)
        for sink in self._sinks:
            with _reported(self._report):
                getattr(sink, name)(*arguments)

    def _batch(self, first: int, block: dict[str, Any], *rest: Any) -> SpokeBatch:
        assert self._radar is not None, "open_epoch comes first"
        epoch = self._radar.epoch
        return SpokeBatch(epoch, first, SpokeBlock(**block | {"range": epoch.info.range}), *rest)


@contextlib.contextmanager
def _reported(report: Report) -> Iterator[None]:
    """Reports what is raised, of any kind: the port goes on."""
    try:
        yield
    except BaseException as error:
        report(error)


def work(control: Channel, data: Channel, kind: type[Port], arguments: Sequence[object]) -> None:
    """Is the life of the process: makes the port, calls it until the service ends the channel, and closes it."""
    has_ended = threading.Event()
    threading.Thread(target=_end_with, args=(control, has_ended), daemon=True).start()
    try:
        port = kind(*arguments)
    except Exception as error:  # of any kind: the service must be notified
        return control.send((False, f"{kind.name}: {described(error)}"[:MAX_TEXT]))
    control.send((True, ""))

    def report(error: BaseException) -> None:
        with contextlib.suppress(OSError):  # the service has ended
            control.send((False, described(error)[:MAX_TEXT]))

    radars: dict[str, _NearSinks] = {}
    with contextlib.suppress(OSError, EOFError):  # the service has ended, or the port
        while True:
            name, *rest = data.receive()
            with _reported(report):
                if name in ("tick", "changed"):
                    getattr(port, name)(*rest)
                else:
                    radar, *rest = rest
                    if radar not in radars:
                        radars[radar] = _NearSinks(port.sinks(radar), report)
                    radars[radar].call(name, *rest)
    with _reported(report):
        port.close()
    has_ended.set()


def _end_with(control: Channel, has_ended: threading.Event) -> None:
    """Ends the process when the service is gone, also where the port hangs."""
    with contextlib.suppress(OSError, EOFError):
        control.receive()
    if not has_ended.wait(STOP_SECONDS):
        os._exit(1)

"""Runs the ports of a service: hands them the changes of radars, calls their clocks, and keeps their faults from all others.

Of the changes that a port has not been told yet there is one of each radar and kind, however many there were.
"""

import asyncio
import logging
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from fastapi import APIRouter

from radar_service.ports.port import Port, Service
from radar_service.ports.port_thread import PortThread, QueuedSink
from radar_service.ports.refusal_shapes import Shape
from radar_service.records import SourceRequest
from radar_service.service.codecs.codec import CODECS
from radar_service.service.logs import log_event
from radar_service.service.radio.state_changes import Kind, StateChange, StateWatch, ended
from radar_service.service.radio.station import Station
from radar_service.service.spokes import SpokeSink

LOOK = 0.1  # s between two looks at the state of radars and, at most, at their clocks
SHORTEST = 0.02  # s between two calls of `tick` on the wall clock
STOP_SECONDS = 1.0  # for a port to do what waits, and then to stop
AFTER_FAULT = 5.0  # s until the next look


class ToldChanges:
    """Tells a port of changes, by its thread. None is lost: those that wait become one change of their kind."""

    def __init__(self, changed: Callable[[StateChange], None], thread: PortThread) -> None:
        """changed: takes a change."""
        self._changed, self._thread = changed, thread
        self._waiting: dict[tuple[str, Kind], StateChange] = {}
        self._lock = threading.Lock()

    def put(self, change: StateChange) -> None:
        """Notes a change that is to be told."""
        key = change.radar, change.kind
        with self._lock:
            earlier = self._waiting.get(key)
            self._waiting[key] = change if earlier is None else change.after(earlier)
        self._thread.put(partial(self._tell, key), key=(self, key))

    def _tell(self, key: tuple[str, Kind]) -> None:
        with self._lock:
            change = self._waiting.pop(key, None)
        if change is not None:
            self._changed(change)


class PortHost:
    """The ports of a service. Belongs to the event loop, but for `sinks`, which comes before it."""

    def __init__(self, ports: Sequence[Port]) -> None:
        self._ports = tuple(ports)
        CODECS.update({codec.name: codec for port in self._ports for codec in port.codecs})
        self.threads = {port: PortThread(port.name) for port in self._ports}
        for port, thread in self.threads.items():
            port.thread = thread
        self._listeners = [
            ToldChanges(port.changed, thread)
            for port, thread in self.threads.items()
            if type(port).changed is not Port.changed
        ]
        self._sinks: dict[str, list[QueuedSink]] = {}  # of each radar
        self._started: list[Port] = []
        self._tasks: dict[Station, list[asyncio.Task[None]]] = {}

    def routes(self, service: Service) -> list[APIRouter]:
        """Returns the routes of all ports."""
        return [router for port in self._ports for router in port.routes(service)]

    def sinks(self, radar: str) -> list[SpokeSink]:
        """Returns the sinks of all ports for a radar; before each that must not delay it stands a queue."""
        result: list[SpokeSink] = []
        for port in self._ports:
            result += [sink if port.delays else QueuedSink(sink, self.threads[port]) for sink in port.sinks(radar)]
        self._sinks[radar] = [sink for sink in result if isinstance(sink, QueuedSink)]
        return result

    @property
    def sources(self) -> SourceRequest:
        """What the sinks need of the sources of cells."""
        result = SourceRequest()
        for port in self._ports:
            result |= port.sources
        return result

    @property
    def refusals(self) -> dict[str, Shape]:
        """The shapes of refusals by the beginning of paths."""
        return {begin: shape for port in self._ports for begin, shape in port.refusals.items()}

    def check(self, stations: Mapping[str, Station]) -> None:
        """Raises UsageError where the options of a port do not suit the radars."""
        for port in self._ports:
            port.check(stations)

    async def start(self, service: Service) -> None:
        """Starts the ports, before the radars. Raises what a port raises."""
        for port in self._ports:
            await port.start(service)
            self._started.append(port)
            self.threads[port].start()

    def watch(self, station: Station) -> None:
        """Tells the ports from now on of the changes and of the time of a radar."""
        ticks = [self._tick(port, station, port.period) for port in self.threads if port.period is not None]
        self._tasks[station] = [asyncio.create_task(each) for each in (self._watch(station), *ticks)]

    def unwatch(self, station: Station) -> None:
        """Tells the ports that a radar has ended, and nothing more of it."""
        for task in self._tasks.pop(station, ()):
            task.cancel()
        for port in self._listeners:
            port.put(ended(station))

    async def stop(self) -> None:
        """Ends the ports that were started; one that does not end in time is left behind."""
        tasks = [task for each in self._tasks.values() for task in each]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.gather(*(asyncio.to_thread(thread.stop, STOP_SECONDS) for thread in self.threads.values()))
        await asyncio.gather(*(self._stopped(port) for port in self._started))

    async def _stopped(self, port: Port) -> None:
        try:
            await asyncio.wait_for(port.stop(), STOP_SECONDS)
        except Exception as error:  # of any kind: the others stop too
            log_event("port not stopped", logging.ERROR, port=port.name, reason=f"{type(error).__name__}: {error}")

    async def _watch(self, station: Station) -> None:
        """Hands the changes of a radar to the ports; those of an epoch once their sinks know that it is open."""
        watch = StateWatch(station)
        while True:
            try:
                sinks = self._sinks.get(station.identity, ())
                for change in watch.changes() if all(sink.epoch == station.epoch.name for sink in sinks) else ():
                    for port in self._listeners:
                        port.put(change)
                await asyncio.sleep(LOOK)
            except Exception as error:  # of any kind: the next changes may be told
                log_event(
                    "changes not told", logging.ERROR, radar=station.identity, reason=f"{type(error).__name__}: {error}"
                )
                await asyncio.sleep(AFTER_FAULT)

    async def _tick(self, port: Port, station: Station, period: float) -> None:
        """Calls the clock of a port for a radar."""
        loop, transmitter = asyncio.get_running_loop(), station.transmitter
        last, due, called = math.inf, -math.inf, -math.inf  # simulated times, and a time of the loop
        while True:
            now, time = loop.time(), transmitter.state.simulated
            stands = transmitter.pacer.idle or transmitter.state.fault is not None
            goes_on = due <= time or time < last  # the time of another scene begins anew
            if goes_on or (stands and now - called >= period):
                self.threads[port].put(partial(port.tick, station.identity, time), key=("tick", station.identity))
                if goes_on:
                    due = due + period if last <= time < due + period else time + period
                last, called = time, now
            wait = called + period - now if stands else (due - time) / station.settings.pace.factor
            await asyncio.sleep(min(max(wait, SHORTEST), LOOK))

"""The interface of ports. A port is one protocol in or out of a service: its options, routes, sinks and clock.

To add one, write a class like `Port` in a package, ours or another, and a line in its `pyproject.toml` (docs/ports.md).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar

from fastapi import APIRouter

from radar_service.ports.port_thread import PortThread
from radar_service.ports.refusal_shapes import Shape
from radar_service.processes.fork_server import ForkServer
from radar_service.records import SourceRequest
from radar_service.service.access import Access, Tickets
from radar_service.service.codecs.codec import Codec
from radar_service.service.logs import Refusals
from radar_service.service.radio.preparation import Preparations
from radar_service.service.radio.state_changes import StateChange
from radar_service.service.radio.station import Station, Stations
from radar_service.service.spokes import SpokeSink


@dataclass(frozen=True)
class Service:
    """What a service has for its ports.

    stations: its radars by their id; the first ones are there when the ports start, and others come and go with scenes.
    access: who may do what; tickets: of browsers for websockets; refused: counts refusals by a word.
    fork_server: starts processes; preparations: where scenes are prepared.
    cancel_jobs: what cancels the jobs that requests wait for, when the service stops.
    threads: of the ports, with what each has lost.
    """

    stations: Stations
    access: Access
    tickets: Tickets
    refused: Refusals
    fork_server: ForkServer
    preparations: Preparations
    cancel_jobs: list[Callable[[], None]] = field(default_factory=list)
    threads: Sequence[PortThread] = ()


class Port:
    """One protocol of a service. A port overrides what its protocol has; here every method does nothing.

    name: for logs and metrics.
    delays: whether radars wait for its sinks, which are then called by the threads of the radars and must not fail. Otherwise
    these are called by a thread of the port, as `tick` and `changed` always are, one at a time; what is too much for them is
    dropped and counted.
    thread: of the port, which a service gives to it; it counts faults and what is dropped.
    period: of `tick` [s].
    sources: what its sinks need of the sources of cells.
    tells_ships: whether it tells how ships move, for which a replay makes the scene again.
    codecs: of feeds for its clients, which the feed of each radar encodes.
    refusals: the shapes of its refusals by the beginning of its paths; without one they are `{"detail": [...]}`.

    What a port is handed it shares with others: it copies what it changes.
    """

    name: ClassVar[str]
    delays: ClassVar[bool] = False
    tells_ships: ClassVar[bool] = False
    thread: PortThread | None = None
    period: float | None = None
    sources: SourceRequest = SourceRequest()
    codecs: Sequence[Codec] = ()
    refusals: Mapping[str, Shape] = MappingProxyType({})

    def routes(self, service: Service) -> Sequence[APIRouter]:
        """Returns its routes, each with its role (`ports.roles.needs`)."""
        return ()

    def sinks(self, radar: str) -> Sequence[SpokeSink]:
        """Returns its sinks for the spokes of the radar of that id, when it begins; one of that id may have ended before."""
        return ()

    def check(self, stations: Mapping[str, Station]) -> None:
        """Checks its options once all radars are there, before `start`. Raises UsageError where they do not fit."""

    async def start(self, service: Service) -> None:
        """Begins, before the radars do. What it raises ends the service."""

    async def stop(self) -> None:
        """Ends, when the radars have ended, within a second."""

    def tick(self, radar: str, time: float) -> None:
        """Runs for each radar once in `period` of the group's time, also in standby and, by the wall clock, in a pause.

        At most 50 times a second, so less often at a high pace. time: of simulation [s]; another scene begins anew.
        """

    def changed(self, change: StateChange) -> None:
        """Takes a change of a radar's state. The first ones, when a radar begins, come after `open_epoch` of its sinks and tell
        all of its state; the last one, when it ends, tells the state "ended". None is dropped: of those that wait one stands for
        all of its kind."""

    def close(self) -> None:
        """Closes what was open before the service started; the last call."""

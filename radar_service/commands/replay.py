"""The command `replay`: serves a recording as `serve` serves scenes."""

import argparse
import contextlib
from collections.abc import Iterator
from typing import Any

from radar_service.commands.serve import OpenPorts, access_for
from radar_service.ports.running import run
from radar_service.processes.call import Progress
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.stop_signals import ended_by_signals
from radar_service.recording.chunk_table import ChunkTable
from radar_service.recording.epochs import radars_with_epoch
from radar_service.recording.error import RecordingError
from radar_service.recording.recording import NO_TRUTH, Recording
from radar_service.records.spokes import SpokeBlock
from radar_service.service import logs
from radar_service.service.controls import CONTROLS, changed_settings
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.logs import log_event
from radar_service.service.radio.prefetch import EngineFault
from radar_service.service.radio.station import Station
from radar_service.service.settings import Settings
from radar_service.service.source import OrderedSource, SceneOrder

ENDED = "the recording has ended"
PLAYS = "this radar replays a recording: its scene and rate of rotation stay; serve a scene to change them"


class ReplaySource(Recording):
    """A recording whose end is told to its clients. has_ended: whether all of it was read."""

    has_ended = False

    @property
    def order(self) -> SceneOrder:
        """The scene as it was recorded."""
        return SceneOrder(self.record["document"] or {})

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields the recorded blocks. Raises EngineFault at the end, and where the file is damaged."""
        try:
            yield from super().blocks(size=size)
        except RecordingError as error:
            raise EngineFault(str(error)) from None
        self.has_ended = True
        raise EngineFault(ENDED)


class ReplayStation(Station):
    """A radar that sends a recording once."""

    def __init__(self, identity: str, engine: ReplaySource, *arguments: Any, settings: Settings, **options: Any) -> None:
        """settings: display controls are those of the recording instead."""
        display = {control.name for control in CONTROLS if control.acts_on == "display"}
        recorded = {name: value for name, value in engine.record["controls"].items() if name in display}
        settings = changed_settings(settings, engine.info.scene, recorded)
        super().__init__(identity, engine, *arguments, settings=settings, restarts=0, **options)

    def join(self, client: ClientQueue, since: tuple[str, int] | None = None) -> None:
        """As Station.join. Raises FeedRefused also for a client that requests the truth of every instant."""
        if client.truth:
            raise FeedRefused(f"truth: {NO_TRUTH}")
        super().join(client, since)

    def _report_failure(self, reason: str) -> None:
        log_event("radar stopped", radar=self.identity, reason=reason)
        self.failed()


def refuse(order: SceneOrder, progress: Progress) -> OrderedSource:
    """Raises EngineFault in place of another scene: a stream.source.MakeSource."""
    raise EngineFault(PLAYS)


def replay(options: argparse.Namespace, open_ports: OpenPorts) -> int:
    """Serves a recording until it has ended or is stopped; returns the exit status.

    open_ports: as of `serve`. Raises RecordingError, StartError and OSError.
    """
    access = access_for(options)
    logs.configure(options.log)
    radars = radars_with_epoch(ChunkTable(options.recording), options.epoch)
    sources = [ReplaySource(options.recording, radar, options.epoch, options.start) for radar in radars]
    if sources and sources[0].epochs > 1:
        print(f"epoch {options.epoch} of {sources[0].epochs}; --epoch selects another", flush=True)
    options.exit_when_failed = True
    fork_server = ForkServer(("radar_service.display.last_scan",), ())
    with ended_by_signals(), contextlib.closing(fork_server):
        fork_server.start()
        with open_ports(options) as ports:
            status = run(
                options, access, lambda: [[source] for source in sources], refuse, fork_server, ports, ReplayStation
            )
    return 0 if all(source.has_ended for source in sources) else status

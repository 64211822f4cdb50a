"""The command `replay`: serves a recording: feed, REST and page."""

import argparse
import contextlib
import errno
import math
from pathlib import Path

from radar_service.commands.serve import access_for
from radar_service.commands.shared_options import add_network, service_groups
from radar_service.ports.registry import add_ports, opened
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.stop_signals import ended_by_signals
from radar_service.service import logs
from radar_service.terminal import add_whole_number, number_between


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    groups = service_groups(parser)
    add_network(groups)
    add_ports(parser, groups, replays=True)
    parser.add_argument("recording", type=Path, metavar="FILE", help="a recording, also one that was cut short")
    parser.add_argument(
        "--from", dest="start", default=0.0, type=seconds, metavar="S", help="simulated time to begin at [s] (default 0)"
    )
    which = "which epoch of the recording, counted from 0 (default 0)"
    add_whole_number(parser, "--epoch", 0, 0, 1_000_000, metavar="N", help=which)


def run(options: argparse.Namespace) -> int:
    """Serves a recording until it has ended or is stopped; returns the exit status.

    Raises RecordingError, UsageError, MissingExtra and OSError.
    """
    if not options.recording.is_file():  # said first: an extra that is missing does not help here
        raise FileNotFoundError(errno.ENOENT, "there is no such file; give a recording", str(options.recording))
    from radar_service.ports.running import run
    from radar_service.recording.chunk_table import ChunkTable, radars_with_epoch
    from radar_service.recording.replay_station import ReplaySpokeSource, ReplayStation, refuse

    access = access_for(options)
    logs.configure(options.log)
    radars = radars_with_epoch(ChunkTable(options.recording), options.epoch)
    recordings = [ReplaySpokeSource(options.recording, radar, options.epoch, options.start) for radar in radars]
    if recordings and recordings[0].epochs > 1:
        print(f"epoch {options.epoch} of {recordings[0].epochs}; --epoch selects another", flush=True)
    options.exit_when_failed = True
    options.start_utc = options.start_utc or (recordings[0].start_utc if recordings else None)
    fork_server = ForkServer(("radar_service.display.last_scan",), ())
    with ended_by_signals(), contextlib.closing(fork_server):
        fork_server.start()
        with opened(options) as ports:
            for recording in recordings:
                recording.together = recordings
                if any(port.tells_ships for port in ports):
                    recording.make_scene_again(options.recording.parent)
            scenes = [[recording] for recording in recordings]
            status = run(options, access, lambda: scenes, refuse, fork_server, ports, ReplayStation)
    return 0 if all(recording.has_ended for recording in recordings) else status


def seconds(text: str) -> float:
    """A time of 0 or more [s]. Raises argparse.ArgumentTypeError."""
    return number_between(text, math.nextafter(0.0, -1.0), math.inf, "a time of 0 s or more")

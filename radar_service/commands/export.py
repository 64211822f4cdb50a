"""The command `export`: writes a recorded radar as captures, of what ports would have sent."""

import argparse
import errno
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from radar_service import plug_ins
from radar_service.terminal import UsageError, add_overwrite, file_ending, prepare, written

if TYPE_CHECKING:
    from radar_service.numerics import Singles
    from radar_service.ports.udp.capture import Capture
    from radar_service.recording import Recording
    from radar_service.service.spokes import SpokeSink


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments, with those of ports that have a part in it."""
    parser.add_argument("recording", type=Path, metavar="FILE", help="a recording, also one that was cut short")
    parser.add_argument("--radar", metavar="ID", help="which of its radars (default the first)")
    add_overwrite(parser)
    for name, package in _packages().items():
        capture = partial(file_ending, suffix=".pcap")
        parser.add_argument(
            f"--{name}", dest=f"to_{name}", type=capture, metavar="FILE.pcap", help=f"write a capture of {name}"
        )
        if hasattr(package, "add_export_arguments"):
            package.add_export_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises RecordingError, UsageError, MissingExtra and OSError."""
    paths = {name: getattr(options, f"to_{name}") for name in _packages() if getattr(options, f"to_{name}") is not None}
    if not paths:
        raise UsageError(f"export: nothing to write; give {' or '.join(f'--{name} FILE.pcap' for name in _packages())}")
    if len({path.resolve() for path in paths.values()}) < len(paths):
        raise UsageError(f"export: {' and '.join(f'--{name}' for name in paths)} name one file; give each a file of its own")
    if not options.recording.is_file():
        raise FileNotFoundError(errno.ENOENT, "there is no such file; give a recording", str(options.recording))
    from radar_service.ports.udp.capture import Capture
    from radar_service.recording import Recording, RecordingError
    from radar_service.recording.chunk_table import ChunkTable, recorded_radars

    radars = recorded_radars(ChunkTable(options.recording))
    radar = options.radar or next(iter(radars), "0")
    first = Recording(options.recording, radar)
    prepare(paths.values(), options.overwrite)
    for name, path in paths.items():
        with written(path) as part:
            capture = Capture(part, raises=True)
            sink, spokes = _packages()[name].exported(radars.index(radar), capture, options), 0
            for number in range(first.epochs):
                spokes += send(Recording(options.recording, radar, number), radar, sink, capture)
            capture.close()
            if not spokes:
                raise RecordingError(f"{options.recording}: it ends before the first spoke of radar {radar}; record again")
        print(f"{path}: {spokes} spokes of radar {radar}")
    return 0


def send(recording: "Recording", radar: str, sink: "SpokeSink", capture: "Capture") -> int:
    """Hands an epoch of a radar to a sink, with the UTC of each spoke as the time of the capture; returns how many spokes."""
    from radar_service.recording.replay_station import recorded_settings
    from radar_service.service.radio.last_scan import CorrelationStage
    from radar_service.service.settings import Settings
    from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, whole_second

    settings, record = recorded_settings(recording, Settings()), recording.record
    start = recording.start_utc or whole_second()
    epoch = Epoch(record["epoch"], recording, settings.range, start_utc=start)
    stage, count = CorrelationStage((sink,)), 0
    before: Singles | None = None
    for block in recording.blocks(size=1):
        time = start.timestamp() + float(block.time[0])
        capture.clock = partial(float, time)
        if count == 0:
            stage.open_epoch(RadarInfo(radar, record["name"], epoch, float(block.time[0]), record["controls"], False))
        stage.send(SpokeBatch(epoch, count, block, settings.video, before))
        count, before = count + 1, block.power[-1]
    return count


def _packages() -> dict[str, Any]:
    """The ports that have a part in it, by name."""
    return {name: package for name, package in plug_ins.working("ports").items() if hasattr(package, "exported")}

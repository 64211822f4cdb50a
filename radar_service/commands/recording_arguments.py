"""The arguments of the commands `record` and `replay`."""

import argparse
from functools import partial
from pathlib import Path

from radar_service.terminal.arguments import add_sources, file_ending, whole
from radar_service.terminal.output_files import add_overwrite


def add_commands(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]", simulation: list[argparse.ArgumentParser],
    network: argparse.ArgumentParser, scene_help: str,
) -> None:  # fmt: skip
    """Adds both commands. simulation, network: parsers of the options that they share with other commands."""
    ending = partial(file_ending, suffix=".mcap")
    record = commands.add_parser("record", parents=simulation, help="compute scans into a recording")
    record.add_argument("scene", metavar="SCENE", help=scene_help)
    record.add_argument("-o", "--out", type=ending, required=True, help="file.mcap to write")
    add_overwrite(record)
    record.add_argument(
        "--scans", default=1, type=partial(whole, minimum=1, maximum=1_000_000), help="revolutions (default 1)"
    )
    record.add_argument("--truth", action="store_true", help="record the truth of each beam crossing too")
    add_sources(record, "record", " too")
    replay = commands.add_parser("replay", parents=[network], help="serve a recording: feed, REST and page")
    replay.add_argument("recording", type=Path, metavar="FILE", help="a recording, also one that was cut short")
    replay.add_argument(
        "--from", dest="start", default=0.0, type=seconds, metavar="S", help="simulated time to begin at [s] (default 0)"
    )
    replay.add_argument(
        "--epoch", default=0, type=partial(whole, minimum=0, maximum=1_000_000), metavar="N",
        help="which epoch of the recording, counted from 0 (default 0)",
    )  # fmt: skip


def seconds(text: str) -> float:
    """A time of 0 or more [s]. Raises argparse.ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f'"{text[:40]}" is not a time of 0 s or more')
    return value

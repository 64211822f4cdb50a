"""The arguments of the commands `bench-tracker`, `bench-detection` and `plots`."""

import argparse
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from radar_service.display.units import add_unit
from radar_service.terminal.arguments import file_ending, whole
from radar_service.terminal.output_files import add_overwrite


def add_bench_tracker(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Adds the command."""
    parser = commands.add_parser("bench-tracker", help="test a tracker on scenarios, and write a report")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="names (see --list), or .toml files")
    parser.add_argument("--list", action="store_true", help="list the scenarios")
    parser.add_argument("--seeds", default=3, type=partial(whole, minimum=1, maximum=100_000), metavar="N", help="default 3")
    _add_jobs(parser)
    parser.add_argument(
        "--tracker", default="gnn",
        help='gnn or jpda, module:callable, ws://host:port, or a command that gets plots and gives tracks (default gnn)',
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=Path, help="folder for report.json, report.html and the runs; it may exist")
    parser.add_argument("--compare", nargs=2, type=Path, metavar="REPORT", help="print two report.json side by side")


def add_bench_detection(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Adds the command."""
    parser = commands.add_parser("bench-detection", help="compare detection by range with the radar equation")
    parser.add_argument(
        "scenario", nargs="?", default="msc192-table2", metavar="SCENARIO",
        help="whose targets are points: a name of bench-tracker --list, or a .toml file (default msc192-table2)",
    )  # fmt: skip
    parser.add_argument(
        "--scans",
        default=100,
        type=partial(whole, minimum=40, maximum=100_000),
        metavar="N",
        help="of each range (default 100)",
    )
    parser.add_argument(
        "--ranges", default=16, type=partial(whole, minimum=2, maximum=200), metavar="N", help="of each target (default 16)"
    )
    parser.add_argument("--seed", default=0, type=partial(whole, minimum=0, maximum=2**32), metavar="N", help="default 0")
    _add_jobs(parser)
    parser.add_argument("-o", "--out", type=Path, required=True, help="folder for detection.json and detection.html")


def add_plots(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]",
    parents: Sequence[argparse.ArgumentParser],
    scene_help: str,
) -> None:
    """Adds the command."""
    parser = commands.add_parser("plots", parents=[*parents], help="extract plots, and tell by labels what each is of")
    parser.add_argument("scene", nargs="?", default="harbour", metavar="SCENE", help=scene_help)
    parser.add_argument(
        "--scans", default=10, type=partial(whole, minimum=1, maximum=10_000), help="revolutions (default 10)"
    )
    parser.add_argument("--threshold", default="ca", choices=["known", "ca", "os"], help="see docs/plots.md (default ca)")
    parser.add_argument("--pfa", default=1e-4, type=_probability, help="false alarms per cell of noise (default 1e-4)")
    for name, default, text in (("guard", 100.0, "beside a cell, not averaged"), ("window", 300.0, "averaged on each side")):
        parser.add_argument(
            f"--{name}-m", default=default, type=_length, metavar="M", help=f"length {text} (default {default:g})"
        )
    parser.add_argument(
        "--max-plots", default=10_000, type=partial(whole, minimum=1, maximum=10_000), metavar="N",
        help="the strongest of a scan (default 10000)",
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=partial(file_ending, suffix=".json"), help="file.json to write")
    parser.add_argument("--png", type=partial(file_ending, suffix=".png"), help="file.png to write: the plots on the PPI")
    add_unit(parser, "--png")
    add_overwrite(parser)


def _probability(text: str) -> float:
    return _between(text, 0.0, 1.0, "a probability between 0 and 1, as 1e-4")


def _length(text: str) -> float:
    return _between(text, 0.0, 1e6, "a length above 0 m, as 100")


def _between(text: str, lower: float, upper: float, allowed: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = lower
    if not lower < value < upper:
        raise argparse.ArgumentTypeError(f"{text:.40} is not allowed; {allowed}")
    return value


def _add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs", default=max(1, (os.cpu_count() or 2) - 1), type=partial(whole, minimum=1, maximum=256), metavar="N",
        help="processes at once (default: all cores but one)",
    )  # fmt: skip

"""The arguments of the commands `bench-tracker` and `bench-detection`."""

import argparse
import os
from functools import partial
from pathlib import Path

from radar_service.arguments import whole


def add_bench_tracker(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Adds the command."""
    parser = commands.add_parser("bench-tracker", help="test a tracker on scenarios, and write a report")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="names (see --list), or .toml files")
    parser.add_argument("--list", action="store_true", help="list the scenarios")
    parser.add_argument("--seeds", default=3, type=partial(whole, minimum=1, maximum=100_000), metavar="N", help="default 3")
    _add_jobs(parser)
    parser.add_argument(
        "--tracker", default="gnn",
        help='gnn or jpda (Stone Soup), module:callable, or a command that reads plots and writes tracks (default gnn)',
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


def _add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs", default=max(1, (os.cpu_count() or 2) - 1), type=partial(whole, minimum=1, maximum=256), metavar="N",
        help="processes at once (default: all cores but one)",
    )  # fmt: skip

"""The arguments of the command `bench-tracker`."""

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
    parser.add_argument(
        "--jobs", default=max(1, (os.cpu_count() or 2) - 1), type=partial(whole, minimum=1, maximum=256), metavar="N",
        help="processes at once (default: all cores but one)",
    )  # fmt: skip
    parser.add_argument(
        "--tracker", default="gnn",
        help='gnn or jpda, module:callable, ws://host:port, or a command that gets plots and gives tracks (default gnn)',
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=Path, help="folder for report.json, report.html and the runs; it may exist")
    parser.add_argument("--compare", nargs=2, type=Path, metavar="REPORT", help="print two report.json side by side")

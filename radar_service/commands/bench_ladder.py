"""The command `bench-ladder`: ranks trackers by scenarios of growing difficulty."""

import argparse
import sys
from functools import partial
from pathlib import Path

from radar_service.bench.ladder.climb import REFERENCE, climb, names_of
from radar_service.bench.ladder.ranking import seeds_needed
from radar_service.bench.ladder.report import text_of, write_ladders
from radar_service.bench.ladder.series import ladders, load_ladder
from radar_service.bench.trackers.trackers import is_built_in
from radar_service.commands.shared_options import add_jobs, workers_of
from radar_service.terminal import UsageError, add_whole_number, progress

SEEDS = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("ladders", nargs="*", metavar="LADDER", help="names (see --list), or .toml files (default: all)")
    parser.add_argument("--list", action="store_true", help="list the ladders")
    add_whole_number(parser, "--seeds", SEEDS, 2, 100_000, metavar="N", help=f"runs of each rung (default {SEEDS})")
    parser.add_argument("--plots", type=Path, metavar="DIR", help="keeps plots and truth (default: bench-plots beside -o)")
    add_jobs(parser)
    parser.add_argument(
        "--tracker", action="append", dest="trackers",
        help=f"as bench-tracker takes it; again for each other tracker (default jpda); {REFERENCE} takes part in any case",
    )  # fmt: skip
    parser.add_argument(
        "--name", action="append", dest="names", default=[], help="of each --tracker in the report, in order"
    )
    parser.add_argument("--open", action="store_true", help="tell programs scenario and seed, which then are 0 to N - 1")
    parser.add_argument("-o", "--out", type=Path, help="folder for report.json, report.html and the runs; it may exist")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status 0: a ladder ranks, and nothing fails.

    Raises UsageError, SceneError and OSError, and JobsFailed for a fault of the program or of the tracker.
    """
    if options.list:
        for name in ladders():
            print(f"{name}: {load_ladder(name).question}")
        return 0
    if options.out is None:
        raise UsageError("-o: name a folder for the report, or give --list")
    loaded = [load_ladder(name) for name in options.ladders or ladders()]
    trackers, shown = options.trackers or ["jpda"], partial(progress, unit="runs", name=lambda run: run.job.name)
    others = len(names_of(trackers, options.names)) - 1
    if options.seeds < (needed := seeds_needed(others)):
        print(f"too few seeds: {needed} are needed to tell {others + 1} trackers apart", file=sys.stderr, flush=True)
    blind = not options.open and not all(map(is_built_in, trackers))
    with workers_of(options) as (executor, _):
        report = climb(loaded, options.seeds, trackers, options.out, executor, shown, options.plots, options.names, blind)
    write_ladders(report, options.out)
    print(f"{text_of(report)}{options.out / 'report.html'}")
    return 0

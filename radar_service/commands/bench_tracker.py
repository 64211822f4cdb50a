"""The command `bench-tracker`: scenarios times seeds against a tracker, and a report."""

import argparse
import json
from functools import partial
from pathlib import Path

from radar_service.batch.jobs import JobsFailed, processes
from radar_service.bench.bench import bench
from radar_service.bench.report import comparison, verdict_table, write_report
from radar_service.bench.scenario import ScenarioError, load_scenario, load_scenarios, scenarios
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.commands.shared_options import add_jobs
from radar_service.terminal.arguments import UsageError, add_whole_number
from radar_service.terminal.progress import progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="names (see --list), or .toml files")
    parser.add_argument("--list", action="store_true", help="list the scenarios")
    add_whole_number(parser, "--seeds", 3, 1, 100_000, metavar="N", help="default 3")
    add_jobs(parser)
    parser.add_argument(
        "--tracker", default="gnn",
        help='gnn or jpda, module:callable, ws://host:port, or a command that gets plots and gives tracks (default gnn)',
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=Path, help="folder for report.json, report.html and the runs; it may exist")
    parser.add_argument("--compare", nargs=2, type=Path, metavar="REPORT", help="print two report.json side by side")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status: 1 where a limit that decides is missed.

    Raises UsageError, SceneError and OSError, and JobsFailed for a fault of the program or of the tracker.
    """
    try:
        return _bench(options)
    except (ScenarioError, TrackerError, JobsFailed, ImportError) as error:
        if isinstance(error, JobsFailed) and error.is_fault:
            raise
        raise UsageError(str(error)) from None


def _bench(options: argparse.Namespace) -> int:
    if options.list:
        for name in scenarios():
            print(f"{name}: {load_scenario(name).question}")
        return 0
    if options.compare:
        print(comparison(*(json.loads(path.read_text(encoding="utf-8")) for path in options.compare)), end="")
        return 0
    if not options.scenarios or options.out is None:
        raise TrackerError("SCENARIO and -o: name at least one scenario and a folder, or give --list")
    shown = partial(progress, unit="runs", name=lambda run: run.job.name)
    loaded = load_scenarios(options.scenarios)
    with processes(options.jobs) as executor:
        report, runs = bench(loaded, options.seeds, options.tracker, options.out, executor, shown)
    write_report(report, runs, options.out)
    print(verdict_table(report) + str(options.out / "report.html"))
    failed = any(verdict["word"] == "fail" for scenario in report["scenarios"] for verdict in scenario["verdicts"])
    return 1 if failed else 0

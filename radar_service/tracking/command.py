"""The command `bench-tracker`: scenarios times seeds against a tracker, and a report."""

import argparse
import json
import os
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from tqdm import tqdm

from radar_service.arguments import whole
from radar_service.tracking.bench import bench, runs_of
from radar_service.tracking.report import comparison, write_report
from radar_service.tracking.scenario import load_scenario, scenarios


def add_bench_tracker(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> argparse.ArgumentParser:
    """Adds the command to a parser; the caller sets what runs it."""
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
        help='gnn or jpda (Stone Soup), module:callable, or a command that reads plots and writes tracks (default gnn)',
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=Path, help="folder for report.json, report.html and the runs; it may exist")
    parser.add_argument("--compare", nargs=2, type=Path, metavar="REPORT", help="print two report.json side by side")
    return parser


def bench_tracker(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status: 1 where a limit that decides is missed. Raises ValueError and OSError."""
    if options.list:
        for name in scenarios():
            print(f"{name}: {load_scenario(name).question}")
        return 0
    if options.compare:
        print(comparison(*(json.loads(path.read_text(encoding="utf-8")) for path in options.compare)), end="")
        return 0
    if not options.scenarios or options.out is None:
        raise ValueError("SCENARIO and -o: name at least one scenario and a folder, or give --list")
    report = bench(options.scenarios, options.seeds, options.tracker, options.out, options.jobs, _progress)
    write_report(report, runs_of(options.scenarios, options.seeds, options.tracker, options.out), options.out)
    words = [(one["name"], verdict) for one in report["scenarios"] for verdict in one["verdicts"]]
    for name, verdict in words:
        print(f"{name}: {verdict['metric']}: {verdict['word']} ({verdict['failures']} of {verdict['runs']} runs miss it)")
    print(options.out / "report.html")
    return 1 if any(verdict["word"] == "fail" for _, verdict in words) else 0


def _progress(runs: Iterable[Any], count: int) -> Iterable[Any]:
    return tqdm(runs, total=count, unit="runs", disable=None)

"""The command `bench-tracker`: scenarios times seeds against a tracker, and a report."""

import argparse
import json
from collections.abc import Iterable
from typing import Any

from radar_service.bench.bench import bench, runs_of
from radar_service.bench.report import comparison, verdict_table, write_report
from radar_service.bench.scenario import load_scenario, load_scenarios, scenarios
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.terminal.progress import progress


def bench_tracker(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status: 1 where a limit that decides is missed. Raises ScenarioError,
    TrackerError, SceneError and OSError."""
    if options.list:
        for name in scenarios():
            print(f"{name}: {load_scenario(name).question}")
        return 0
    if options.compare:
        print(comparison(*(json.loads(path.read_text(encoding="utf-8")) for path in options.compare)), end="")
        return 0
    if not options.scenarios or options.out is None:
        raise TrackerError("SCENARIO and -o: name at least one scenario and a folder, or give --list")
    loaded = load_scenarios(options.scenarios)
    report = bench(loaded, options.seeds, options.tracker, options.out, options.jobs, _progress)
    write_report(report, runs_of(loaded, options.seeds, options.tracker, options.out), options.out)
    print(verdict_table(report) + str(options.out / "report.html"))
    failed = any(verdict["word"] == "fail" for one in report["scenarios"] for verdict in one["verdicts"])
    return 1 if failed else 0


def _progress(runs: Iterable[Any], count: int) -> Iterable[Any]:
    return progress(runs, count, "runs", lambda run: f"{run['scenario']}, seed {run['seed']}")

"""The command `bench-tracker`: scenarios times seeds against a tracker, and a report."""

import argparse
import json
from collections.abc import Iterable
from typing import Any

from tqdm import tqdm

from radar_service.tracking.bench import bench, runs_of
from radar_service.tracking.json_lines import TrackerError
from radar_service.tracking.report import comparison, write_report
from radar_service.tracking.scenario import load_scenario, load_scenarios, scenarios


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
    words = [(one["name"], verdict) for one in report["scenarios"] for verdict in one["verdicts"]]
    for name, verdict in words:
        print(f"{name}: {verdict['metric']}: {verdict['word']} ({verdict['failures']} of {verdict['runs']} runs miss it)")
    print(options.out / "report.html")
    return 1 if any(verdict["word"] == "fail" for _, verdict in words) else 0


def _progress(runs: Iterable[Any], count: int) -> Iterable[Any]:
    bar: Iterable[Any] = tqdm(runs, total=count, unit="runs", disable=None)
    return bar

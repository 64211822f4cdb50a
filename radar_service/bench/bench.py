"""The test bench of trackers: scenarios times seeds in parallel processes, each run kept in a file, one report in the end.

Where the power of an extended target lies, not at her reference point, is measured here: no tracker can
know the one from the other.
"""

import warnings
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.batch.jobs import Executor, Job, Progress, ResultFolder
from radar_service.batch.jobs import run as run_jobs
from radar_service.bench.ppi_picture import ppi_of
from radar_service.bench.run import run
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.plot_scores import plot_metrics
from radar_service.bench.scores.scoring import ScanResult, TargetTruth, scores
from radar_service.bench.scores.verdicts import verdict
from radar_service.bench.trackers.json_lines import LineTracker
from radar_service.bench.trackers.trackers import program_digest, tracker_for
from radar_service.numerics.arithmetic import arithmetic
from radar_service.plots.flood import FloodWarning, flood_remark
from radar_service.scans.scan import Scan

CROSSINGS = 5  # on each side of a crossing; the centroid of a single one jumps (glint), and no tracker can follow that
SCHEMA = 2
FIRST_SEED = 0  # the one that the report draws
Runs = Mapping[str, Sequence[Mapping[str, Any]]]  # as plain data, by name of the scenario


def at_power_centroids(results: Sequence[ScanResult]) -> list[ScanResult]:
    """Returns a run whose extended targets stand at the mean centroid of their power, in the hull's frame.

    The mean is over the crossings of up to CROSSINGS scans before and after. A point stays where it is, and so does a target
    without power in all of these scans.
    """
    moved = []
    for number, result in enumerate(results):
        near = results[max(0, number - CROSSINGS) : number + CROSSINGS + 1]
        moved.append(replace(result, truths=tuple(_moved(truth, near) for truth in result.truths)))
    return moved


def _moved(truth: TargetTruth, near: Sequence[ScanResult]) -> TargetTruth:
    """A target at the mean of its centroids in these scans, with her heading of this one."""
    offsets = [
        truth_then.centroid
        for result in near
        for truth_then in result.truths
        if truth_then.body == truth.body and truth_then.centroid
    ]
    if not offsets:
        return truth
    along, across = np.mean(offsets, axis=0).tolist()
    sine, cosine = np.sin(truth.heading), np.cos(truth.heading)
    east, north = truth.position
    return replace(
        truth, position=(float(east + along * sine + across * cosine), float(north + along * cosine - across * sine))
    )


def single_run(scenario: Scenario, seed: int, tracker_name: str) -> dict[str, Any]:
    """Returns one run as plain data: its metrics, and what each scan gave. Raises what its parts raise."""
    made_of = _same_for_all(tracker_name) | {"digest": scenario.digest}
    tracker = tracker_for(tracker_name, scenario, {"scenario": scenario.name, "seed": seed, "schema": SCHEMA})
    latest = deque[Scan](maxlen=1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FloodWarning)  # the report has a remark
            results = at_power_centroids(list(run(scenario, seed, tracker, latest.append)))
    finally:
        if isinstance(tracker, LineTracker):
            tracker.close()
    return {
        **made_of, "scenario": scenario.name, "seed": seed,
        "metrics": {**scores(results), **plot_metrics(results)},
        "remark": flood_remark([result.flood for result in results if result.flood], len(results)),
        "scans": [_scan_data(result) for result in results],
        "ppi": ppi_of(latest[0]) if seed == FIRST_SEED else None,
    }  # fmt: skip


def _scan_data(result: ScanResult) -> dict[str, Any]:
    return {
        "scan": result.given.scan, "time": result.given.time, "own": [result.given.east, result.given.north],
        "plots": [[plot.east, plot.north] for plot in result.given.plots],
        "tracks": [asdict(track) for track in result.tracks], "truths": [asdict(truth) for truth in result.truths],
    }  # fmt: skip


def bench(
    scenarios: Sequence[Scenario], seeds: int, tracker: str, folder: Path, executor: Executor | None = None,
    progress: Progress = lambda outcomes, count: outcomes,
) -> tuple[dict[str, Any], Runs]:  # fmt: skip
    """Runs scenarios with seeds 0 to `seeds` - 1; returns the report and all runs. Those whose file is in `folder` are not made
    again.

    scenarios: of different names; executor, progress: as `batch.jobs.run`. Raises JobsFailed, TrackerError and OSError.
    """
    kept, same = ResultFolder(folder / "runs"), _same_for_all(tracker)
    jobs = [
        Job(f"{scenario.name}, seed {seed}, {tracker}", (scenario, seed, tracker), same | {"digest": scenario.digest})
        for scenario in scenarios
        for seed in range(seeds)
    ]
    results = iter(run_jobs(single_run, jobs, executor, kept, progress))
    runs = {scenario.name: [next(results) for _ in range(seeds)] for scenario in scenarios}
    return report({scenario.name: scenario for scenario in scenarios}, runs, tracker), runs


def _same_for_all(tracker: str) -> dict[str, Any]:
    """What all runs of a tracker are made of."""
    return {"schema": SCHEMA, "tracker": tracker, "program": program_digest(tracker), "arithmetic": arithmetic()}


def report(loaded: Mapping[str, Scenario], runs: Runs, tracker: str) -> dict[str, Any]:
    """Returns the report of runs by scenario, as plain data."""
    return {
        "schema": SCHEMA, "tracker": tracker,
        "scenarios": [_summary(loaded[name], some) for name, some in runs.items()],
    }  # fmt: skip


def _summary(scenario: Scenario, runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    names = list(dict.fromkeys(name for run in runs for name in run["metrics"]))
    values = {name: [run["metrics"].get(name) for run in runs] for name in names}
    return {
        "name": scenario.name, "question": scenario.question, "expected": scenario.expected, "source": scenario.source,
        "seeds": [run["seed"] for run in runs], "remark": next((run["remark"] for run in runs if run["remark"]), None),
        "metrics": {name: _mean(some) for name, some in values.items()},
        "percentile_95": {name: _percentile(some) for name, some in values.items()},
        "verdicts": [verdict(limit, values.get(limit.metric, [None] * len(runs))).as_dict() for limit in scenario.limit],
    }  # fmt: skip


def _mean(values: Sequence[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return float(np.mean(numbers)) if numbers else None


def _percentile(values: Sequence[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return float(np.percentile(numbers, 95.0)) if numbers else None

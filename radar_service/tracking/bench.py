"""The test bench of trackers: scenarios times seeds in parallel processes, each run kept in a file, one report in the end."""

import importlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.constants import KNOT
from radar_service.parallel import BLAS_LIMIT
from radar_service.tracking.plot_scores import plot_metrics
from radar_service.tracking.power_centroids import at_power_centroids
from radar_service.tracking.process_tracker import ProcessTracker, TrackerError
from radar_service.tracking.run import run
from radar_service.tracking.scenario import Scenario, load_scenario
from radar_service.tracking.scoring import ScanResult, scores
from radar_service.tracking.stone_soup import StoneSoupTracker, Tuning
from radar_service.tracking.tracker import Tracker
from radar_service.tracking.verdicts import verdict

SCHEMA = 1
Progress = Callable[[Iterable[Any], int], Iterable[Any]]
REFERENCE = ("gnn", "jpda")  # names of the reference tracker's associations


def tracker_for(name: str, scenario: Scenario, seed: int) -> Tracker:
    """Returns a new tracker: "gnn" or "jpda", the reference; "module:callable", which returns one; or a command, which gets
    plots and answers tracks as JSON Lines. Raises TrackerError and ImportError."""
    if name in REFERENCE:
        return StoneSoupTracker(tuning_of(scenario, name))
    if name.count(":") == 1 and " " not in name and "/" not in name:
        module, _, attribute = name.partition(":")
        try:
            made: Tracker = getattr(importlib.import_module(module), attribute)()
        except (ImportError, AttributeError) as error:
            raise TrackerError(f"tracker: {name} could not be imported: {error}") from None
        return made
    return ProcessTracker(name, {"scenario": scenario.name, "seed": seed, "schema": SCHEMA})


def tuning_of(scenario: Scenario, association: str) -> Tuning:
    """Returns the tuning that a scenario gives the reference tracker."""
    settings = scenario.tracker
    return Tuning(
        association="jpda" if association == "jpda" else "gnn", range_error=settings.range_error_m,
        bearing_error=float(np.radians(settings.bearing_error_deg)), acceleration=settings.acceleration,
        speed_error=settings.speed_error_kn * KNOT, detection=settings.detection, clutter=settings.clutter_per_m2,
    )  # fmt: skip


def single_run(scenario_name: str, seed: int, tracker_name: str) -> dict[str, Any]:
    """Returns one run as plain data: its metrics, and what each scan gave. Raises what its parts raise."""
    scenario = load_scenario(scenario_name)
    tracker = tracker_for(tracker_name, scenario, seed)
    try:
        with BLAS_LIMIT.held():
            results = at_power_centroids(list(run(scenario, seed, tracker)))
    finally:
        if isinstance(tracker, ProcessTracker):
            tracker.close()
    return {
        "scenario": scenario.name, "digest": scenario.digest, "seed": seed, "tracker": tracker_name,
        "metrics": {**scores(results), **plot_metrics(results)},
        "scans": [_scan_data(result) for result in results],
    }  # fmt: skip


def _scan_data(result: ScanResult) -> dict[str, Any]:
    return {
        "scan": result.given.scan, "time": result.given.time, "own": [result.given.east, result.given.north],
        "plots": [[plot.east, plot.north] for plot in result.given.plots],
        "tracks": [asdict(track) for track in result.tracks], "truths": [asdict(truth) for truth in result.truths],
    }  # fmt: skip


def bench(
    names: Sequence[str],
    seeds: int,
    tracker: str,
    folder: Path,
    jobs: int,
    progress: Progress = lambda runs, count: runs,
) -> dict[str, Any]:
    """Runs scenarios with seeds 0 to `seeds` - 1, and returns the report. Runs whose file is in `folder` are not made again.

    jobs: processes at once; progress: wraps the runs that are left, of which it gets the number.
    Raises ScenarioError, TrackerError, SceneError and OSError.
    """
    loaded = {(one := load_scenario(name)).name: one for name in names}
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    orders = [(name, seed) for name in names for seed in range(seeds)]
    left = [order for order in orders if not _is_kept(folder, load_scenario(order[0]), order[1], tracker)]
    for data in progress(_made(left, tracker, jobs), len(left)):
        _write(_file(folder, data["scenario"], data["seed"], tracker), data)
    return report(loaded, runs_of(names, seeds, tracker, folder), tracker)


def runs_of(names: Sequence[str], seeds: int, tracker: str, folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Returns the runs in a folder, by name of the scenario. Raises OSError where one is missing."""
    loaded = [load_scenario(name) for name in names]
    return {one.name: [_read(_file(folder, one.name, seed, tracker)) for seed in range(seeds)] for one in loaded}


def report(loaded: Mapping[str, Scenario], runs: Mapping[str, Sequence[Mapping[str, Any]]], tracker: str) -> dict[str, Any]:
    """Returns the report of runs by scenario, as plain data."""
    return {
        "schema": SCHEMA, "tracker": tracker,
        "scenarios": [_summary(loaded[name], some) for name, some in runs.items()],
    }  # fmt: skip


def _summary(scenario: Scenario, runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    names = list(dict.fromkeys(name for one in runs for name in one["metrics"]))
    values = {name: [one["metrics"].get(name) for one in runs] for name in names}
    return {
        "name": scenario.name, "question": scenario.question, "expected": scenario.expected, "source": scenario.source,
        "seeds": [one["seed"] for one in runs], "metrics": {name: _mean(some) for name, some in values.items()},
        "percentile_95": {name: _percentile(some) for name, some in values.items()},
        "verdicts": [verdict(limit, values.get(limit.metric, [None] * len(runs))).as_dict() for limit in scenario.limit],
    }  # fmt: skip


def _mean(values: Sequence[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return float(np.mean(numbers)) if numbers else None


def _percentile(values: Sequence[float | None]) -> float | None:
    numbers = [value for value in values if value is not None]
    return float(np.percentile(numbers, 95.0)) if numbers else None


def _made(orders: Sequence[tuple[str, int]], tracker: str, jobs: int) -> Iterator[dict[str, Any]]:
    """The runs as they end, from `jobs` processes, or from this one."""
    if jobs == 1 or len(orders) <= 1:
        yield from (single_run(name, seed, tracker) for name, seed in orders)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(single_run, name, seed, tracker) for name, seed in orders]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _file(folder: Path, scenario: str, seed: int, tracker: str) -> Path:
    plain = "".join(c if c.isalnum() or c in "-_" else "-" for c in f"{scenario}-{tracker}")
    return folder / "runs" / f"{plain}-{seed}.json"


def _is_kept(folder: Path, scenario: Scenario, seed: int, tracker: str) -> bool:
    """Whether an earlier command made this run with the same scenario, and its file is whole."""
    try:
        kept = _read(_file(folder, scenario.name, seed, tracker))
        return bool(kept["digest"] == scenario.digest and kept["tracker"] == tracker)
    except (OSError, ValueError, KeyError):
        return False


def _read(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def _write(path: Path, data: Mapping[str, Any]) -> None:
    """Writes a file as a whole or not at all."""
    part = path.with_suffix(".part")
    part.write_text(json.dumps(data, allow_nan=False), encoding="utf-8")
    os.replace(part, path)

"""The test bench of trackers: scenarios times seeds in parallel processes, each run kept in a file, one report in the end.

Where the power of an extended target lies, not at her reference point, is measured here: no tracker can
know the one from the other.
"""

import hashlib
import json
import os
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from radar_service.bench.ppi_picture import ppi_of
from radar_service.bench.run import run
from radar_service.bench.scenario import Scenario
from radar_service.bench.scores.plot_scores import plot_metrics
from radar_service.bench.scores.scoring import ScanResult, TargetTruth, scores
from radar_service.bench.scores.verdicts import verdict
from radar_service.bench.trackers.json_lines import LineTracker
from radar_service.bench.trackers.trackers import program_digest, tracker_for
from radar_service.numerics.arithmetic import arithmetic
from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.plots.flood import FloodWarning, flood_remark
from radar_service.scans.scan import Scan
from radar_service.terminal.output_files import make_folder

CROSSINGS = 5  # on each side of a crossing; the centroid of a single one jumps (glint), and no tracker can follow that
SCHEMA = 2
FIRST_SEED = 0  # the one that the report draws
MAX_NAME = 100  # characters of a run's file: a command may be longer than file systems take
Progress = Callable[[Iterable[Any], int], Iterable[Any]]


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
    offsets = [one.centroid for result in near for one in result.truths if one.body == truth.body and one.centroid]
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
    program = program_digest(tracker_name)
    tracker = tracker_for(tracker_name, scenario, {"scenario": scenario.name, "seed": seed, "schema": SCHEMA})
    latest = deque[Scan](maxlen=1)
    try:
        with BLAS_LIMIT.held(), warnings.catch_warnings():
            warnings.simplefilter("ignore", FloodWarning)  # the report has a remark
            results = at_power_centroids(list(run(scenario, seed, tracker, latest.append)))
    finally:
        if isinstance(tracker, LineTracker):
            tracker.close()
    return {
        "schema": SCHEMA, "scenario": scenario.name, "digest": scenario.digest, "seed": seed, "tracker": tracker_name,
        "program": program, "arithmetic": arithmetic(),
        "metrics": {**scores(results), **plot_metrics(results)},
        "remark": flood_remark([one.flood for one in results if one.flood], len(results)),
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
    scenarios: Sequence[Scenario],
    seeds: int,
    tracker: str,
    folder: Path,
    jobs: int,
    progress: Progress = lambda runs, count: runs,
) -> dict[str, Any]:
    """Runs scenarios with seeds 0 to `seeds` - 1, and returns the report. Runs whose file is in `folder` are not made again.

    scenarios: of different names; jobs: processes at once; progress: wraps the runs that are left, of which it gets the number.
    Raises TrackerError, SceneError and OSError.
    """
    make_folder(folder / "runs")
    program = program_digest(tracker)
    orders = [(scenario, seed) for scenario in scenarios for seed in range(seeds)]
    left = [(scenario, seed) for scenario, seed in orders if not _is_kept(folder, scenario, seed, tracker, program)]
    for data in progress(_made(left, tracker, jobs), len(left)):
        _write(_file(folder, data["scenario"], data["seed"], tracker), data)
    return report({one.name: one for one in scenarios}, runs_of(scenarios, seeds, tracker, folder), tracker)


def runs_of(scenarios: Sequence[Scenario], seeds: int, tracker: str, folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Returns the runs in a folder, by name of the scenario. Raises OSError where one is missing."""
    return {one.name: [_read(_file(folder, one.name, seed, tracker)) for seed in range(seeds)] for one in scenarios}


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
        "seeds": [one["seed"] for one in runs], "remark": next((one["remark"] for one in runs if one["remark"]), None),
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


def _made(orders: Sequence[tuple[Scenario, int]], tracker: str, jobs: int) -> Iterator[dict[str, Any]]:
    """The runs as they end, from `jobs` processes, or from this one."""
    if jobs == 1 or len(orders) <= 1:
        yield from (single_run(scenario, seed, tracker) for scenario, seed in orders)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(single_run, scenario, seed, tracker) for scenario, seed in orders]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _file(folder: Path, scenario: str, seed: int, tracker: str) -> Path:
    plain = "".join(c if c.isalnum() or c in "-_" else "-" for c in f"{scenario}-{tracker}")[:MAX_NAME]
    whole = hashlib.blake2b(f"{scenario} {tracker}".encode(), digest_size=4).hexdigest()
    return folder / "runs" / f"{plain}-{whole}-{seed}.json"


def _is_kept(folder: Path, scenario: Scenario, seed: int, tracker: str, program: str) -> bool:
    """Whether an earlier command made this run with the same scenario, program and arithmetic, and its file is whole."""
    made_of = {
        "schema": SCHEMA,
        "digest": scenario.digest,
        "tracker": tracker,
        "program": program,
        "arithmetic": arithmetic(),
    }
    try:
        kept = _read(_file(folder, scenario.name, seed, tracker))
        return {name: kept[name] for name in made_of} == made_of
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _read(path: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def _write(path: Path, data: Mapping[str, Any]) -> None:
    """Writes a file as a whole or not at all."""
    part = path.with_suffix(".part")
    part.write_text(json.dumps(data, allow_nan=False), encoding="utf-8")
    os.replace(part, path)

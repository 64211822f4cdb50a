"""Trackers on ladders: the same plots for all of them, each run kept in a file, one report in the end."""

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from radar_service.batch.jobs import Executor, Progress
from radar_service.bench.bench import (
    OWED,
    KeptRuns,
    Runs,
    jobs_of,
    nothing_is_owed,
    own_files,
    plots_folder,
    runs_of,
    sealed_of,
)
from radar_service.bench.blind import Blind, blind_for
from radar_service.bench.kept_plots import program_version
from radar_service.bench.ladder.ranking import LEVEL, interval, leaderboard, p_value, told_apart
from radar_service.bench.ladder.series import Ladder
from radar_service.bench.scenario import Scenario, ScenarioError
from radar_service.bench.single_run import scored_run
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.trackers import is_built_in
from radar_service.numerics import Floats

REFERENCE = "gnn"
SCHEMA = 1
TRIED = 3  # scans that each tracker answers before the first run


def climb(
    ladders: Sequence[Ladder], seeds: int, trackers: Sequence[str], folder: Path, executor: Executor | None = None,
    progress: Progress = lambda outcomes, count: outcomes, plots: Path | None = None, names: Sequence[str] = (),
    blind: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Runs trackers, each tried first, and REFERENCE on each rung of ladders, and returns the report as plain data.

    names: as of `names_of`; blind: whether programs are told no seeds, which then are salted. Others as in `bench`. Raises
    ScenarioError, JobsFailed, TrackerError and OSError.
    """
    its_name = names_of(trackers, names)
    if len({ladder.name for ladder in ladders}) < len(ladders):
        raise ScenarioError("ladders: two have the same name; give each ladder once, and each file a name of its own")
    rungs = [rung for ladder in ladders for rung in ladder.rungs]
    files = [*own_files(rungs), *(ladder.file for ladder in ladders if ladder.file)]
    hidden = blind_for(plots_folder(folder, plots), folder, files=files) if blind else None
    shared, kept = plots_folder(folder, plots), KeptRuns(folder / "runs")
    with TemporaryDirectory() as short:
        for tracker in its_name:
            if any(kept.read(job) is None for job in jobs_of(rungs, range(seeds), tracker, shared, hidden)):
                _try(tracker, rungs[0], Path(short), hidden)
    runs: dict[str, Runs] = {}
    for tracker, name in its_name.items():
        runs[name] = runs_of(scored_run, rungs, seeds, tracker, folder, executor, progress, plots, hidden)
        check_length(ladders, runs[name])
    return report(ladders, runs)


def names_of(trackers: Sequence[str], names: Sequence[str] = ()) -> dict[str, str]:
    """Returns what REFERENCE, the first one, and trackers are called: as `names` say, or without the words with which all begin
    that are no reference trackers. Raises ScenarioError where names are too few, too many or the same."""
    own = [*dict.fromkeys(tracker for tracker in trackers if tracker != REFERENCE)]
    if names and not len({*names} - {REFERENCE}) == len(names) == len(own):
        raise ScenarioError(
            f"--name: {', '.join(names)}: each of {len(own)} --tracker needs a name of its own, none {REFERENCE}"
        )
    others = [tracker for tracker in own if not is_built_in(tracker)]
    begin = os.path.commonprefix(others) if len(others) > 1 else ""
    shared = len(begin) - len(re.split(r"[\s:/=]", begin)[-1])
    short = [tracker[shared:] if tracker in others else tracker for tracker in own]
    distinct = own if len({REFERENCE, *short}) <= len(own) else short
    return {REFERENCE: REFERENCE, **dict(zip(own, names or distinct, strict=True))}


def _try(tracker: str, rung: Scenario, plots: Path, blind: Blind | None) -> None:
    """Lets a tracker answer the first scans of a rung. Raises TrackerError where it fails."""
    short = rung.model_copy(update={"scans": TRIED})
    failure = scored_run(short, 0, tracker, plots, sealed_of(tracker, blind))["failure"]
    if failure:
        raise TrackerError(f"{failure['message']}{f' ({last})' if (last := failure['stderr']) else ''}; no run is made")


def check_length(ladders: Sequence[Ladder], runs: Runs) -> None:
    """Raises ScenarioError for a rung whose runs end before any target is owed a state, so that nothing is to be compared."""
    for ladder in ladders:
        for rung in ladder.rungs:
            none = all(run["metrics"].get(ladder.metric) is None for run in runs[rung.name])
            if none and nothing_is_owed(runs[rung.name]):
                raise ScenarioError(f"{rung.name}: scans: {rung.scans} give no {ladder.metric}: {OWED}")


def report(ladders: Sequence[Ladder], runs: Mapping[str, Runs]) -> dict[str, Any]:
    """Returns the report of the runs of each tracker by rung, as plain data. Raises ScenarioError where no run of a ladder has
    its metric."""
    for ladder in ladders:
        known = sorted(
            {name for some in runs.values() for rung in ladder.rungs for run in some[rung.name] for name in run["metrics"]}
        )
        if known and ladder.metric not in known:
            raise ScenarioError(f"{ladder.name}: metric: {ladder.metric!r} is none of a run; there are {', '.join(known)}")
    losses = {ladder.name: {tracker: losses_of(ladder, some) for tracker, some in runs.items()} for ladder in ladders}
    overall = {
        tracker: np.mean([losses[ladder.name][tracker].mean(axis=0) / ladder.worst for ladder in ladders], axis=0)
        for tracker in runs
    }
    return {
        "schema": SCHEMA, "version": program_version(), "level": LEVEL, "seeds": len(next(iter(overall.values()))),
        **leaderboard(overall, REFERENCE), "ladders": [_ladder(ladder, losses[ladder.name], runs) for ladder in ladders],
    }  # fmt: skip


def losses_of(ladder: Ladder, runs: Runs) -> Floats:
    """Returns the metric of a ladder (rungs, seeds): `worst` where a run has none or a larger one."""
    values = [[run["metrics"].get(ladder.metric) for run in runs[rung.name]] for rung in ladder.rungs]
    return np.fmin(np.array(values, dtype=np.float64), ladder.worst)  # of nan, which None is, and a number it is the number


def _ladder(ladder: Ladder, losses: Mapping[str, Floats], runs: Mapping[str, Runs]) -> dict[str, Any]:
    means = {tracker: values.mean(axis=0) for tracker, values in losses.items()}
    shown = {"name", "question", "expected", "source", "difficulty", "values", "metric", "worst"}
    return {
        **ladder.model_dump(include=shown), **leaderboard(means, REFERENCE),
        "trackers": [
            {
                "tracker": tracker, "rungs": _rungs(values, losses[REFERENCE]),
                "failed_runs": sum(run["failure"] is not None for rung in ladder.rungs for run in runs[tracker][rung.name]),
            }
            for tracker, values in losses.items()
        ],
    }  # fmt: skip


def _rungs(losses: Floats, reference: Floats) -> list[dict[str, Any]]:
    """The figure of a tracker on each rung, and whether it is better or worse than the reference there."""
    p_values = [p_value(each) for each in losses - reference]
    rows = []
    for values, others, p, is_apart in zip(losses, reference, p_values, told_apart(p_values), strict=True):
        mean, low, high = interval(values)
        word = ("better" if mean < others.mean() else "worse") if is_apart else None
        rows.append({"mean": mean, "low": low, "high": high, "p": p, "word": word})
    return rows

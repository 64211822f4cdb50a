"""The test bench of trackers: scenarios times seeds in parallel processes, each run kept in a file, one report in the end."""

import hashlib
import json
import random
import shlex
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import sem
from typing_extensions import override

from radar_service.batch.jobs import Executor, Job, Outcome, Progress, ResultFolder, outcomes
from radar_service.batch.jobs import run as run_jobs
from radar_service.bench.blind import Blind, blind_for
from radar_service.bench.diagnosis import failed_runs
from radar_service.bench.kept_plots import (
    bench_digest,
    keep_plots,
    named_files,
    plots_digest,
    plots_path,
    program_version,
    source_digest,
)
from radar_service.bench.scenario import PROFILES, Limit, Scenario
from radar_service.bench.scores.sightings import ACQUISITION
from radar_service.bench.scores.verdicts import Verdict, boundaries, verdict
from radar_service.bench.single_run import SCHEMA, header_of, same_for_all, single_run
from radar_service.bench.trackers.json_lines import LineTracker, TrackerError
from radar_service.bench.trackers.process_tracker import end_waiting
from radar_service.bench.trackers.trackers import is_program, tracker_for
from radar_service.bench.trackers.websocket_tracker import SCHEMES
from radar_service.numerics import arithmetic
from radar_service.plan.plan import plan_for
from radar_service.scene_file import load_scene
from radar_service.simulation.engine_set_up import chosen_fidelity

TOGETHER, FEWEST = 25, 8  # runs whose plots are made together, at most and at least
FEWER = 3  # times fewer runs of scenarios in clutter in a smoke test
HALF_TURN = 0.5  # of the antenna, beyond which a tracker is told to be slow
MAX_HANGS = 3  # of one tracker, each of which takes a minute
MAX_NOT_STARTED = 3  # before the first run that starts
OWED = f"a state is owed from {ACQUISITION:g} s after a target is seen first; give more scans, best for three minutes"
Runs = Mapping[str, Sequence[Mapping[str, Any]]]  # as plain data, by name of the scenario


def bench(
    scenarios: Sequence[Scenario], seeds: int, tracker: str, folder: Path, executor: Executor | None = None,
    progress: Progress = lambda outcomes, count: outcomes, plots: Path | None = None, smoke: bool = False,
    blind: bool = False, salt: str | None = None, looks: tuple[int, ...] = (),
) -> tuple[dict[str, Any], Runs]:  # fmt: skip
    """Runs scenarios with seeds 0 to `seeds` - 1, or as many salted ones where the runs are blind; returns the report and all
    runs. Those whose file is in `folder` are not made again, but for failed ones.

    scenarios: of different names; executor, progress: as `batch.jobs.run`; plots: the folder that keeps plots and truth for all
    trackers, `bench-plots` beside the other one by default; smoke: whether gross misses alone fail; salt: of an earlier report,
    for its seeds; looks: numbers of runs after which a scenario ends that has failed, or whose limits are all decided. Raises
    JobsFailed, OSError, and TrackerError for a tracker that does not start, or that hangs again and again.
    """
    hidden = blind_for(plots_folder(folder, plots), folder, salt, own_files(scenarios)) if blind else None
    runs: dict[str, list[Mapping[str, Any]]] = {scenario.name: [] for scenario in scenarios}
    waiting, done, counts = list(scenarios), 0, Counter[str]()
    costly = [scenario.name for scenario in scenarios if scenario.in_clutter]
    for look in [*(look for look in looks if look < seeds), seeds]:
        fresh = runs_of(
            single_run, waiting, look, tracker, folder, executor, progress, plots, hidden, done, counts, costly if smoke else ()
        )  # fmt: skip
        for name, some in fresh.items():
            runs[name] += some
        waiting, done = [each for each in waiting if not _ends(each, runs[each.name], looks)], look
    return report({scenario.name: scenario for scenario in scenarios}, runs, tracker, smoke, hidden, looks), runs


def own_files(scenarios: Iterable[Scenario]) -> Iterator[Path]:
    """Yields the files of scenarios that are not packaged, and those that they name: they tell the truth."""
    for scenario in scenarios:
        if scenario.file:
            yield from (scenario.file, *named_files([scenario.scene, scenario.recorded], scenario.folder).values())


def _ends(scenario: Scenario, runs: Sequence[Mapping[str, Any]], looks: tuple[int, ...]) -> bool:
    """Whether a scenario needs no more runs."""
    words = {each.word for each in _verdicts(scenario, runs, False, looks) if each.decides}
    return "fail" in words or (bool(words) and "undecided" not in words)


def runs_of(
    run: Callable[..., dict[str, Any]], scenarios: Sequence[Scenario], seeds: int, tracker: str, folder: Path,
    executor: Executor | None, progress: Progress, plots: Path | None, blind: Blind | None = None, first: int = 0,
    counts: Counter[str] | None = None, costly: Collection[str] = (),
) -> Runs:  # fmt: skip
    """Returns the runs of scenarios by name, from number `first` on. run: makes one, as `single_run`; blind: how runs are kept
    from the tracker, which then come in any order; counts: of what earlier runs were; costly: scenarios with a third of the
    runs, which come first in open runs; others, and what it raises, as `bench`."""
    counts = Counter() if counts is None else counts
    scenarios = sorted(scenarios, key=lambda scenario: scenario.name not in costly)
    numbers = {each.name: range(first, -(-seeds // FEWER) if each.name in costly else seeds) for each in scenarios}
    shared = plots_folder(folder, plots)
    jobs = {each.name: jobs_of([each], numbers[each.name], tracker, shared, blind) for each in scenarios}
    kept = KeptRuns(folder / "runs", [*jobs] if first else ())
    order = [job for some in jobs.values() for job in some]
    together = [*_together(order, kept)]
    order = random.sample(order, len(order)) if blind else order

    def watched(outcomes: Iterable[Outcome], count: int) -> Iterator[Outcome]:
        if count and not counts:  # before the first run that is made
            check_start(tracker, scenarios[0], blind)
            counts["checked"] += 1
        return _watched(progress(outcomes, count), counts)

    for _ in watched(outcomes(keep_plots, together, executor, None), len(together)):
        pass  # a run without plots makes its own, or tells why there are none

    try:
        results = run_jobs(run, order, executor, kept, watched)
    finally:
        end_waiting()
    result_of = dict(zip([job.name for job in order], results, strict=True))
    return {name: [result_of[job.name] for job in some] for name, some in jobs.items()}


def _together(jobs: Iterable[Job], kept: ResultFolder) -> Iterator[Job]:
    """Jobs that keep the plots of TOGETHER runs of a scenario each, of those that are to be made and have none."""
    fresh: dict[str, list[Job]] = {}
    for job in jobs:
        scenario, seed, _, plots, sealed = job.arguments
        if sealed != () and not plots_path(plots, scenario, seed).exists() and kept.read(job) is None:
            fresh.setdefault(scenario.name, []).append(job)
    for some in fresh.values():
        for first in range(0, len(some) - FEWEST + 1, TOGETHER):
            (scenario, *_, plots, _), those = some[first].arguments, some[first : first + TOGETHER]
            yield Job(f"plots of {those[0].name}", (plots, scenario, [job.arguments[1] for job in those]))


def plots_folder(folder: Path, plots: Path | None) -> Path:
    """Returns the folder of plots for runs in another one: the given one, or `bench-plots` beside that."""
    return (plots or folder.parent / "bench-plots").absolute()


def jobs_of(
    scenarios: Sequence[Scenario], numbers: range, tracker: str, plots: Path, blind: Blind | None = None
) -> list[Job]:
    """Returns the runs that are to be made or read. Names of blind ones, which files have, tell no seed."""
    same, word, sealed = same_for_all(tracker), "run" if blind else "seed", sealed_of(tracker, blind)
    return [
        Job(
            f"{scenario.name}, {word} {number}, {tracker}",
            (scenario, seed := blind.seed(scenario.name, number) if blind else number, tracker, plots, sealed),
            same | {"digest": scenario.digest, "seed": seed},
        )
        for scenario in scenarios
        for number in numbers
    ]


def sealed_of(tracker: str, blind: Blind | None) -> tuple[str, ...] | None:
    """Returns the folders that a tracker cannot read: none of a server, which runs elsewhere; None for an open run."""
    return (() if tracker.startswith(SCHEMES) else blind.sealed) if blind else None


def check_start(tracker: str, scenario: Scenario, blind: Blind | None) -> None:
    """Starts and ends a tracker, so that a wrong name is told before any run. Raises TrackerError and ImportError."""
    in_each_run = scenario.input == "video" or tracker.startswith(SCHEMES)  # a header with video is made with its service
    if not (is_program(tracker) and in_each_run):
        started = tracker_for(tracker, header_of(scenario, None if blind else 0), sealed_of(tracker, blind))
        if isinstance(started, LineTracker):
            started.close()


class KeptRuns(ResultFolder):
    """A ResultFolder that keeps no failed run: another try may end otherwise. Of those that miss no limit of a scenario, the
    first alone keeps its scans."""

    def __init__(self, folder: Path, passed: Iterable[str] = ()) -> None:
        """folder: as of a ResultFolder; passed: scenarios that had a first one. Raises OSError."""
        super().__init__(folder)
        self._passed = {*passed}

    @override
    def write(self, job: Job, result: Any) -> Any:
        if result["failure"]:
            return json.loads(json.dumps(result))
        if not job.arguments[0].missed(result["metrics"]):
            result = {**result, "scans": result["scans"] if result["scenario"] not in self._passed else []}
            self._passed.add(result["scenario"])
        return super().write(job, result)


def _watched(outcomes: Iterable[Outcome], counts: Counter[str]) -> Iterator[Outcome]:
    """Raises TrackerError where a tracker hangs too often, or does not start. counts: of all looks so far."""
    for outcome in outcomes:
        yield outcome
        if not outcome.result:
            continue
        failure = outcome.result["failure"] or {"scan": 0, "hangs": False}
        counts["hangs"] += failure["hangs"]
        counts["started" if failure["scan"] is not None else "missing"] += 1
        if counts["hangs"] == MAX_HANGS:
            raise TrackerError(f"{failure['message']}; {MAX_HANGS} runs hung, so the bench stops, at {outcome.job.name}")
        if counts["missing"] == MAX_NOT_STARTED and not counts["started"]:
            raise TrackerError(failure["message"])


def report(
    loaded: Mapping[str, Scenario], runs: Runs, tracker: str, smoke: bool = False, blind: Blind | None = None,
    looks: tuple[int, ...] = (),
) -> dict[str, Any]:  # fmt: skip
    """Returns the report of runs by scenario, as plain data. blind: how they were kept from the tracker; looks: after which
    runs may have ended. Raises TrackerError where no run has started."""
    failures = [run["failure"] for some in runs.values() for run in some]
    if failures and all(failure and failure["scan"] is None for failure in failures):
        raise TrackerError(failures[0]["message"])
    return {
        "schema": SCHEMA, "version": program_version(), "tracker": tracker, "smoke": smoke,
        "looks": [*map(list, boundaries(looks))],
        "sheet": _sheet(loaded, runs, tracker, blind, " --smoke" if smoke else " --fixed" * (not looks)),
        "blind": blind and {"salt": blind.salt, "sealed": bool(sealed_of(tracker, blind))},
        "scenarios": [_summary(loaded[name], some, smoke, looks) for name, some in runs.items()],
    }  # fmt: skip


def _sheet(loaded: Mapping[str, Scenario], runs: Runs, tracker: str, blind: Blind | None, how: str) -> dict[str, str]:
    """What a verdict may be used for, what it rests on, and how anybody makes it again."""
    plots = [plots_digest(loaded[name], run["seed"]) for name, some in runs.items() for run in some]
    names = shlex.join(str(scenario.file or name) for name, scenario in loaded.items())
    seeds = (f"--salt {blind.salt}" if blind else "--open") + how
    profiles = [name for name, errors in PROFILES.items() if all(each.plot_errors == errors for each in loaded.values())]
    return {
        "use": "To compare trackers and find their faults before trials at sea: it is not a type approval, not IEC 62388.",
        "physics": "docs/believed.md: "
        + "; ".join(dict.fromkeys(line for each in loaded.values() for line in _believed(each))),
        "version": f"{program_version()}, source {source_digest()}, bench {bench_digest()}, arithmetic {arithmetic()}",
        "scenarios": ", ".join(f"{name} {scenario.digest}" for name, scenario in loaded.items()),
        "plots": hashlib.blake2b("".join(plots).encode(), digest_size=16).hexdigest(),
        "uncertainty": "`lower`, `upper` of a share of misses (95 %, one-sided, by fixed runs), `standard_error` of a mean.",
        "again": f"radar-service bench-tracker {names} --seeds {max(map(len, runs.values()), default=0)} {seeds} "
        f"{_input(next(iter(loaded.values()), None))}"
        f"{''.join(f'--profile {name} ' for name in profiles)}--tracker {shlex.quote(tracker)} -o again",
    }


def _input(scenario: Scenario | None) -> str:
    """The options of a command for what a program reads and answers, the same in all scenarios."""
    if scenario is None or scenario.input == "plots":
        return ""
    serve = f"--serve={shlex.quote(shlex.join(scenario.serve))} " if scenario.serve else ""
    return f"--input video --answers {scenario.answers} {serve}"


def _believed(scenario: Scenario) -> Sequence[str]:
    """What of a scenario's physics was held against published figures, as its plan says; nothing of a recorded one."""
    if scenario.recorded:
        return ()
    scene = load_scene(scenario.scene, folder=scenario.folder).for_radar(scenario.radar)
    return plan_for(scene, chosen_fidelity(scene, scenario.fidelity)).believed


def _summary(scenario: Scenario, runs: Sequence[Mapping[str, Any]], smoke: bool, looks: tuple[int, ...]) -> dict[str, Any]:
    names = list(dict.fromkeys(name for run in runs for name in run["metrics"]))
    values = {name: [run["metrics"].get(name) for run in runs] for name in names}
    return {
        "name": scenario.name, "question": scenario.question, "expected": scenario.expected, "source": scenario.source,
        "seeds": [run["seed"] for run in runs], "remark": _remark(scenario, runs),
        "failed_runs": failed_runs(scenario, runs),
        "failures": [{"seed": run["seed"], **run["failure"]} for run in runs if run["failure"]],
        "metrics": {name: _of(np.mean, some) for name, some in values.items()},
        "standard_error": {name: _of(sem, some, 2) for name, some in values.items()},
        "percentile_95": {name: _of(partial(np.percentile, q=95.0), some) for name, some in values.items()},
        "verdicts": [*map(asdict, _verdicts(scenario, runs, smoke, looks))],
    }  # fmt: skip


def _verdicts(scenario: Scenario, runs: Sequence[Mapping[str, Any]], smoke: bool, looks: tuple[int, ...]) -> list[Verdict]:
    """The verdicts on all limits that runs judge."""
    limits = [(limit, judged) for limit in scenario.limits if (judged := _judged(limit, runs))]
    return [verdict(limit, judged, smoke, looks) for limit, judged in limits]


def nothing_is_owed(runs: Sequence[Mapping[str, Any]]) -> bool:
    """Returns whether no run in which the tracker went on to the end owes a state of any target."""
    ended = [run["metrics"] for run in runs if not run["failure"]]
    return bool(ended) and all(metrics.get("completeness", 1.0) is None for metrics in ended)


def _remark(scenario: Scenario, runs: Sequence[Mapping[str, Any]]) -> str | None:
    """What is to be known of the plots, or of a scenario of which nothing can be judged."""
    remarks = [run["remark"] for run in runs if run["remark"]][:1]
    if scenario.judges == "tracks" and nothing_is_owed(runs):
        remarks.append(f"{scenario.scans} scans judge no tracker: {OWED}")
    slow = [run["seed"] for run in runs if (run["metrics"].get("answer_turns") or 0.0) > HALF_TURN]
    if slow:
        remarks.append(f"5 % of answers take more than half a turn in {len(slow)} runs, first in seed {slow[0]}")
    return "; ".join(remarks) or None


def _judged(limit: Limit, runs: Sequence[Mapping[str, Any]]) -> list[float | None]:
    """The values that a limit judges: of a run that cannot judge the metric None, or none, as the limit says. A failed run
    misses every limit."""
    return [
        run["metrics"].get(limit.metric)
        for run in runs
        if run["failure"] or limit.metric in run["metrics"] or not limit.where_judged
    ]


def _of(statistic: Callable[[Sequence[float]], Any], values: Sequence[float | None], least: int = 1) -> float | None:
    """A statistic of the values that there are; None where these are fewer than the least."""
    numbers = [value for value in values if value is not None]
    return float(statistic(numbers)) if len(numbers) >= least else None

"""Writes which scenarios catch which lying trackers, and which limits good trackers miss, as a table in Markdown.

    nice python -m tests.measurements.liars FOLDER_OF_PLOTS TABLE [SEEDS [SCENARIO...]]

A scenario catches a liar where it misses, in one seed or more, a limit that decides and that the good tracker under it keeps
in this seed. An hour for all scenarios that judge tracks, and half of it for their plots, which the folder keeps.
"""

import itertools
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from radar_service.bench.kept_plots import ObservedRun, observed_run
from radar_service.bench.run import answered, check_times
from radar_service.bench.scenario import Scenario, load_scenario, scenarios
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.scoring import metrics_of
from radar_service.bench.single_run import data_sheet
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import Tracker
from radar_service.bench.trackers.trackers import tracker_for
from tests.bench import dishonest_trackers as dishonest
from tests.bench import known_trackers as known

MANY = 20  # targets, which take so long that only who follows few of them lies there
Missed = Mapping[str, float | None]
GOOD: dict[str, Callable[[Scenario, ObservedRun], Tracker]] = {
    "IMM": lambda scenario, _: ReckonedTracker(known.Imm(data_sheet(scenario))),
    "truth": lambda _, run: known.Truth(run.results),
    "gnn": lambda scenario, _: tracker_for("gnn", {"radar": vars(data_sheet(scenario))}),
    "jpda": lambda scenario, _: tracker_for("jpda", {"radar": vars(data_sheet(scenario))}),
}


def all_of(tracker: Tracker, run: ObservedRun) -> list[ScanResult] | None:
    """Returns what a tracker answers to each scan; None where it fails."""
    try:
        return list(answered(run.results, tracker))
    except (TrackerError, IndexError):
        return None


def lied(lie: dishonest.Lie, honest: Sequence[ScanResult]) -> list[ScanResult] | None:
    """Returns what a lie makes of the answers of the good tracker."""
    past = [result.tracks for result in honest]
    results = [replace(r, tracks=tuple(lie(past[: k + 1], r.given))) for k, r in enumerate(honest)]
    try:
        for result in results:
            check_times(result.tracks, result.given)
    except TrackerError:
        return None
    return results


def missed(scenario: Scenario, run: ObservedRun, results: Sequence[ScanResult] | None) -> Missed:
    """Returns the limits that decide and that are missed: all by a tracker that fails."""
    return {"fails": None} if results is None else scenario.missed(metrics_of(results, run.around))


def judged(scenario: Scenario, run: ObservedRun) -> tuple[dict[str, Missed], dict[str, Missed]]:
    """Returns what the good trackers miss in a run, and what the liars miss that the honest one under them keeps."""
    answers = {name: all_of(make(scenario, run), run) for name, make in GOOD.items()}
    good = {name: missed(scenario, run, results) for name, results in answers.items()}
    honest = answers["IMM"] or []
    liars = {name: missed(scenario, run, lied(lie, honest)) for name, lie in dishonest.LIES.items()}
    for kind in dishonest.OF_IMM if len(scenario.tracked) < MANY else [known.FewTracks]:
        liars[kind.__name__] = missed(scenario, run, all_of(ReckonedTracker(kind(data_sheet(scenario))), run))
    return good, {name: {key: v for key, v in some.items() if key not in good["IMM"]} for name, some in liars.items()}


def table(good: Mapping[str, Mapping[str, Missed]], caught: Mapping[str, Mapping[str, Missed]]) -> str:
    """Returns the table. good, caught: by tracker, then by scenario and seed."""
    lines = ["| tracker | misses |", "|---|---|"]
    for name, runs in good.items():
        words = [
            f"{run}: {', '.join(f'{key} {value if value is None else round(value, 3)}' for key, value in some.items())}"
            for run, some in runs.items() if some
        ]  # fmt: skip
        lines.append(f"| {name} | {'; '.join(words) or 'nothing'} |")
    lines += [
        "",
        f"{len(caught)} liars, {len({run.rpartition(' ')[0] for run in good['IMM']})} scenarios",
        "",
        "| liar | scenarios | limits | not by |",
        "|---|---|---|---|",
    ]
    for name, runs in sorted(caught.items(), key=lambda each: len(scenarios_of(each[1], True))):
        by, others = scenarios_of(runs, True), scenarios_of(runs, False)
        limits = sorted(
            {key for some in runs.values() for key in some}, key=lambda k: -sum(k in some for some in runs.values())
        )
        shown = ", ".join(others if len(others) <= len(by) else by)
        lines.append(
            f"| {name} | {len(by)} | {', '.join(limits[:3])} | {'' if len(others) <= len(by) else 'only by '}{shown} |"
        )
    return "\n".join(lines) + "\n"


def scenarios_of(runs: Mapping[str, Missed], is_caught: bool) -> list[str]:
    """Returns the scenarios that catch a liar, or those that do not."""
    names = {run.rpartition(" ")[0] for run in runs}
    caught = {run.rpartition(" ")[0] for run, some in runs.items() if some}
    return sorted(caught if is_caught else names - caught)


def main(folder: Path, path: Path, seeds: int = 1, *names: str) -> None:
    """Judges all, run by run, and writes the table after each. Runs in the file beside the table are not made again."""
    kept = path.with_suffix(".json")
    good, caught = json.loads(kept.read_text()) if kept.is_file() else ({}, {})
    chosen = [name for name in names or scenarios() if names or not name.startswith("real/")]
    loaded = [scenario for scenario in map(load_scenario, chosen) if scenario.judges == "tracks"]
    judging = [scenario for scenario in loaded if any(limit.decides for limit in scenario.limits)]
    for scenario, seed in itertools.product(judging, range(seeds)):
        if f"{scenario.name} {seed}" not in good.get("IMM", {}):
            run = observed_run(folder, scenario, seed)
            for into, found in zip((good, caught), judged(scenario, run), strict=True):
                for name, some in found.items():
                    into.setdefault(name, {})[f"{scenario.name} {seed}"] = some
            kept.write_text(json.dumps((good, caught)), encoding="utf-8")
            path.write_text(table(good, caught), encoding="utf-8")
            print(scenario.name, seed, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int((sys.argv[3:4] or ["1"])[0]), *sys.argv[4:])

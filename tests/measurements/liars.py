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

import numpy as np

from radar_service.bench.kept_plots import ObservedRun, observed_run
from radar_service.bench.run import answered, check_times
from radar_service.bench.scenario import Scenario, load_scenario, scenarios
from radar_service.bench.scores.scan_result import ScanResult
from radar_service.bench.scores.scoring import metrics_of
from radar_service.bench.single_run import data_sheet
from radar_service.bench.trackers.json_lines import TrackerError
from radar_service.bench.trackers.reckoning import ReckonedTracker
from radar_service.bench.trackers.tracker import Tracker, TrackerInput, TrackState
from radar_service.bench.trackers.trackers import tracker_for
from tests.bench import known_trackers as known
from tests.bench.known_trackers import (
    WRONG,
    Lie,
    Past,
    again,
    at_scans,
    each,
    ghost,
    more,
    moving,
    named,
    only,
    placed,
    polar,
    range_of,
    speed_of,
    with_velocity,
)

MANY = 20  # targets, which take so long that only who follows few of them lies there
Missed = Mapping[str, float | None]
GOOD: dict[str, Callable[[Scenario, ObservedRun], Tracker]] = {
    "IMM": lambda scenario, _: ReckonedTracker(known.Imm(data_sheet(scenario))),
    "truth": lambda _, run: known.Truth(run.results),
    "gnn": lambda scenario, _: tracker_for("gnn", {"radar": vars(data_sheet(scenario))}),
    "jpda": lambda scenario, _: tracker_for("jpda", {"radar": vars(data_sheet(scenario))}),
}


def turning(angle: float) -> Lie:
    """Turns velocities by an angle [degrees]."""
    turn = np.exp(-1j * np.radians(angle))
    return each(lambda s, _: with_velocity(s, complex(s.velocity_east, s.velocity_north) * turn))


def rounded(courses: float, speeds: float) -> Lie:
    """Rounds courses [degrees] and speeds [m/s]."""

    def change(s: TrackState, _: TrackerInput) -> TrackState:
        speed, course = np.hypot(s.velocity_east, s.velocity_north), np.arctan2(s.velocity_east, s.velocity_north)
        speed = np.round(speed / speeds) * speeds if speeds else speed
        course = np.round(np.degrees(course) / courses) * np.radians(courses) if courses else course
        return with_velocity(s, complex(speed * np.sin(course), speed * np.cos(course)))

    return each(change)


def grid(step: float) -> Lie:
    """Rounds positions [m]."""
    return placed(lambda p: complex(np.round(p.real / step) * step, np.round(p.imag / step) * step))


def of_scans_ago(scans: int, renewed: bool) -> Lie:
    """Answers of scans ago; `renewed` says that they are of now."""

    def lie(past: Past, scan: TrackerInput) -> Sequence[TrackState]:
        old = past[-1 - scans] if len(past) > scans else []
        return [replace(s, time=scan.time) for s in old] if renewed else old

    return lie


def frozen(every: int) -> Lie:
    """Gives one answer several times, as if it were new."""
    return lambda past, scan: [replace(s, time=scan.time) for s in past[(len(past) - 1) // every * every]]


def wavering(size: float, of_velocity: bool) -> Lie:
    """Adds a number between -size and size [m] or [m/s], another one in each scan."""

    def change(s: TrackState, scan: TrackerInput) -> TrackState:
        east = size * np.sin(12.9898 * scan.scan + 78.233 * len(s.track))
        return replace(s, velocity_east=s.velocity_east + east) if of_velocity else replace(s, east=s.east + east)

    return each(change)


def swapped(past: Past) -> Sequence[TrackState]:
    """Gives each track the name of the next one."""
    names = [s.track for s in past[-1]]
    return [replace(s, track=name) for s, name in zip(past[-1], names[1:] + names[:1], strict=True)]


LIES: dict[str, Lie] = {
    "half of the speed": moving(scale=0.5),
    "0.8 of the speed": moving(scale=0.8),
    "1.25 of the speed": moving(scale=1.25),
    "twice the speed": moving(scale=2.0),
    "velocities reversed": moving(scale=-1.0),
    "a current of 2 m/s": moving(east=2.0),
    "a current of 1.2 m/s to the north": moving(north=1.2),
    "courses turned by 15 degrees": turning(15.0),
    "courses turned by 45 degrees": turning(45.0),
    "courses turned by 90 degrees": turning(90.0),
    "courses of whole 45 degrees": rounded(45.0, 0.0),
    "speeds of whole 5 m/s": rounded(0.0, 5.0),
    "ships of one speed": rounded(0.0, 25.0),
    "velocities that waver by 4 m/s": wavering(4.0, True),
    "velocities that waver by 8 m/s": wavering(8.0, True),
    "positions that waver by 40 m": wavering(40.0, False),
    "positions that waver by 80 m": wavering(80.0, False),
    "velocity reversed in one scan of eight": at_scans(lambda k: k % 8 == 0, moving(scale=-1.0)),
    "no velocity in one scan of four": at_scans(lambda k: k % 4 == 0, moving(scale=0.0)),
    "no velocity after 60 scans": at_scans(lambda k: k > 60, moving(scale=0.0)),
    "no velocity for the first 50 scans": at_scans(lambda k: k < 50, moving(scale=0.0)),
    "ranges 40 m too long": polar(longer=40.0),
    "ranges 60 m too short": polar(longer=-60.0),
    "bearings one degree too large": polar(turned=1.0),
    "bearings 2 degrees too small": polar(turned=-2.0),
    "bearings 20 degrees too large": polar(turned=20.0),
    "east and west exchanged": placed(lambda p: complex(-p.real, p.imag)),
    "east and north exchanged": placed(lambda p: complex(p.imag, p.real)),
    "ranges 5 % too long": placed(lambda p: 1.05 * p),
    "positions of whole 100 m": grid(100.0),
    "positions of whole 200 m": grid(200.0),
    "positions 30 m to the east": placed(lambda p: p + 30.0),
    "positions 250 m to the north": placed(lambda p: p + 250j),
    "one scan of three": at_scans(lambda k: k % 3 > 0, only(lambda s, _: False)),
    "nothing in one scan of three": at_scans(lambda k: k % 3 == 0, only(lambda s, _: False)),
    "nothing in one scan of ten": at_scans(lambda k: k % 10 == 0, only(lambda s, _: False)),
    "nothing in scans 30 to 45": at_scans(lambda k: 30 <= k < 45, only(lambda s, _: False)),
    "nothing after scan 45": at_scans(lambda k: k >= 45, only(lambda s, _: False)),
    "nothing before scan 40": at_scans(lambda k: k < 40, only(lambda s, _: False)),
    "one track": lambda past, _: past[-1][:1],
    "all tracks but the first": lambda past, _: past[-1][1:],
    "the nearest track": lambda past, scan: sorted(past[-1], key=lambda s: range_of(s, scan))[:1],
    "tracks nearer than 1500 m": only(lambda s, scan: range_of(s, scan) < 1500.0),
    "tracks farther than 1800 m": only(lambda s, scan: range_of(s, scan) > 1800.0),
    "tracks slower than 10 knots": only(lambda s, _: speed_of(s) < 5.1),
    "tracks faster than 10 knots": only(lambda s, _: speed_of(s) > 5.1),
    "tracks to the east": only(lambda s, scan: s.east > scan.east),
    "tracks that go to the east": only(lambda s, _: s.velocity_east > 0.0),
    "answers one scan old, as if new": of_scans_ago(1, True),
    "answers two scans old, as if new": of_scans_ago(2, True),
    "answers of six scans ago": of_scans_ago(6, False),
    "each fourth answer, as if new": frozen(4),
    "each twelfth answer, as if new": frozen(12),
    "names by the minute": named(lambda s, scan: f"{s.track} {scan.time // 60}"),
    "names by place": named(lambda s, scan: f"{s.east // 500} {s.north // 500} {s.track}"),
    "names by course": named(lambda s, _: f"{s.track} {s.velocity_east > 0.0} {s.velocity_north > 0.0}"),
    "names swapped from scan 50": at_scans(lambda k: k >= 50, lambda past, _: swapped(past)),
    "names swapped in scan 45": at_scans(lambda k: k == 45, lambda past, _: swapped(past)),
    "names swapped in turns": at_scans(lambda k: k % 2 == 0, lambda past, _: swapped(past)),
    "a ghost with a new name each scan": more(lambda _, scan: [ghost(f"ghost {scan.scan}", 3e3, 3e3, scan)]),
    "a ghost in one scan of fifteen": more(lambda _, scan: [ghost("ghost", 0.0, -2500.0, scan)] * (scan.scan % 15 == 0)),
    "a ghost that passes": more(lambda _, scan: [ghost("ghost", 8.0 * scan.time - 1e3, -1800.0, scan, 8.0)]),
    "ten ghosts": more(lambda _, scan: [ghost(f"ghost {k}", 300.0 * k - 1500.0, -1500.0, scan) for k in range(10)]),
    "a mirror image of each track": more(
        lambda past, scan: [replace(s, track=f"{s.track} mirrored", east=2.0 * scan.east - s.east) for s in past[-1]]
    ),
    "each track once more 150 m off": more(lambda past, _: again(past, 150.0)),
    "each track once more 600 m off": more(lambda past, _: again(past, 600.0)),
    "each track once more after scan 50": at_scans(lambda k: k > 50, more(lambda past, _: again(past, 5.0))),
    "each track once more in one scan of five": at_scans(lambda k: k % 5 == 0, more(lambda past, _: again(past, 5.0))),
}  # fmt: skip


def all_of(tracker: Tracker, run: ObservedRun) -> list[ScanResult] | None:
    """Returns what a tracker answers to each scan; None where it fails."""
    try:
        return list(answered(run.results, tracker))
    except (TrackerError, IndexError):
        return None


def lied(lie: Lie, honest: Sequence[ScanResult]) -> list[ScanResult] | None:
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
    liars = {name: missed(scenario, run, lied(lie, honest)) for name, lie in LIES.items()}
    for name in WRONG if len(scenario.tracked) < MANY else ["FewTracks"]:
        liars[name] = missed(scenario, run, all_of(ReckonedTracker(WRONG[name](data_sheet(scenario))), run))
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

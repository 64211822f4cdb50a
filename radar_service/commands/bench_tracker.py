"""The command `bench-tracker`: tests a tracker on scenarios, and writes a report."""

import argparse
import json
import shlex
import signal
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from radar_service.bench import Scenario, load_scenario, scenarios
from radar_service.bench.bench import Runs, bench, plots_folder
from radar_service.bench.bench import report as report_of
from radar_service.bench.diagnosis import drawn_run, failed_runs, scans_of_interest
from radar_service.bench.junit import write_junit
from radar_service.bench.report import comparison, plot_table, summary_table, verdict_table, write_report
from radar_service.bench.run import simulator_of
from radar_service.bench.scenario import PROFILES, load_scenarios, with_profile, with_video
from radar_service.bench.scores.verdicts import LOOKS, MISSES, RUNS, SHARE, SMOKE_RUNS, boundaries, chance_to_pass
from radar_service.bench.single_run import single_run
from radar_service.bench.trackers.trackers import is_built_in, is_program
from radar_service.bench.video import program_on_video
from radar_service.commands.record import RADAR, record_scans
from radar_service.commands.shared_options import add_jobs, workers_of
from radar_service.processes.stop_signals import TERMINATED, ended_by_signals
from radar_service.terminal import UsageError, add_whole_number, make_folder, progress

UNDECIDED = 3  # exit status
RECORDED = 3  # failed runs of a scenario


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="names (see --list), or .toml files")
    parser.add_argument("--list", action="store_true", help="list the scenarios")
    add_whole_number(parser, "--seeds", SMOKE_RUNS, 1, 100_000, metavar="N", help=f"default 3; {RUNS} decide")
    add_whole_number(
        parser, "--seed", None, 0, 2**53, metavar="SEED", help="only this one, open: without --seeds, --salt and --jobs"
    )
    parser.add_argument("--fixed", action="store_true", help="make all runs before the verdicts, in place of looks")
    parser.add_argument("--smoke", action="store_true", help="only gross misses fail; a third of them in clutter")
    parser.add_argument("--open", action="store_true", help="tell a program scenario and seed, which then are 0 to N - 1")
    parser.add_argument("--salt", metavar="SALT", help="of an earlier report: its seeds")
    parser.add_argument("--input", choices=["plots", "video"], default="plots", help="what a program reads (default plots)")
    parser.add_argument(
        "--answers", choices=["tracks", "ttm", "plots"], default="tracks",
        help="to video: ttm of an unmodified program, plots of an extractor",
    )  # fmt: skip
    parser.add_argument("--serve", default="", metavar="OPTIONS", help="of the service of the video: further ports")
    parser.add_argument("--profile", choices=sorted(PROFILES), help="plots err as those of a real set do")
    parser.add_argument("--strict", action="store_true", help="an undecided limit fails")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="write the verdicts as JUnit XML too")
    parser.add_argument(
        "--record", action="store_true", help=f"record the {RECORDED} worst failed runs of each scenario (MCAP)"
    )
    parser.add_argument("--plots", type=Path, metavar="DIR", help="keeps plots and truth (default: bench-plots beside -o)")
    add_jobs(parser)
    parser.add_argument(
        "--tracker", default="gnn",
        help="gnn, jpda, one of an installed package, module:callable, ws://host:port, or a command: plots in, tracks out"
        " (default gnn)",
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=Path, help="folder for report.json, report.html and the runs; it may exist")
    parser.add_argument("--compare", nargs=2, type=Path, metavar="REPORT", help="print two report.json side by side")


def run(options: argparse.Namespace) -> int:
    """Runs the command, with a progress bar on a terminal; returns the exit status: 1 where a limit that decides is missed, and
    UNDECIDED where the runs are too few.

    Raises UsageError, SceneError and OSError, and JobsFailed for a fault of the program or of the tracker.
    """
    with ended_by_signals([signal.SIGTERM], TERMINATED):
        return _bench(options)


def _bench(options: argparse.Namespace) -> int:
    if options.list:
        for name in scenarios():
            print(f"{name}: {load_scenario(name).question}")
        return 0
    if options.compare:
        print(comparison(*(json.loads(path.read_text(encoding="utf-8")) for path in options.compare)), end="")
        return 0
    if not options.scenarios or options.out is None:
        raise UsageError("SCENARIO and -o: name at least one scenario and a folder, or give --list")
    if options.record:
        from radar_service.recording.recording_file import RecordingFile  # noqa: F401  # an extra that is missing is told first
    shown = partial(progress, unit="runs", name=lambda run: run.job.name)
    loaded = load_scenarios(options.scenarios)
    if options.profile:
        loaded = [with_profile(scenario, options.profile) for scenario in loaded]
    of_plots = options.answers == "plots"
    if options.input != "video" and (options.serve or options.answers != "tracks"):
        raise UsageError("--answers and --serve: they are of the video; give --input video too")
    if options.answers == "ttm" and not is_program(options.tracker):
        raise UsageError("--answers ttm: give --tracker with the command of a program that writes TTM")
    if of_plots and not is_program(options.tracker):
        options.tracker = program_on_video()
    if options.input == "video":
        loaded = [with_video(scenario, options.answers, shlex.split(options.serve)) for scenario in loaded]
    looks = () if options.smoke or options.fixed or options.seeds < LOOKS[0] else LOOKS
    if options.seed is None:
        print(_plan(options.seeds, options.smoke, looks))
    if options.junit:
        options.junit.unlink(missing_ok=True)  # an older one would stand for what was not judged
    if options.seed is not None:
        make_folder(options.out)
        plots = plots_folder(options.out, options.plots)
        runs: Runs = {each.name: [single_run(each, options.seed, options.tracker, plots)] for each in loaded}
        report = report_of({each.name: each for each in loaded}, runs, options.tracker, options.smoke)
        report["sheet"]["again"] += f" --seed {options.seed}"
    else:
        with workers_of(options) as (executor, _):
            report, runs = bench(
                loaded, options.seeds, options.tracker, options.out, executor, shown, options.plots, options.smoke,
                bool(options.salt) or not (options.open or is_built_in(options.tracker)), options.salt, looks,
            )  # fmt: skip
    drawn = {
        scenario.name: drawn_run(scenario, some)
        for scenario in loaded
        if failed_runs(scenario, some := runs[scenario.name]) or not options.smoke
    }
    write_report(report, drawn, options.out)
    if options.junit:
        write_junit(report, options.junit, options.strict)
    print(plot_table(report) if of_plots else summary_table(report))
    print(f"{verdict_table(report)}" + str(options.out / "report.html"))
    for scenario in loaded if options.record else ():
        numbers = {run["seed"]: number for number, run in enumerate(runs[scenario.name])}
        _record(scenario, failed_runs(scenario, runs[scenario.name]), numbers, options.out)
    return _status(report, options.strict)


def _record(scenario: Scenario, failed: Sequence[Mapping[str, Any]], numbers: Mapping[int, int], folder: Path) -> None:
    """Records the worst failed runs about their gravest events, and says how they are replayed. numbers: by seed, for names of
    files, which tell no salted seed."""
    from radar_service.recording.radar_recording import RadarRecording
    from radar_service.recording.recording_file import RecordingFile

    for run in failed[:RECORDED]:
        scans, path = scans_of_interest(scenario, run), folder / f"{scenario.name}-seed-{numbers[run['seed']]}.mcap"
        simulator = simulator_of(scenario, run["seed"])
        simulator.skip_to(scans.start)
        with RecordingFile(path) as file:
            recording = RadarRecording(file, RADAR, with_truth=True)
            record_scans(recording, simulator, scenario.scene_for(run["seed"]), len(scans), with_truth=True)
        print(f"scans {scans.start} to {scans.stop - 1}: radar-service replay {path}")


def _plan(seeds: int, smoke: bool, looks: tuple[int, ...]) -> str:
    """What the runs can show, said before the first one."""
    if smoke:
        return f"{seeds} seeds of each scenario: gross misses fail; a third of them in clutter"
    if looks:
        steps = "; ".join(f"{runs}: {most if most >= 0 else '-'}/{least}" for runs, most, least in boundaries(looks))
        chances = ", ".join(f"{share:.1%} {chance_to_pass(looks, share):.4f}" for share in (0.01, 0.02, 0.025, SHARE))
        return (
            f"looks after so many runs, with misses to pass/to fail: {steps}\nchance to pass by share of misses: {chances}"
        )
    can = "pass or fail" if seeds >= RUNS else f"fail, but {RUNS} are needed to pass"
    return f"{seeds} seeds of each scenario can {can}; {MISSES} misses of {RUNS} are allowed"


def _status(report: Mapping[str, Any], strict: bool) -> int:
    words = {verdict["word"] for scenario in report["scenarios"] for verdict in scenario["verdicts"]}
    if "fail" in words or (strict and "undecided" in words):
        return 1
    return UNDECIDED if "undecided" in words else 0

"""The command line: serve, scan, record, replay, check, plan, ... Only this module may import all others.

Commands import what they need when they run: `serve` leaves the simulator to other processes, and so starts soon.
"""

import argparse
import contextlib
import errno
import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from radar_service.commands.command_line import DEFAULT_SCENE, parser
from radar_service.recording.error import RecordingError
from radar_service.terminal.arguments import UsageError
from radar_service.terminal.extras import MissingExtra
from radar_service.terminal.output_files import make_folder
from radar_service.world.error import SceneError

if TYPE_CHECKING:
    from radar_service.commands.simulator_options import SimulatorOptions

PIPE_CLOSED = 141  # exit status, 128 + SIGPIPE, as shells report programs that a closed pipe ends


def simulator_options(options: argparse.Namespace, threads: int = 1) -> "SimulatorOptions":
    """Returns what the options say about simulators."""
    from radar_service.commands.simulator_options import SimulatorOptions

    return SimulatorOptions(options.fidelity, options.error_db, options.seed, threads)


def run_serve(options: argparse.Namespace) -> int:
    """Serves until stopped."""
    from radar_service.commands.serve import StartError, serve
    from radar_service.ports.registry import opened

    _check_sources(options, "labels", "powers")
    options.scenes = options.scenes or [DEFAULT_SCENE]
    try:
        return serve(options, simulator_options(options, options.threads), opened)
    except StartError as error:
        raise UsageError(str(error)) from None


def run_record(options: argparse.Namespace) -> int:
    """Computes scans into a recording, with a progress bar on a terminal."""
    from radar_service.commands.record import record

    _check_sources(options, "labels", "powers")
    return record(options, simulator_options(options, options.threads))


def run_replay(options: argparse.Namespace) -> int:
    """Serves a recording until its end."""
    if not options.recording.is_file():  # said first: an extra that is missing does not help here
        raise FileNotFoundError(errno.ENOENT, "there is no such file; give a recording", str(options.recording))
    from radar_service.commands.replay import replay
    from radar_service.commands.serve import StartError
    from radar_service.ports.registry import REPLAY_PORTS, opened

    try:
        return replay(options, partial(opened, names=REPLAY_PORTS))
    except StartError as error:
        raise UsageError(str(error)) from None


def run_scan(options: argparse.Namespace) -> int:
    """Computes scans, with a progress bar on a terminal."""
    from radar_service.commands.scan import SourcesError, scan

    _check_sources(options, "labels", "powers", "radiometric")
    if options.radiometric and not options.truth:
        raise UsageError("--radiometric: it needs the file of --truth; add --truth FILE.jsonl, or leave --radiometric out")
    try:
        return scan(options, simulator_options(options, options.threads))
    except SourcesError as error:
        raise UsageError(str(error)) from None


def _check_sources(options: argparse.Namespace, *names: str) -> None:
    """Raises UsageError for an option that the fidelity has nothing for."""
    for name in names:
        if getattr(options, name) and options.fidelity == "documented":
            raise UsageError(f"--{name}: the fidelity documented has none; choose another fidelity, or leave --{name} out")


def run_check(options: argparse.Namespace) -> int:
    """Prints what a scene contains."""
    from radar_service.plan.budget import ErrorBudget
    from radar_service.plan.remarks import body_remarks
    from radar_service.plan.settings_search import fidelity_for
    from radar_service.scene_file.describe import describe, overview
    from radar_service.scene_file.load import load_scene

    scene = load_scene(options.scene).for_radar(options.radar)
    remarks = body_remarks(scene, fidelity_for(scene, ErrorBudget()))
    print(describe(scene, remarks) if options.all else overview(scene, remarks))
    return 0


def run_plan(options: argparse.Namespace) -> int:
    """Prints what is modelled, at what error and cost."""
    from radar_service.plan.realtime import plan_in_time
    from radar_service.scene_file.load import load_scene
    from radar_service.simulator import Simulator

    scene = load_scene(options.scene).for_radar(options.radar)
    if options.realtime_factor is None:
        plan = simulator_options(options)(scene).plan
    elif options.fidelity != "auto":
        raise UsageError(f"--realtime-factor: needs --fidelity auto, not {options.fidelity}; remove one of them")
    else:
        plan = plan_in_time(
            scene, options.realtime_factor, lambda fidelity: Simulator(scene, fidelity, options.seed).plan, options.error_db
        )
    print(json.dumps(plan.as_dict(), indent=2) if options.json else plan)
    return 0


def run_stability(options: argparse.Namespace) -> int:
    """Finds where methods fail, with a progress bar on a terminal."""
    from tqdm import tqdm

    from radar_service.study.stability import STUDIES
    from radar_service.study.stability.report import write_report

    make_folder(options.out)
    findings = [study(options.fine) for study in tqdm(STUDIES, unit="regions", disable=None)]
    write_report(options.out, findings)
    print(f"{options.out / 'stability.html'}: {len(findings)} regions")
    return 0


def run_chart(options: argparse.Namespace) -> int:
    """Measures all methods on a scene, with progress bars on a terminal."""
    from radar_service.scene_file.load import load_scene
    from radar_service.study.chart import chart
    from radar_service.study.chart.summary import summary_text

    make_folder(options.out)
    effort = chart.QUICK if options.quick else chart.FULL
    data = chart.write_chart(chart.measure(load_scene(options.scene), options.seed, effort, progress=True), options.out)
    print(summary_text(data["summary"]), end="")
    return 0


def run_bench_tracker(options: argparse.Namespace) -> int:
    """Tests a tracker, with a progress bar on a terminal."""
    from radar_service.bench.scenario import ScenarioError
    from radar_service.bench.trackers.json_lines import TrackerError
    from radar_service.commands.bench_tracker import bench_tracker

    try:
        return bench_tracker(options)
    except (ScenarioError, TrackerError, ImportError) as error:
        raise UsageError(str(error)) from None


def run_plots(options: argparse.Namespace) -> int:
    """Extracts plots, and tells what each is of."""
    from radar_service.commands.plots import plots

    if options.fidelity == "documented":
        raise UsageError("--fidelity: documented has no labels; choose another fidelity")
    try:
        return plots(options, replace(simulator_options(options, options.threads), labels=True))
    except ValueError as error:
        raise UsageError(str(error)) from None


def run_bench_detection(options: argparse.Namespace) -> int:
    """Compares detection with the radar equation, with a progress bar on a terminal."""
    from radar_service.bench.scenario import ScenarioError
    from radar_service.commands.bench_detection import bench_detection

    try:
        return bench_detection(options)
    except ScenarioError as error:
        raise UsageError(str(error)) from None


def run_schema(_: argparse.Namespace) -> int:
    """Prints the schema."""
    from radar_service.scene_file.describe import json_schema

    print(json.dumps(json_schema(), indent=2))
    return 0


RUN: dict[str, Callable[[argparse.Namespace], int]] = {
    "serve": run_serve, "scan": run_scan, "record": run_record, "replay": run_replay, "check": run_check, "plan": run_plan,
    "stability": run_stability, "chart": run_chart, "schema": run_schema, "bench-tracker": run_bench_tracker,
    "plots": run_plots, "bench-detection": run_bench_detection,
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line. Returns the exit status: 0, 2 for wrong input, 130 when interrupted, 141 for a closed pipe."""
    try:
        try:
            return _run(arguments)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:  # as in `radar-service check | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the interpreter flushes once more at its end
        return PIPE_CLOSED


def _run(arguments: Sequence[str] | None) -> int:
    options = parser().parse_args(arguments)
    try:
        with _blas_limit(options):
            status = RUN[options.command](options)
    except SceneError as error:
        print(*error.problems, sep="\n", file=sys.stderr)
        return 2
    except (UsageError, RecordingError, MissingExtra) as error:
        print(error, file=sys.stderr)
        return 2
    except BrokenPipeError:
        raise
    except OSError as error:
        print(f"{error.filename or 'file'}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return status


def _blas_limit(options: argparse.Namespace) -> contextlib.AbstractContextManager[Any]:
    """Keeps BLAS to one thread for the whole command; `serve` does no such arithmetic in this process."""
    if options.command in ("serve", "replay"):
        return contextlib.nullcontext()
    from radar_service.numerics.parallel import BLAS_LIMIT

    return BLAS_LIMIT.held()


if __name__ == "__main__":
    sys.exit(main())

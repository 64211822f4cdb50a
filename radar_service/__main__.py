"""The command line: serve, scan, record, replay, check, plan, ... Only this module may import all others.

Commands import what they need when they run: `serve` leaves the simulator to other processes, and so starts soon.
"""

import argparse
import contextlib
import errno
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from radar_service import __version__
from radar_service.arguments import file_ending, pace, thread_count, whole
from radar_service.extras import MissingExtra
from radar_service.fidelity import PRESETS, PURPOSE
from radar_service.plan.arguments import ERROR_HELP, PACE_HELP, error_budget, finite_pace
from radar_service.recording.arguments import add_commands as add_recording_commands
from radar_service.recording.error import RecordingError
from radar_service.scene.error import SceneError

if TYPE_CHECKING:
    from radar_service.simulator_options import SimulatorOptions

DEFAULT_SCENE = "harbour"
PIPE_CLOSED = 141  # exit status, 128 + SIGPIPE, as shells report programs that a closed pipe ends


class UsageError(Exception):
    """A command line that cannot run. Its text names the remedy."""


def simulator_options(options: argparse.Namespace, threads: int = 1) -> "SimulatorOptions":
    """Returns what the options say about simulators."""
    from radar_service.simulator_options import SimulatorOptions

    return SimulatorOptions(options.fidelity, options.error_db, options.seed, threads)


def parser() -> argparse.ArgumentParser:
    """Returns the parser of the command line."""
    top = argparse.ArgumentParser("radar-service", description="A simulated marine radar.")
    top.add_argument("--version", action="version", version=f"radar-service {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    scene_help = f"a .toml or .json file, or the name of a packaged scene (default {DEFAULT_SCENE})"
    common = argparse.ArgumentParser(add_help=False)
    presets = "; ".join(f"{name}: {purpose}" for name, purpose in PURPOSE.items())
    precision = common.add_mutually_exclusive_group()
    precision.add_argument("--fidelity", default="auto", choices=["auto", *PRESETS], help=f"{presets}; auto: planned")
    precision.add_argument("--error-db", type=error_budget, metavar="DB", help=ERROR_HELP)
    common.add_argument("--seed", default=0, type=partial(whole, minimum=0, maximum=2**63 - 1), help="default 0")
    threaded = argparse.ArgumentParser(add_help=False)
    threaded.add_argument(
        "--threads", default=1, type=thread_count, metavar="N",
        help="threads that compute each radar, or auto: all cores but one (default 1); changes no byte",
    )  # fmt: skip

    network = argparse.ArgumentParser(add_help=False)
    network.add_argument("--host", default="127.0.0.1", help="address to listen on (default 127.0.0.1)")
    network.add_argument("--port", default=8000, type=partial(whole, minimum=0, maximum=65535), help="default 8000; 0: any")
    network.add_argument("--pace", default=1.0, type=pace, help="simulated seconds per second, or max (default 1)")
    network.add_argument("--truth", action="store_true", help="allow clients to read the truth")
    network.add_argument(
        "--wait-for", default=0, type=partial(whole, minimum=0, maximum=500), metavar="N",
        help="send nothing until N clients listen to a radar, so that they get its first spoke (default 0)",
    )  # fmt: skip
    network.add_argument("--scene-folder", action="append", default=[], type=Path, help="list the scenes of this folder too")
    network.add_argument(
        "--token", help="token that every change needs; other users see it in the list of processes, so prefer:"
    )
    network.add_argument("--token-file", type=Path, help="a file whose first line is that token")
    network.add_argument("--token-for-reading", dest="read_token", help="token that reading needs")
    network.add_argument(
        "--token-file-for-reading", dest="read_token_file", type=Path, help="a file whose first line is that token"
    )
    network.add_argument("--insecure", action="store_true", help="allow everybody who reaches the server to do anything")
    network.add_argument("--allow-host", action="append", default=[], metavar="NAME", help="a host name of this server")
    network.add_argument("--exit-when-failed", action="store_true", help="exit with status 1 when a radar has failed")
    network.add_argument("--log", default="quiet", choices=["quiet", "text", "json"], help="log events on standard error")
    network.add_argument(
        "--connections", type=partial(whole, minimum=1, maximum=100_000), help="maximum number of connections"
    )
    network.add_argument(
        "--connections-per-address", type=partial(whole, minimum=1, maximum=100_000),
        help="maximum number of connections from one other machine",
    )  # fmt: skip
    network.add_argument(
        "--sandbox-all",
        action="store_true",
        help="parse the files of every scene, not only of uploads, in a limited process",
    )
    serve = commands.add_parser("serve", parents=[common, threaded, network], help="run radars: feed, REST and page")
    serve.add_argument("scenes", nargs="*", metavar="SCENE", help=f"one radar each: {scene_help}")
    serve.add_argument(
        "--record", type=partial(file_ending, suffix=".mcap"), metavar="FILE.mcap",
        help="record what the radars send, and with --truth the truth",
    )  # fmt: skip
    serve.set_defaults(run=run_serve)

    chosen = argparse.ArgumentParser(add_help=False)
    chosen.add_argument("--radar", metavar="ID", help="one of the scene's [[radar]] tables, by its id (default the first)")

    scan = commands.add_parser("scan", parents=[common, threaded, chosen], help="compute scans into a file")
    scan.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    scan_file = partial(file_ending, suffix=(".npz", ".zarr", ".nc"))
    scan.add_argument("-o", "--out", type=scan_file, required=True, help="file.npz, .zarr or .nc to write")
    scan.add_argument("--png", type=partial(file_ending, suffix=".png"), help="file.png to write: picture of the last scan")
    scan.add_argument("--scans", default=1, type=partial(whole, minimum=1, maximum=10_000), help="revolutions (default 1)")
    scan.add_argument(
        "--truth", type=partial(file_ending, suffix=".jsonl"), help="file.jsonl to write: the truth of each beam crossing"
    )
    scan.add_argument("--radiometric", action="store_true", help="measure the power of each body too, for --truth")
    scan.add_argument("--labels", action="store_true", help="write the number of the strongest source of each cell too")
    scan.set_defaults(run=run_scan)

    add_recording_commands(commands, [common, threaded], network, scene_help, run_record, run_replay)
    for name, run, text in (
        ("check", run_check, "validate a scene and list what it contains"),
        ("plan", run_plan, "show what is modelled of a scene, at what error and cost"),
    ):
        command = commands.add_parser(name, parents=[common, chosen] if name == "plan" else [chosen], help=text)
        command.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
        command.set_defaults(run=run)
    command.add_argument("--json", action="store_true", help="as JSON")
    command.add_argument("--realtime-factor", type=finite_pace, metavar="F", help=PACE_HELP)
    stability = commands.add_parser("stability", help="find where each method fails, and write a report")
    stability.add_argument("-o", "--out", type=Path, required=True, help="folder for stability.html and stability.json")
    stability.add_argument("--fine", default=1, type=partial(whole, minimum=1, maximum=20), help="times as many samples")
    stability.set_defaults(run=run_stability)
    study = commands.add_parser("chart", help="measure speed and accuracy of every method on a scene")
    study.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    study.add_argument(
        "-o", "--out", type=Path, required=True, help="existing folder for chart.svg, .png, .json and summary.txt"
    )
    study.add_argument("--seed", default=0, type=partial(whole, minimum=0, maximum=2**63 - 1), help="default 0")
    study.add_argument("--quick", action="store_true", help="take seconds instead of minutes, with fewer samples")
    study.set_defaults(run=run_chart)
    commands.add_parser("schema", help="print the JSON Schema of a scene").set_defaults(run=run_schema)
    return top


def run_serve(options: argparse.Namespace) -> int:
    """Serves until stopped."""
    from radar_service.stream.serve import StartError, serve

    options.scenes = options.scenes or [DEFAULT_SCENE]
    make = simulator_options(options, options.threads)
    try:
        if options.record is None:
            return serve(options, make)
        from radar_service.recording.service_recorder import ServiceRecorder

        with ServiceRecorder(options.record, options.truth) as recorder:
            return serve(options, make, recorder.station)
    except StartError as error:
        raise UsageError(str(error)) from None


def run_record(options: argparse.Namespace) -> int:
    """Computes scans into a recording, with a progress bar on a terminal."""
    from radar_service.recording.record_command import record

    return record(options, simulator_options(options, options.threads))


def run_replay(options: argparse.Namespace) -> int:
    """Serves a recording until its end."""
    from radar_service.recording.replay_command import replay
    from radar_service.stream.serve import StartError

    try:
        return replay(options)
    except StartError as error:
        raise UsageError(str(error)) from None


def run_scan(options: argparse.Namespace) -> int:
    """Computes scans, with a progress bar on a terminal."""
    from radar_service.scan_command import scan

    for name in ("labels", "radiometric"):
        if getattr(options, name) and options.fidelity == "documented":
            raise UsageError(f"--{name}: the fidelity documented has none; choose another fidelity, or leave --{name} out")
    if options.radiometric and not options.truth:
        raise UsageError("--radiometric: it needs the file of --truth; add --truth FILE.jsonl, or leave --radiometric out")
    return scan(options, replace(simulator_options(options, options.threads), labels=options.labels))


def run_check(options: argparse.Namespace) -> int:
    """Prints what a scene contains."""
    from radar_service.plan.budget import ErrorBudget
    from radar_service.plan.remarks import body_remarks
    from radar_service.plan.settings_search import fidelity_for
    from radar_service.scene.describe import describe
    from radar_service.scene.load import load_scene

    scene = load_scene(options.scene).for_radar(options.radar)
    print(describe(scene, body_remarks(scene, fidelity_for(scene, ErrorBudget()))))
    return 0


def run_plan(options: argparse.Namespace) -> int:
    """Prints what is modelled, at what error and cost."""
    from radar_service.plan.realtime import plan_in_time
    from radar_service.scene.load import load_scene
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

    options.out.mkdir(parents=True, exist_ok=True)  # refused now, not after the studies
    findings = [study(options.fine) for study in tqdm(STUDIES, unit="regions", disable=None)]
    write_report(options.out, findings)
    print(f"{options.out / 'stability.html'}: {len(findings)} regions")
    return 0


def run_chart(options: argparse.Namespace) -> int:
    """Measures all methods on a scene, with progress bars on a terminal."""
    from radar_service.scene.load import load_scene
    from radar_service.study.chart import chart
    from radar_service.study.chart.summary import summary_text

    if not options.out.is_dir():
        raise FileNotFoundError(errno.ENOENT, "there is no such folder; create it first", str(options.out))
    effort = chart.QUICK if options.quick else chart.FULL
    data = chart.write_chart(chart.measure(load_scene(options.scene), options.seed, effort, progress=True), options.out)
    print(summary_text(data["summary"]), end="")
    return 0


def run_schema(_: argparse.Namespace) -> int:
    """Prints the schema."""
    from radar_service.scene.describe import json_schema

    print(json.dumps(json_schema(), indent=2))
    return 0


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
            status: int = options.run(options)
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
    if options.run in (run_serve, run_replay):
        return contextlib.nullcontext()
    from radar_service.parallel import BLAS_LIMIT

    return BLAS_LIMIT.held()


if __name__ == "__main__":
    sys.exit(main())

"""The arguments of all commands."""

import argparse
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from radar_service import __version__
from radar_service.commands.bench_arguments import add_bench_detection, add_bench_tracker, add_plots
from radar_service.commands.recording_arguments import add_commands as add_recording_commands
from radar_service.display.units import add_unit
from radar_service.plan.arguments import ERROR_HELP, PACE_HELP, error_budget, finite_pace
from radar_service.ports.registry import packages
from radar_service.records.fidelity import PRESETS, PURPOSE
from radar_service.terminal.arguments import add_sources, file_ending, pace, thread_count, whole
from radar_service.terminal.output_files import add_overwrite

DEFAULT_SCENE = "harbour"
SERVE_GROUPS = ("what", "where", "how exact", "how fast", "who may", "records")
SERVE_EXAMPLES = """examples:
  radar-service serve harbour --truth
  radar-service serve mine.toml --host 0.0.0.0 --token-file token.txt --record day.mcap"""


def parser() -> argparse.ArgumentParser:
    """Returns the parser of the command line."""
    top = argparse.ArgumentParser("radar-service", description="A simulated marine radar.")
    top.add_argument("--version", action="version", version=f"radar-service {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    scene_help = f"a .toml or .json file, or the name of a packaged scene (default {DEFAULT_SCENE})"
    common, threaded, network = (argparse.ArgumentParser(add_help=False) for _ in range(3))
    _add_exactness(common)
    _add_threads(threaded)
    _add_network(_groups(network))
    _add_serve(commands, scene_help)

    chosen = argparse.ArgumentParser(add_help=False)
    chosen.add_argument("--radar", metavar="ID", help="one of the scene's [[radar]] tables, by its id (default the first)")

    scan = commands.add_parser("scan", parents=[common, threaded, chosen], help="compute scans into a file")
    scan.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    scan_file = partial(file_ending, suffix=(".npz", ".zarr", ".nc"))
    scan.add_argument("-o", "--out", type=scan_file, required=True, help="file.npz, .zarr or .nc to write")
    scan.add_argument("--png", type=partial(file_ending, suffix=".png"), help="file.png to write: picture of the last scan")
    add_unit(scan, "--png")
    add_overwrite(scan)
    scan.add_argument("--scans", default=1, type=partial(whole, minimum=1, maximum=10_000), help="revolutions (default 1)")
    scan.add_argument(
        "--truth", type=partial(file_ending, suffix=".jsonl"), help="file.jsonl to write: the truth of each beam crossing"
    )
    scan.add_argument("--radiometric", action="store_true", help="measure the power of each body too, for --truth")
    add_sources(scan, "write", " too")

    add_recording_commands(commands, [common, threaded], network, scene_help)
    check = commands.add_parser("check", parents=[chosen], help="validate a scene and list what it contains")
    check.add_argument("--all", action="store_true", help="all bodies, notes and remarks, not one screen")
    plan = commands.add_parser(
        "plan", parents=[common, chosen], help="show what is modelled of a scene, at what error and cost"
    )
    plan.add_argument("--json", action="store_true", help="as JSON")
    plan.add_argument("--realtime-factor", type=finite_pace, metavar="F", help=PACE_HELP)
    for command in (check, plan):
        command.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    _add_studies(commands, scene_help)
    add_bench_tracker(commands)
    add_plots(commands, [common, threaded, chosen], scene_help)
    add_bench_detection(commands)
    commands.add_parser("schema", help="print the JSON Schema of a scene")
    return top


def _add_serve(commands: "argparse._SubParsersAction[argparse.ArgumentParser]", scene_help: str) -> None:
    """Adds `serve`, whose many options are in groups."""
    serve = commands.add_parser(
        "serve", help="run radars: feed, REST and page", epilog=SERVE_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    groups = _groups(serve)
    groups["what"].add_argument("scenes", nargs="*", metavar="SCENE", help=f"one radar each: {scene_help}")
    _add_network(groups)
    _add_exactness(groups["how exact"])
    _add_threads(groups["how fast"])
    for package in packages():
        package.add_arguments(groups)


def _add_exactness(to: "argparse._ActionsContainer") -> None:
    """Adds the options that decide what is computed."""
    presets = "; ".join(f"{name}: {purpose}" for name, purpose in PURPOSE.items())
    precision = to.add_mutually_exclusive_group()
    precision.add_argument("--fidelity", default="auto", choices=["auto", *PRESETS], help=f"{presets}; auto: planned")
    precision.add_argument("--error-db", type=error_budget, metavar="DB", help=ERROR_HELP)
    to.add_argument("--seed", default=0, type=partial(whole, minimum=0, maximum=2**63 - 1), metavar="N", help="default 0")


def _add_threads(to: "argparse._ActionsContainer") -> None:
    to.add_argument(
        "--threads", default=1, type=thread_count, metavar="N",
        help="threads that compute each radar, or auto: all cores but one (default 1); changes no byte",
    )  # fmt: skip


def _groups(parser: argparse.ArgumentParser) -> dict[str, "argparse._ArgumentGroup"]:
    """The groups of options of all that listens on the network, by title."""
    return {title: parser.add_argument_group(title) for title in SERVE_GROUPS}


def _add_network(groups: Mapping[str, "argparse._ActionsContainer"]) -> None:
    """Adds the options of all that listens on the network."""
    what, where, fast, may = (groups[title] for title in ("what", "where", "how fast", "who may"))
    what.add_argument(
        "--scene-folder", action="append", default=[], type=Path, metavar="DIR", help="list the scenes of this folder too"
    )
    what.add_argument(
        "--sandbox-all",
        action="store_true",
        help="parse the files of every scene, not only of uploads, in a limited process",
    )
    where.add_argument("--host", default="127.0.0.1", help="address to listen on (default 127.0.0.1)")
    where.add_argument(
        "--port", default=8000, type=partial(whole, minimum=0, maximum=65535), metavar="N", help="default 8000; 0: any"
    )
    where.add_argument("--allow-host", action="append", default=[], metavar="NAME", help="a host name of this server")
    where.add_argument("--log", default="quiet", choices=["quiet", "text", "json"], help="log events on standard error")
    where.add_argument("--exit-when-failed", action="store_true", help="exit with status 1 when a radar has failed")
    fast.add_argument("--pace", default=1.0, type=pace, metavar="X", help="simulated seconds per second, or max (default 1)")
    fast.add_argument(
        "--wait-for", default=0, type=partial(whole, minimum=0, maximum=500), metavar="N",
        help="send nothing until N clients listen to a radar, so that they get its first spoke (default 0)",
    )  # fmt: skip
    _add_access(may)


def _add_access(may: "argparse._ActionsContainer") -> None:
    """Adds the options that decide who may do what."""
    may.add_argument("--truth", action="store_true", help="allow clients to read the truth")
    may.add_argument(
        "--token", help="token that every change needs; other users see it in the list of processes, so prefer:"
    )
    may.add_argument("--token-file", type=Path, metavar="FILE", help="a file whose first line is that token")
    may.add_argument("--token-for-reading", dest="read_token", metavar="TOKEN", help="token that reading needs")
    may.add_argument(
        "--token-file-for-reading", dest="read_token_file", type=Path, metavar="FILE",
        help="a file whose first line is that token",
    )  # fmt: skip
    may.add_argument("--insecure", action="store_true", help="allow everybody who reaches the server to do anything")
    count = partial(whole, minimum=1, maximum=100_000)
    may.add_argument("--connections", type=count, metavar="N", help="maximum number of connections")
    may.add_argument(
        "--connections-per-address", type=count, metavar="N", help="maximum number of connections from one other machine"
    )


def _add_studies(commands: "argparse._SubParsersAction[argparse.ArgumentParser]", scene_help: str) -> None:
    """Adds the commands that study methods."""
    stability = commands.add_parser("stability", help="find where each method fails, and write a report")
    stability.add_argument("-o", "--out", type=Path, required=True, help="folder for stability.html and stability.json")
    stability.add_argument("--fine", default=1, type=partial(whole, minimum=1, maximum=20), help="times as many samples")
    study = commands.add_parser("chart", help="measure speed and accuracy of every method on a scene")
    study.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    study.add_argument("-o", "--out", type=Path, required=True, help="folder for chart.svg, .png, .json and summary.txt")
    study.add_argument("--seed", default=0, type=partial(whole, minimum=0, maximum=2**63 - 1), help="default 0")
    study.add_argument("--quick", action="store_true", help="take seconds instead of minutes, with fewer samples")

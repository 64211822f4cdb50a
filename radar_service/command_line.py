"""The arguments of all commands."""

import argparse
from functools import partial
from pathlib import Path

from radar_service import __version__
from radar_service.arguments import file_ending, pace, thread_count, whole
from radar_service.fidelity import PRESETS, PURPOSE
from radar_service.plan.arguments import ERROR_HELP, PACE_HELP, error_budget, finite_pace
from radar_service.recording.arguments import add_commands as add_recording_commands
from radar_service.recording.arguments import add_sources
from radar_service.tracking.arguments import add_bench_detection, add_bench_tracker, add_plots

DEFAULT_SCENE = "harbour"


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

    network = _network_options()
    serve = commands.add_parser("serve", parents=[common, threaded, network], help="run radars: feed, REST and page")
    serve.add_argument("scenes", nargs="*", metavar="SCENE", help=f"one radar each: {scene_help}")
    serve.add_argument(
        "--record", type=partial(file_ending, suffix=".mcap"), metavar="FILE.mcap",
        help="record what the radars send, and with --truth the truth",
    )  # fmt: skip
    add_sources(serve, "record", ", with --record; clients ask for theirs, where --truth allows it")

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
    add_sources(scan, "write", " too")

    add_recording_commands(commands, [common, threaded], network, scene_help)
    for name, text in (
        ("check", "validate a scene and list what it contains"),
        ("plan", "show what is modelled of a scene, at what error and cost"),
    ):
        command = commands.add_parser(name, parents=[common, chosen] if name == "plan" else [chosen], help=text)
        command.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    command.add_argument("--json", action="store_true", help="as JSON")
    command.add_argument("--realtime-factor", type=finite_pace, metavar="F", help=PACE_HELP)
    _add_studies(commands, scene_help)
    add_bench_tracker(commands)
    add_plots(commands, [common, threaded, chosen], scene_help)
    add_bench_detection(commands)
    commands.add_parser("schema", help="print the JSON Schema of a scene")
    return top


def _network_options() -> argparse.ArgumentParser:
    """The options of all that listens on the network."""
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
    return network


def _add_studies(commands: "argparse._SubParsersAction[argparse.ArgumentParser]", scene_help: str) -> None:
    """Adds the commands that study methods."""
    stability = commands.add_parser("stability", help="find where each method fails, and write a report")
    stability.add_argument("-o", "--out", type=Path, required=True, help="folder for stability.html and stability.json")
    stability.add_argument("--fine", default=1, type=partial(whole, minimum=1, maximum=20), help="times as many samples")
    study = commands.add_parser("chart", help="measure speed and accuracy of every method on a scene")
    study.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    study.add_argument(
        "-o", "--out", type=Path, required=True, help="existing folder for chart.svg, .png, .json and summary.txt"
    )
    study.add_argument("--seed", default=0, type=partial(whole, minimum=0, maximum=2**63 - 1), help="default 0")
    study.add_argument("--quick", action="store_true", help="take seconds instead of minutes, with fewer samples")

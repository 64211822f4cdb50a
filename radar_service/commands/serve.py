"""The command `serve`: runs radars: feed, REST and page.

Scenes start in processes of their own, and meanwhile the server: what takes long to import is imported while they prepare.
"""

import argparse
import contextlib
import gc
import secrets
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from radar_service.commands.shared_options import (
    DEFAULT_SCENE,
    SCENE_HELP,
    add_exactness,
    add_network,
    add_threads,
    service_groups,
    simulator_options,
)
from radar_service.ports.registry import add_ports, opened
from radar_service.processes.call import Progress
from radar_service.processes.fork_server import ForkServer
from radar_service.processes.stop_signals import ended_by_signals
from radar_service.service import logs
from radar_service.service.access import Access, checked_token, is_loopback
from radar_service.terminal import UsageError

if TYPE_CHECKING:
    from radar_service.ports.port import Port
    from radar_service.service.radio.scene_process import SceneProcess
    from radar_service.service.scene_request import MakeSimulator, SceneRequest

SCENES_NEED = ("radar_service.simulator", "radar_service.service.radio.scene_process_main")
OTHERS_NEED = (
    "radar_service.service.radio.last_scan", "radar_service.display.last_scan",
    "scipy.interpolate", "pyproj", "trimesh",  # which some scenes need
)  # fmt: skip

OpenPorts = Callable[[argparse.Namespace], contextlib.AbstractContextManager["Sequence[Port]"]]


class StartError(UsageError):
    """The server cannot start. The text says why."""


class AccessError(StartError):
    """Options that would leave a server unprotected. The text says what to do."""


BLIND_HELP = "for a program under test: it may read losslessly, change nothing, and is told neither seed nor bodies"
EXAMPLES = """examples:
  radar-service serve harbour --truth
  radar-service serve mine.toml --host 0.0.0.0 --token-file token.txt --record day.mcap"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments, in groups, with those of the ports."""
    parser.epilog, parser.formatter_class = EXAMPLES, argparse.RawDescriptionHelpFormatter
    groups = service_groups(parser)
    groups["what"].add_argument("scenes", nargs="*", metavar="SCENE", help=f"one radar each: {SCENE_HELP}")
    add_network(groups)
    groups["who may"].add_argument("--blind", action="store_true", help=BLIND_HELP)
    add_exactness(groups["how exact"])
    add_threads(groups["how fast"])
    add_ports(parser, groups)


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises SceneError, UsageError and OSError."""
    options.scenes = options.scenes or [DEFAULT_SCENE]
    return serve(options, simulator_options(options, options.threads), opened)


def serve(options: argparse.Namespace, make_simulator: "MakeSimulator", open_ports: OpenPorts) -> int:
    """Serves the scenes of the options until stopped; returns the exit status.

    make_simulator: makes the simulator of a scene, in the scene's own process; open_ports: opens the ports that options ask for.
    Raises StartError, SceneError, OSError, and what a port raises that cannot open.
    """
    access = _blind(options) if options.blind else access_for(options)
    logs.configure(options.log)
    gc.disable()  # until the service runs: a tenth of the time of imports
    with contextlib.ExitStack() as on_end:
        on_end.callback(gc.enable)
        on_end.enter_context(ended_by_signals())
        scenes: list[Future[list[SceneProcess]]] = []
        start = Progress()
        fork_server = ForkServer(SCENES_NEED, OTHERS_NEED)
        for close in (partial(_close, scenes), fork_server.close, start.close):  # the last one comes first
            on_end.callback(close)
        fork_server.start()
        from radar_service.service.radio.scene_process import (
            SceneProcessMaker,  # here and below: meanwhile the other process starts
        )
        from radar_service.service.scene_request import SceneRequest
        from radar_service.spoke_source import SpokeSourceFault

        make = SceneProcessMaker(fork_server, make_simulator)
        scene_requests = [
            SceneRequest(scene_input, options.sandbox_all, measured_later=True, blind=options.blind)
            for scene_input in options.scenes
        ]
        scenes += _started(partial(make, progress=start), scene_requests)
        from radar_service.ports.running import run

        ports = on_end.enter_context(open_ports(options))
        try:
            return run(options, access, lambda: [scene.result() for scene in scenes], make, fork_server, ports)
        except SpokeSourceFault as error:
            raise StartError(f"scene: {error}") from None


def _started(
    make: "Callable[[SceneRequest], SceneProcess]", scene_requests: "Sequence[SceneRequest]"
) -> "list[Future[list[SceneProcess]]]":
    """Returns the radars of each scene; scenes are prepared side by side."""
    threads = ThreadPoolExecutor(len(scene_requests), thread_name_prefix="start")
    scenes = [threads.submit(_radars, make, scene_request) for scene_request in scene_requests]
    threads.shutdown(wait=False)
    return scenes


def _close(scenes: "Sequence[Future[list[SceneProcess]]]") -> None:
    for scene in scenes:
        if not scene.exception():
            for radar in scene.result():
                radar.close()


def _radars(make: "Callable[[SceneRequest], SceneProcess]", scene_request: "SceneRequest") -> "list[SceneProcess]":
    """Returns the radars of a scene, each in a process of its own. The first one tells which others there are."""
    first = make(scene_request)
    others = [replace(scene_request, radar=radar_id) for radar_id in first.info.scene.radar_ids[1:]]
    with ThreadPoolExecutor(max(1, len(others)), thread_name_prefix="start") as threads:
        starting = [threads.submit(make, other) for other in others]
    with contextlib.ExitStack() as on_failure:
        for radar in (first, *(future.result() for future in starting if not future.exception())):
            on_failure.callback(radar.close)
        radars = [first, *(future.result() for future in starting)]
        on_failure.pop_all()
    return radars


def access_for(options: argparse.Namespace) -> Access:
    """Returns who may do what. Raises AccessError where other machines reach the server and no option protects it."""
    command, read = token(options.token_file), token(options.token_file_for_reading)
    if command is None and not is_loopback(options.host) and not options.insecure:
        raise AccessError(
            f"--host: {options.host} is open to other machines, and anybody there could command the radar; give "
            "--token-file FILE (`openssl rand -hex 16 > FILE`), or --insecure where everybody may"
        )
    if command is None and read is not None:
        raise AccessError(
            "--token-file-for-reading: protects nothing where everybody may command; give --token-file FILE as well"
        )
    return Access(command, read, frozenset(name.lower() for name in (options.host, *options.allow_host)))


def _blind(options: argparse.Namespace) -> Access:
    """Access to a radar for a program under test: nobody knows the token to command."""
    if options.truth:
        raise AccessError("--blind: --truth tells all; leave one of them out")
    return replace(access_for(options), command=secrets.token_hex(32), lossless=True)


def token(path: Path | None) -> str | None:
    """Returns the token in the first line of a file; None without a file. Raises AccessError, which does not repeat the token."""
    if path is None:
        return None
    lines = path.read_text(errors="replace").splitlines()
    try:
        return checked_token(lines[0].strip() if lines else "")
    except ValueError as error:
        raise AccessError(f"{path}: {error}") from None

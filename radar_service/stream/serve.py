"""The command `serve`: radars, access and server from its options, put together and run until stopped."""

import argparse
import asyncio
import contextlib
import gc
import signal
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from radar_service.stream import logs
from radar_service.stream.http.access import Access, checked_token, is_loopback
from radar_service.stream.http.app import create_app
from radar_service.stream.http.server import MAX_CONNECTIONS, MAX_PER_ADDRESS, Server, configuration, listening_socket
from radar_service.stream.logs import Refusals
from radar_service.stream.processes.fork_server import ForkServer
from radar_service.stream.radio.station import Station
from radar_service.stream.radio.world import WorldMaker, WorldSource
from radar_service.stream.radio.world_process import MakeEngine
from radar_service.stream.settings import Pace, Settings
from radar_service.stream.source import UNFOLLOWED, SceneOrder

IMPORTED_ONCE = (  # by the process that starts the processes of worlds and pictures
    "radar_service.simulator_options",
    "radar_service.stream.radio.world_process",
    "radar_service.stream.radio.last_scan",
    "radar_service.display.last_scan",
    "radar_service.stream.processes.call",
)


class AccessError(ValueError):
    """Options that would leave a server unprotected. The text says what to do."""


def serve(options: argparse.Namespace, make_engine: MakeEngine) -> int:
    """Serves the scenes of the options until stopped; returns the exit status.

    make_engine: makes the engine of a scene, in the scene's own process. Raises AccessError, SceneError, EngineFault, OSError.
    """
    access, refused = access_for(options), Refusals()
    logs.configure(options.log)
    settings = Settings(pace=Pace("run", options.pace))
    with contextlib.ExitStack() as on_end:
        fork_server = ForkServer(IMPORTED_ONCE)
        on_end.callback(fork_server.close)
        fork_server.start()
        make = WorldMaker(fork_server, make_engine)
        worlds = _prepared(make, [SceneOrder(source, options.sandbox_all) for source in options.scenes])
        for world in worlds:
            on_end.callback(world.close)
        stations = [
            Station(str(k), world, make, settings=settings, allow_truth=options.truth) for k, world in enumerate(worlds)
        ]
        app = create_app(
            stations, scene_folders=options.scene_folder, sandbox_all=options.sandbox_all, fork_server=fork_server,
            access=access, refused=refused,
        )  # fmt: skip
        config = configuration(
            app, connections=options.connections or MAX_CONNECTIONS,
            per_address=options.connections_per_address or MAX_PER_ADDRESS, refused=refused,
        )  # fmt: skip
        return _run(Server(config, stations, lambda: None), stations, options)


def _run(server: Server, stations: Iterable[Station], options: argparse.Namespace) -> int:
    listener = listening_socket(options.host, options.port)
    if options.exit_when_failed:
        for station in stations:
            station.failed = server.give_up
    for signal_number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(signal_number, lambda *_: None)  # uvicorn stops at either and raises it again after its end
    gc.collect()
    gc.freeze()  # objects that live as long as the service are not searched again and again, 50 ms at a time
    with asyncio.Runner(loop_factory=server.config.get_loop_factory()) as runner:
        runner.run(server.serve(sockets=[listener]))
    return 0 if server.started and not server.gave_up else 1


def _prepared(make: WorldMaker, orders: Iterable[SceneOrder]) -> list[WorldSource]:
    """Returns the worlds of all radars, prepared side by side."""
    with ThreadPoolExecutor(thread_name_prefix="start") as threads:
        return list(threads.map(lambda order: make(order, UNFOLLOWED), orders))


def access_for(options: argparse.Namespace) -> Access:
    """Returns who may do what. Raises AccessError where other machines reach the server and no option protects it."""
    command, read = token(options.token, options.token_file), token(options.read_token, options.read_token_file)
    if command is None and not is_loopback(options.host) and not options.insecure:
        raise AccessError(
            f"--host: {options.host} is open to other machines, and anybody there could command the radar; give "
            "--token-file FILE (`openssl rand -hex 16 > FILE`), or --insecure where everybody may"
        )
    if command is None and read is not None:
        raise AccessError(
            "--token-for-reading: protects nothing where everybody may command; give --token-file FILE as well"
        )
    return Access(command, read, frozenset(name.lower() for name in (options.host, *options.allow_host)))


def token(text: str | None, path: Path | None) -> str | None:
    """Returns a token from the command line or from the first line of a file.

    Raises AccessError, which does not repeat the token.
    """
    if path is not None:
        lines = path.read_text(errors="replace").splitlines()
        text = lines[0].strip() if lines else ""
    try:
        return None if text is None else checked_token(text)
    except ValueError as error:
        raise AccessError(f"{path or '--token'}: {error}") from None

"""The command `serve`: radars, access and server from its options, put together and run until stopped."""

import argparse
import asyncio
import gc
import signal
from collections.abc import Callable
from pathlib import Path

from radar_service.scene.files.mesh_reader import IN_PROCESS
from radar_service.scene.files.sandbox import Sandbox
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene
from radar_service.stream import logs
from radar_service.stream.http.access import Access, checked_token, is_loopback
from radar_service.stream.http.app import create_app
from radar_service.stream.http.server import MAX_CONNECTIONS, MAX_PER_ADDRESS, Server, configuration, listening_socket
from radar_service.stream.logs import Refusals
from radar_service.stream.radio.station import Station
from radar_service.stream.settings import Pace, Settings
from radar_service.stream.source import SpokeSource


class AccessError(ValueError):
    """Options that would leave a server unprotected. The text says what to do."""


def serve(options: argparse.Namespace, make_engine: Callable[[Scene], SpokeSource]) -> int:
    """Serves the scenes of the options until stopped; returns the exit status. Raises AccessError, SceneError, OSError."""
    access, refused = access_for(options), Refusals()
    logs.configure(options.log)
    settings, sandbox = Settings(pace=Pace("run", options.pace)), Sandbox()
    reader = sandbox if options.sandbox_all else IN_PROCESS
    stations = [
        Station(
            str(k), make_engine(load_scene(source, mesh_reader=reader)), make_engine, settings=settings,
            allow_truth=options.truth,
        )
        for k, source in enumerate(options.scenes)
    ]  # fmt: skip
    app = create_app(
        stations, scene_folders=options.scene_folder, sandbox=sandbox, sandbox_all=options.sandbox_all, access=access,
        refused=refused,
    )  # fmt: skip
    config = configuration(
        app, connections=options.connections or MAX_CONNECTIONS,
        per_address=options.connections_per_address or MAX_PER_ADDRESS, refused=refused,
    )  # fmt: skip
    listener = listening_socket(options.host, options.port)
    server = Server(config, stations, sandbox.start)
    if options.exit_when_failed:
        for station in stations:
            station.failed = server.give_up
    for signal_number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(signal_number, lambda *_: None)  # uvicorn stops at either and raises it again after its end
    gc.collect()
    gc.freeze()  # objects that live as long as the service are not searched again and again, 50 ms at a time
    with asyncio.Runner(loop_factory=config.get_loop_factory()) as runner:
        runner.run(server.serve(sockets=[listener]))
    return 0 if server.started and not server.gave_up else 1


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

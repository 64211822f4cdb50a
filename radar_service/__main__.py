"""Command line: serve, scan, check, plan, chart, stability, schema. The only place that wires everything together."""

import argparse
import asyncio
import contextlib
import errno
import json
import math
import signal
import socket
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import uvicorn
from tqdm import tqdm

from radar_service.display.video import Controls
from radar_service.fidelity import PRESETS
from radar_service.records import SpokeBlock
from radar_service.scene.describe import describe, json_schema
from radar_service.scene.error import SceneError
from radar_service.scene.load import load_scene
from radar_service.simulate import Simulator
from radar_service.stream.app import create_app
from radar_service.stream.pace import Pace
from radar_service.stream.picture import ppi_png
from radar_service.stream.station import Station
from radar_service.stream.transmitter import Settings
from radar_service.study.chart import chart
from radar_service.study.stability import STUDIES
from radar_service.study.stability.report import write_report

DEFAULT_SCENE = "harbour"
INBOUND_LIMIT = 4096  # bytes of a websocket message: clients have nothing to say
SHUTDOWN_SECONDS = 5
SEND_BUFFER = 128 * 2**10  # bytes: what a stalled client later gets as stale spokes (reference/streaming.md, section 2)
PICTURE_SIZE = 900  # pixels


class Server(uvicorn.Server):
    """A server that takes leave of the feeds before it closes their sockets."""

    def __init__(self, config: uvicorn.Config, stations: Sequence[Station]) -> None:
        super().__init__(config)
        self._stations = stations

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """As usual, then say where to look."""
        await super().startup(sockets)
        for listener in sockets or []:
            host, port = listener.getsockname()[:2]
            print(f"radar on the air: open http://{f'[{host}]' if ':' in host else host}:{port}/", flush=True)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Say bye to every client, then close as usual."""
        await asyncio.gather(*(station.stop() for station in self._stations))
        await super().shutdown(sockets)


def pace(text: str) -> Pace:
    """A pace from the command line: simulated seconds per second, or max. Raises ArgumentTypeError."""
    with contextlib.suppress(ValueError):
        factor = math.inf if text == "max" else float(text)
        if text == "max" or math.isfinite(factor):
            return Pace("run", factor)
    raise argparse.ArgumentTypeError(f'"{text}" is not a pace; give a number above 0 (1 is real time) or max')


def whole(text: str, least: int, most: int) -> int:
    """A whole number from the command line. Raises ArgumentTypeError outside the limits."""
    with contextlib.suppress(ValueError):
        if least <= int(text) <= most:
            return int(text)
    raise argparse.ArgumentTypeError(f'"{text}" is not a whole number from {least} to {most}')


def parser() -> argparse.ArgumentParser:
    """The command line."""
    top = argparse.ArgumentParser("radar-service", description="A simulated marine radar.")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    scene_help = f"a .toml or .json file, or the name of a packaged scene (default {DEFAULT_SCENE})"
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--fidelity", default="auto", choices=["auto", *PRESETS])
    common.add_argument("--seed", default=0, type=partial(whole, least=0, most=2**63 - 1))

    serve = commands.add_parser("serve", parents=[common], help="put radars on the air")
    serve.add_argument("scenes", nargs="*", metavar="SCENE", help=f"one radar each: {scene_help}")
    serve.add_argument("--host", default="127.0.0.1")
    serve.add_argument("--port", default=8000, type=partial(whole, least=0, most=65535), help="0 takes a free one")
    serve.add_argument("--pace", default=Pace(), type=pace, help="simulated seconds per second, or max (default 1)")
    serve.add_argument("--truth", action="store_true", help="let clients ask for the truth")
    serve.add_argument("--scene-folder", action="append", default=[], type=Path, help="offer the scenes of this folder too")
    serve.set_defaults(run=run_serve)

    scan = commands.add_parser("scan", parents=[common], help="compute scans into a file")
    scan.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    scan.add_argument("-o", "--out", type=Path, required=True, help="file.npz to write")
    scan.add_argument("--png", type=Path, help="picture of the last scan to write")
    scan.add_argument("--scans", default=1, type=partial(whole, least=1, most=10_000))
    scan.set_defaults(run=run_scan)

    for name, run, text in (
        ("check", run_check, "validate a scene and say what it contains"),
        ("plan", run_plan, "say what is modelled of a scene"),
    ):
        command = commands.add_parser(name, parents=[common] if name == "plan" else [], help=text)
        command.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
        command.set_defaults(run=run)
    stability = commands.add_parser("stability", help="drive every method to where it fails, and report")
    stability.add_argument("-o", "--out", type=Path, required=True, help="folder for stability.html and stability.json")
    stability.add_argument("--fine", default=1, type=partial(whole, least=1, most=20), help="times as many places and draws")
    stability.set_defaults(run=run_stability)
    study = commands.add_parser("chart", help="measure every method on a scene, speed against accuracy")
    study.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=scene_help)
    study.add_argument(
        "-o", "--out", type=Path, required=True, help="existing folder for chart.svg, .png, .json and reading.txt"
    )
    study.add_argument("--seed", default=0, type=partial(whole, least=0, most=2**63 - 1))
    study.add_argument("--quick", action="store_true", help="seconds instead of minutes, and rougher")
    study.set_defaults(run=run_chart)
    commands.add_parser("schema", help="print the JSON Schema of a scene").set_defaults(run=run_schema)
    return top


def run_serve(wanted: argparse.Namespace) -> int:
    """Serve until stopped."""
    factory = partial(Simulator, fidelity=wanted.fidelity, seed=wanted.seed)
    settings = Settings(pace=wanted.pace)
    stations = [
        Station(str(k), factory(load_scene(source)), factory, settings=settings, allow_truth=wanted.truth)
        for k, source in enumerate(wanted.scenes or [DEFAULT_SCENE])
    ]
    config = uvicorn.Config(
        create_app(stations, scene_folders=wanted.scene_folder), host=wanted.host, port=wanted.port, log_level="warning",
        ws_max_size=INBOUND_LIMIT, ws_per_message_deflate=False, timeout_graceful_shutdown=SHUTDOWN_SECONDS,
    )  # fmt: skip
    listener = listening_socket(wanted.host, wanted.port)
    for wish in (signal.SIGTERM, signal.SIGINT):
        signal.signal(wish, lambda *_: None)  # uvicorn stops at either and raises it again, which must not be our end
    server = Server(config, stations)
    with asyncio.Runner(loop_factory=config.get_loop_factory()) as runner:
        runner.run(server.serve(sockets=[listener]))
    return 0 if server.started else 1


def listening_socket(host: str, port: int) -> socket.socket:
    """A socket that takes connections there. Raises OSError naming the place."""
    try:
        listener = socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, f"{host}:{port}") from None
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)  # every connection inherits it
    return listener


def run_scan(wanted: argparse.Namespace) -> int:
    """Compute scans, with a progress bar on a terminal."""
    for path in (wanted.out, wanted.png):
        if path and not path.parent.is_dir():  # said now, not after an hour of computing
            raise FileNotFoundError(errno.ENOENT, "there is no such folder; create it first", str(path.parent))
    simulator = Simulator(load_scene(wanted.scene), wanted.fidelity, wanted.seed)
    azimuths = simulator.scene.radar.azimuths
    blocks = []
    with tqdm(total=wanted.scans * azimuths, unit="spokes", disable=None) as bar:
        for block in simulator.blocks(scans=wanted.scans):
            blocks.append(block)
            bar.update(len(block))
    write_npz(wanted.out, blocks, simulator)
    if wanted.png:
        write_png(wanted.png, blocks, simulator)
    print(f"{wanted.out}: {wanted.scans} x {azimuths} spokes of {simulator.range.size} cells")
    return 0


def write_npz(path: Path, blocks: Sequence[SpokeBlock], simulator: Simulator) -> None:
    """All spokes S of some scans as arrays: scan, azimuth, time, heading, course, speed (S,), position (S, 2), range (N,),
    field and power (S, N); and name, seed, fidelity."""
    keys = ("azimuth", "time", "heading", "course", "speed", "position", "field", "power")
    arrays: dict[str, Any] = {key: np.concatenate([getattr(block, key) for block in blocks]) for key in keys}
    scan = np.concatenate([np.full(len(block), block.scan) for block in blocks])
    with path.open("wb") as file:  # an open file keeps its name, a path would gain an ending
        np.savez(
            file, **arrays, scan=scan, range=simulator.range, name=simulator.scene.name, seed=simulator.seed,
            fidelity=simulator.fidelity.name,
        )  # fmt: skip


def write_png(path: Path, blocks: Sequence[SpokeBlock], simulator: Simulator) -> None:
    """The last scan as a display shows it, with its controls in the middle."""
    last = [block for block in blocks if block.scan == blocks[-1].scan]
    sweep = [(np.arange(block.index, block.index + len(block)), block.power) for block in last]
    path.write_bytes(ppi_png(simulator, sweep, Controls(), PICTURE_SIZE, None, float(last[-1].time[-1])))


def run_check(wanted: argparse.Namespace) -> int:
    """Say what a scene contains."""
    print(describe(load_scene(wanted.scene)))
    return 0


def run_plan(wanted: argparse.Namespace) -> int:
    """Say what would be modelled."""
    print(Simulator(load_scene(wanted.scene), wanted.fidelity, wanted.seed).plan)
    return 0


def run_stability(wanted: argparse.Namespace) -> int:
    """Find where methods fail, with a progress bar on a terminal."""
    wanted.out.mkdir(parents=True, exist_ok=True)  # said now, not after the studies
    findings = [study(wanted.fine) for study in tqdm(STUDIES, unit="regions", disable=None)]
    write_report(wanted.out, findings)
    print(f"{wanted.out / 'stability.html'}: {len(findings)} regions")
    return 0


def run_chart(wanted: argparse.Namespace) -> int:
    """Measure all methods on a scene, with progress bars on a terminal."""
    if not wanted.out.is_dir():
        raise FileNotFoundError(errno.ENOENT, "there is no such folder; create it first", str(wanted.out))
    effort = chart.QUICK if wanted.quick else chart.FULL
    said = chart.write(chart.measured(load_scene(wanted.scene), wanted.seed, effort, bar=True), wanted.out)
    print(said["reading"])
    return 0


def run_schema(_: argparse.Namespace) -> int:
    """Print the schema."""
    print(json.dumps(json_schema(), indent=2))
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; the exit status: 0, or 2 for what cannot be run and 130 when interrupted."""
    wanted = parser().parse_args(arguments)
    try:
        status: int = wanted.run(wanted)
    except SceneError as fault:
        print(*fault.problems, sep="\n", file=sys.stderr)
        return 2
    except OSError as fault:
        print(f"{fault.filename or 'file'}: {fault.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return status


if __name__ == "__main__":
    sys.exit(main())

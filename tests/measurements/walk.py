"""Counts the files and threads of the package that one spoke, and one command, pass on their way through a service.

    python -m tests.measurements.walk

The real simulator of a tiny radar in its process, one client, paused. Spokes are stepped, then own ship is commanded, by real
sockets. A file counts where a function of it is called with what is on its way, or returns it: spokes as records, arrays or a
message, the command as a request, values or a record. What only waits, paces or counts without it does not.
"""

import asyncio
import json
import os
import sys
import tempfile
import threading
from collections.abc import Mapping
from pathlib import Path
from types import FrameType
from typing import Any

import httpx
import numpy as np
from websockets.asyncio.client import connect

import radar_service
from radar_service import wire
from radar_service.commands.serve import OTHERS_NEED, SCENES_NEED
from radar_service.ports.app import create_app
from radar_service.processes.call import Progress
from radar_service.processes.fork_server import ForkServer
from radar_service.records.spokes import SpokeBlock
from radar_service.service.fanout.client_queue import QueueItem
from radar_service.service.fanout.hub import EncodedBatch
from radar_service.service.radio.command_worker import WaitingCommand
from radar_service.service.radio.scene_process import SceneProcessMaker
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import SpokeBatch
from radar_service.simulator import Simulator
from radar_service.world.commands import Command
from radar_service.world.scene import Scene
from tests.ports.serving import served
from tests.service.fake import AZIMUTHS, BINS, RADAR

PACKAGE = str(Path(radar_service.__file__).parent)
FOLDER = "WALK_FOLDER"  # of the environment: where the scene process says what it has seen
COURSE = 123.0  # of the command
AHEAD = 12 * AZIMUTHS  # spokes: more than the service computes ahead, so that some pass all the way while it is watched
SPOKE = SpokeBlock | SpokeBatch | EncodedBatch | QueueItem
SCENE = {"name": "walk", "radar": RADAR, "own_ship": {"steerable": {}}}


def carries_spoke(value: Any) -> bool:
    """Whether a value is a spoke on its way."""
    if isinstance(value, bytes | bytearray):
        return b"\xa6spokes" in value
    if isinstance(value, np.ndarray):
        return value.ndim == 2 and value.shape[1] == BINS and value.dtype.kind in "fcu"
    if isinstance(value, dict):
        return value.get("type") == "spokes" or any(map(carries_spoke, value.values()))
    return isinstance(value, SPOKE) or (isinstance(value, tuple) and any(map(carries_spoke, value)))


def carries_command(value: Any) -> bool:
    """Whether a value is the command on its way."""
    if isinstance(value, bytes | str):
        return b"course_deg" in (value if isinstance(value, bytes) else value.encode())
    if isinstance(value, Mapping):
        return value.get("course_deg") == COURSE
    if isinstance(value, Command | WaitingCommand):
        return True
    return getattr(value, "course_deg", None) == COURSE or (isinstance(value, tuple) and any(map(carries_command, value)))


class Walk:
    """Notes the files and threads in which a kind of thing was seen, while it watches."""

    def __init__(self) -> None:
        self.carries: Any = None  # while nothing is watched
        self.files: set[str] = set()
        self.threads: set[str] = set()

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        carries, name = self.carries, frame.f_code.co_filename
        if carries is None or event not in ("call", "return") or not name.startswith(PACKAGE):
            return
        values = [argument] if event == "return" else list(frame.f_locals.values())
        if any(map(carries, values)):
            self.files.add(name[len(PACKAGE) + 1 :])
            self.threads.add(threading.current_thread().name)


class WatchedSimulator(Simulator):
    """Writes down at the end of each block and each command what its process has seen so far."""

    walk: Walk

    def blocks(self, scans: int | None = None, size: int = 16) -> Any:
        sys.setprofile(self.walk)
        for block in super().blocks(scans, size):
            yield block
            self.note()

    def take(self, command: Command) -> None:
        super().take(command)
        self.taken = True
        self.note()

    def note(self) -> None:
        """Writes it down."""
        threads = sorted(f"world: {name}" for name in self.walk.threads)
        seen = {"files": sorted(self.walk.files), "threads": threads, "taken": self.taken}
        new = Path(os.environ[FOLDER], threading.current_thread().name)  # a file for each thread: two may write at once
        new.write_text(json.dumps(seen))
        new.replace(Path(os.environ[FOLDER], self.kind))

    kind, taken = "spoke", False


def watched_simulator(of: Scene) -> Simulator:
    """A simulator whose process watches spokes, and in its other threads the command."""
    simulator = WatchedSimulator(of)
    simulator.walk = Walk()
    simulator.walk.carries = carries_spoke if os.environ.get("WALK_KIND", "spoke") == "spoke" else carries_command
    simulator.kind = os.environ.get("WALK_KIND", "spoke")
    threading.setprofile(simulator.walk)
    return simulator


async def play(kind: str, host: str, port: int, walk: Walk) -> None:
    """Lets one thing of a kind pass."""
    address = f"{host}:{port}/api/radars/0"
    async with connect(f"ws://{address}/feed?encoding=u8", max_size=None) as feed, httpx.AsyncClient() as rest:
        await feed.recv()
        walk.carries = carries_spoke if kind == "spoke" else carries_command
        if kind == "spoke":
            await rest.patch(f"http://{address}/controls", json={"pace": {"state": "step", "steps": AHEAD}})
            count = 0
            while count < AHEAD:
                count += wire.unpack(bytes(await feed.recv())).get("count", 0)
        else:
            answer = await rest.patch(f"http://{address}/own-ship", json={"course_deg": COURSE})
            assert answer.status_code == 200, answer.text
            await rest.patch(f"http://{address}/controls", json={"pace": {"state": "step", "steps": AZIMUTHS}})
            await feed.recv()
            while not json.loads(Path(os.environ[FOLDER], kind).read_text())[
                "taken"
            ]:  # spokes may come before that is noted
                await asyncio.sleep(0.01)
        walk.carries = None


def walked(kind: str) -> tuple[set[str], set[str]]:
    """The files and the threads that one thing of a kind passes."""
    walk = Walk()
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update({FOLDER: folder, "WALK_KIND": kind})
        fork_server = ForkServer(SCENES_NEED, OTHERS_NEED)
        fork_server.start()
        maker = SceneProcessMaker(fork_server, watched_simulator)
        threading.setprofile(walk)
        source = maker(SceneRequest(SCENE), Progress())
        station = Station("0", source, maker, settings=Settings(pace=Pace("pause")))
        with served(create_app([station], fork_server=fork_server), [station]) as (host, port):
            asyncio.run(asyncio.wait_for(play(kind, host, port, walk), 30))
        threading.setprofile(None)
        seen = json.loads(Path(folder, kind).read_text())
    return walk.files | set(seen["files"]), walk.threads | set(seen["threads"])


def main() -> None:
    """Prints what each kind passes."""
    for kind in ("spoke", "command"):
        files, threads = walked(kind)
        print(f"a {kind} passes {len(files)} files and {len(threads)} threads:")
        print("  " + "\n  ".join(sorted(files)))
        print("  threads: " + ", ".join(sorted(threads)))


if __name__ == "__main__":
    from tests.measurements import walk  # by its name, as the scene process finds the simulator

    walk.main()

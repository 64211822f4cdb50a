"""A radar for tests of trackers: scans and the truth of their beam crossings, in process or from a service."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from types import TracebackType
from typing import IO, Any, Literal, Protocol, Self, TextIO

import numpy as np
from typing_extensions import override
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from radar_service import wire
from radar_service.numerics import wrap_angle
from radar_service.records import (
    Crossing,
    FalseEcho,
    FeedErrorCounts,
    Kinematics,
    OwnShipTruth,
    PowersOf,
    Snapshot,
    SourceRequest,
    SpokeBlock,
    source_request,
    square_law,
    text_of,
)
from radar_service.scans import Scan, scan_of
from radar_service.scene_file import load_scene, model_from, radar_entries
from radar_service.simulator import Simulator
from radar_service.stages.registry import effects_named
from radar_service.strict_json import tupled
from radar_service.wire import SpokeRows
from radar_service.world import Scene, known_radar

RECEIVE_TIMEOUT = 60.0  # s until the next message
CLOSE_TIMEOUT = 1.0  # s to say goodbye: messages that nobody reads any more may stand before the answer
START_TIMEOUT = 600.0  # s until a service tells its address: large scenes are prepared first
STOP_TIMEOUT = 20.0  # s, then a service is killed
LAST_WORDS = 300  # characters of what a service that has ended wrote last
HALF_UNIT = 1.0001 * np.pi / 65536  # rad; azimuths on the wire are rounded to 1/65536 turn
OwnShip = Mapping[str, float]  # time, east, north, heading, course, speed
SceneInput = str | Path | Mapping[str, Any] | Scene


class RadarFeed(Protocol):
    """A radar from its first scan on.

    crossings, snapshots: of all scans that were taken so far, by time; label_names: of sources, by the numbers of labels.
    """

    crossings: list[Crossing]

    @property
    def label_names(self) -> dict[int, str]:
        """By rising number."""

    @property
    def snapshots(self) -> Sequence[Snapshot]:
        """All bodies at the end of each scan."""

    def scans(self, count: int) -> Iterator[Scan]:
        """Yields the next scans; the crossings of each are known when it comes."""


class RadarFeeds:
    """Makes radars, and ends them as a context manager."""

    def __init__(self) -> None:
        self._ending = ExitStack()

    def __call__(
        self, scene: SceneInput, seed: int = 0, pace: float | Literal["max"] = "max",
        over: Literal["process", "websocket"] = "process", fidelity: str = "auto",
        labels: bool = False, powers: PowersOf = (), radar: str | None = None,
    ) -> RadarFeed:  # fmt: skip
        """Returns a radar from its spoke 0 on.

        scene: a file, the name of a packaged scene, a mapping, or in process a Scene. over: "process" computes a scan when it
        is taken; "websocket" starts a service on a free port of this machine. pace: simulated seconds per second of a service.
        labels: whether scans have the strongest source of each cell; powers: `all`, or the numbers of the sources whose power
        they have. radar: the id of one of the scene's radars; the first by default.
        Raises ValueError for a value that is not allowed, SceneError, and RuntimeError where a service does not start.
        """
        request = source_request(labels, powers)
        if over == "process":
            if pace != "max":
                raise ValueError(
                    f'pace: {pace} has no effect in process, where scans come as they are taken; use over="websocket"'
                )
            loaded = scene if isinstance(scene, Scene) else load_scene(scene)
            return ProcessFeed(loaded.for_radar(radar), seed, fidelity, request)
        if over != "websocket":
            raise ValueError(f'over: "{over}" is not one of process, websocket')
        if isinstance(scene, Scene):
            raise ValueError("scene: a service reads a file or a mapping, not a Scene; give what you loaded it from")
        ids = [entry.id for entry in radar_entries(model_from(scene).radar)]
        feed = WebsocketFeed(scene, seed, pace, fidelity, request, known_radar(radar, ids), ids)
        self._ending.callback(feed.close)
        return feed

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._ending.close()


class ProcessFeed(RadarFeed):
    """A RadarFeed of a simulator in this process."""

    def __init__(self, scene: Scene, seed: int, fidelity: str, request: SourceRequest) -> None:
        self.simulator = Simulator(scene, fidelity, seed, labels=request.labels, powers=request.powers)
        self.crossings: list[Crossing] = []
        self._snapshots: list[Snapshot] = []
        self._taken = 0

    @property
    @override
    def label_names(self) -> dict[int, str]:
        return self.simulator.label_names

    @override
    def scans(self, count: int) -> Iterator[Scan]:
        for _ in range(count):
            scan = self.simulator.scan()
            self.crossings += self.simulator.crossings(scan.number)
            self._taken = scan.number + 1
            yield scan

    @property
    @override
    def snapshots(self) -> Sequence[Snapshot]:
        """All snapshots so far, computed at first use."""
        self._snapshots += map(self.simulator.snapshot, range(len(self._snapshots), self._taken))
        return self._snapshots


class RemoteFeed:
    """A RadarFeed of a service that runs, which waits for this client (mode `lossless`). hello: of the feed."""

    def __init__(
        self, address: str, radar: str = "0", labels: bool = False, powers: PowersOf = (), truth: bool = True
    ) -> None:  # fmt: skip
        """address: of the service, as 127.0.0.1:8000; it is started with --truth, but where `truth` is False. A radar on the air
        begins with its next whole scan. labels, powers: as RadarFeeds. Raises RuntimeError for a service that refuses, and
        OSError."""
        request = source_request(labels, powers)
        self.address, self._radar = address, radar
        self.crossings: list[Crossing] = []
        self.snapshots: list[Snapshot] = []
        self._ending = ExitStack()
        try:
            self._truth = self._connection("truth/stream") if truth else None  # before the feed, which releases spoke 0
            query = ("&labels=1" if request.labels else "") + (
                f"&powers={text_of(request.powers)}" if request.powers else ""
            )
            self._feed = self._connection(f"feed?encoding=c64&mode=lossless{query}")
            self.hello = self._message()
        except BaseException:
            self.close()
            raise
        self._blocks: list[SpokeBlock] = []

    @property
    def label_names(self) -> dict[int, str]:
        """The names of sources by rising number; empty without labels and powers."""
        return {source["number"]: source["name"] for source in self.hello.get("sources", ())}

    def scans(self, count: int) -> Iterator[Scan]:
        """Yields the next scans. Raises RuntimeError where the service ends the feed, or leaves out spokes."""
        for _ in range(count):
            blocks, azimuths = self._blocks, self.hello["radar"]["azimuths"]
            while not blocks or blocks[-1].index + len(blocks[-1]) < azimuths:
                block = self._block(self._message())
                if blocks or block.index == 0:  # the rest of a scan that began before this client came has no use
                    blocks.append(block)
            self._blocks = []
            scan = _as_reported(scan_of(blocks), blocks)
            self._read_truth(scan.number)
            yield scan

    def close(self) -> None:
        """Disconnects."""
        self._ending.close()

    def _connection(self, path: str) -> ClientConnection:
        url = f"ws://{self.address}/api/radars/{self._radar}/{path}"
        return self._ending.enter_context(
            connect(url, max_size=wire.MAX_MESSAGE, compression=None, close_timeout=CLOSE_TIMEOUT)
        )

    def _message(self) -> dict[str, Any]:
        """The next message of the feed, a hello or spokes."""
        message = wire.unpack(bytes(self._feed.recv(RECEIVE_TIMEOUT, decode=False)))
        if message["type"] not in ("hello", "spokes"):
            raise RuntimeError(f"the feed sent {message['type']}: {message.get('reason')}")
        return message

    def _block(self, message: Mapping[str, Any]) -> SpokeBlock:
        rows, azimuths = SpokeRows.of(dict(message)), self.hello["radar"]["azimuths"]
        boresight = rows.index * (2.0 * np.pi / azimuths)
        error = wrap_angle(rows.azimuth - boresight)
        return SpokeBlock(
            first=message["scan"] * azimuths + message["index"], scan=message["scan"], index=message["index"],
            time=rows.time, azimuth=boresight + np.where(np.abs(error) < HALF_UNIT, 0.0, error), heading=rows.heading,
            course=rows.course, speed=rows.speed, position=rows.position, range=rows.range, range_step=rows.range_step,
            field=rows.samples, power=square_law(rows.samples), labels=rows.labels, powers=rows.powers,
        )  # fmt: skip

    def _read_truth(self, scan: int) -> None:
        """Reads the truth up to the end of a scan."""
        while self._truth and (not self.snapshots or self.snapshots[-1].scan < scan):
            line = json.loads(self._truth.recv(RECEIVE_TIMEOUT))
            if line["type"] == "crossing":
                self.crossings.append(crossing_from_line(line))
            elif line["type"] == "snapshot":
                self.snapshots.append(snapshot_from_line(line))
            elif line["type"] == "bye":
                raise RuntimeError(f"the truth ended: {line['reason']}")


class WebsocketFeed(RemoteFeed):
    """A RemoteFeed of a service in a process of its own."""

    def __init__(
        self, scene: str | Path | Mapping[str, Any], seed: int, pace: float | str, fidelity: str, request: SourceRequest,
        radar: str, radars: Sequence[str],
    ) -> None:  # fmt: skip
        """radar: which of the scene's radars."""
        self._service = ExitStack()
        address = self._service.enter_context(service(scene, seed, pace, fidelity)).address
        super().__init__(address, radar, request.labels, request.powers)
        release(address, [other for other in radars if other != radar])

    def close(self) -> None:
        """Disconnects and ends the service."""
        super().close()
        self._service.close()


def _as_reported(scan: Scan, blocks: Sequence[SpokeBlock]) -> Scan:
    """A scan with the azimuths of its blocks, which errors on purpose may have moved off the boresights."""
    azimuth = np.concatenate([block.azimuth for block in blocks])
    return scan if len(azimuth) != len(scan.azimuth) else replace(scan, azimuth=azimuth)


def crossing_from_line(line: Mapping[str, Any]) -> Crossing:
    """Returns the crossing of a line of the truth, whose lists become tuples. In recordings of earlier versions the boresight
    is level."""
    own_ship = OwnShipTruth(**tupled(line["own_ship"]))
    content = {"boresight": line["bearing"]} | tupled(line)
    if "false_echoes" in line:
        content["false_echoes"] = tuple(FalseEcho(**echo) for echo in line["false_echoes"])
    of_effects = _of_effects(line, Crossing)
    of_effects |= {each.name: each.crossing_record(**line[each.name]) for each in effects_named(of_effects)}
    rest = {key: value for key, value in content.items() if key not in ("type", "own_ship", *of_effects)}
    return Crossing(**rest, own_ship=own_ship, effects=of_effects)


def snapshot_from_line(line: Mapping[str, Any]) -> Snapshot:
    """Returns the snapshot of a line of the truth."""
    errors = line.get("feed_errors")
    return Snapshot(
        scan=line["scan"], time=line["time"], radar=line["radar"], own_ship=OwnShipTruth(**tupled(line["own_ship"])),
        bodies=tuple(Kinematics(**tupled(body)) for body in line["bodies"]),
        feed_errors=errors and FeedErrorCounts(**errors),
        effects=_of_effects(line, Snapshot),
    )  # fmt: skip


def _of_effects(line: Mapping[str, Any], kind: type[Crossing | Snapshot]) -> dict[str, Any]:
    """What effects tell in a line, also those that are not installed here: all that the record has no field for."""
    known = {"type", *(field.name for field in fields(kind))}
    return {key: line[key] for key in line if key not in known}


def own_ships(feed: str) -> Iterator[OwnShip]:
    """Yields own ship at each message of a feed, until it ends."""
    with connect(f"{feed}?bins=1", max_size=wire.MAX_MESSAGE, compression=None) as messages:
        for message in messages:
            fields = wire.unpack(bytes(message))  # type: ignore[arg-type]
            if fields["type"] == "spokes":
                rows = SpokeRows.of(fields)
                position = rows.position[-1].tolist()
                yield {
                    "time": float(rows.time[-1]), "east": position[0], "north": position[1],
                    "heading": float(rows.heading[-1]), "course": float(rows.course[-1]), "speed": float(rows.speed[-1]),
                }  # fmt: skip


def release(address: str, radars: Sequence[str]) -> None:
    """Connects to radars and leaves them: a group waits for a client of each. Raises RuntimeError where one is not reached."""
    for radar in radars:
        try:
            with connect(f"ws://{address}/api/radars/{radar}/feed", close_timeout=CLOSE_TIMEOUT) as client:
                client.recv(RECEIVE_TIMEOUT)
        except (OSError, EOFError, WebSocketException) as error:
            raise RuntimeError(f"radar {radar} cannot be reached: {error}") from None


@dataclass(frozen=True)
class RunningService:
    """A service of this machine. address: as 127.0.0.1:8000; errors: of what it writes to its standard error."""

    address: str
    process: "subprocess.Popen[str]"
    errors: TextIO

    @property
    def end(self) -> str | None:
        """How it has ended, with its last words; None where it runs."""
        if self.process.poll() is None:
            return None
        self.errors.seek(0)
        return f"exit status {self.process.returncode}; {self.errors.read().strip()[-LAST_WORDS:]}".rstrip("; ")


@contextmanager
def service(
    scene: str | Path | Mapping[str, Any], seed: int, pace: float | str, fidelity: str, options: Sequence[str] = ("--truth",)
) -> Iterator[RunningService]:
    """Runs a service on a free port, which waits for one client. options: further ones of `serve`.

    Raises RuntimeError with what the service says where it does not start.
    """
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "errors").open("w+") as errors:
        if isinstance(scene, Mapping):
            (path := Path(folder) / "scene.json").write_text(json.dumps(scene))
            scene = path
        command = [
            sys.executable, "-m", "radar_service", "serve", str(scene), "--port", "0", "--seed", str(seed), "--pace", str(pace),
            "--fidelity", fidelity, "--wait-for", "1", *options,
        ]  # fmt: skip
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True) as process:
            assert process.stdout is not None
            try:
                _, start, address = _first_line(process.stdout).partition("open http://")
                if not start:
                    status = process.wait(STOP_TIMEOUT)
                    errors.seek(0)
                    raise RuntimeError(f"the service did not start: {errors.read().strip() or f'exit status {status}'}")
                yield RunningService(address.strip().rstrip("/"), process, errors)
            finally:
                process.terminate()
                try:
                    process.wait(STOP_TIMEOUT)
                except subprocess.TimeoutExpired:
                    process.kill()


def _first_line(output: IO[str]) -> str:
    """The first line of a program's output; "" where it ends. Raises RuntimeError where there is none in time."""
    lines: Queue[str] = Queue()
    Thread(target=lambda: lines.put(output.readline()), daemon=True).start()
    try:
        return lines.get(timeout=START_TIMEOUT)
    except Empty:
        raise RuntimeError(f"the service did not start: it has not told its address within {START_TIMEOUT:g} s") from None

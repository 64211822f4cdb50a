"""A radar for tests of trackers: scans, and the truth of their beam crossings, computed in process or received from a service."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Protocol, Self

import numpy as np
from websockets.sync.client import ClientConnection, connect

from radar_service.cell_sources import PowersOf, SourceRequest, source_request, text_of
from radar_service.receive.detection import square_law
from radar_service.records import Crossing, OwnShipTruth, SpokeBlock
from radar_service.scan import Scan, scan_of
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene
from radar_service.simulator import Simulator
from radar_service.stream.codecs.native import wire

RECEIVE_TIMEOUT = 60.0  # s until the next message
STOP_TIMEOUT = 20.0  # s
Source = str | Path | Mapping[str, Any] | Scene


class RadarFeed(Protocol):
    """A radar from its first scan on.

    crossings: of all scans that were taken so far, by time; label_names: of the sources, by the numbers that labels have.
    """

    crossings: list[Crossing]

    @property
    def label_names(self) -> dict[int, str]:
        """By rising number."""

    def scans(self, count: int) -> Iterator[Scan]:
        """Yields the next scans; the crossings of each are known when it comes."""


class RadarFeeds:
    """Makes radars, and ends them as a context manager."""

    def __init__(self) -> None:
        self._ending = ExitStack()

    def __call__(
        self, scene: Source, seed: int = 0, pace: float | Literal["max"] = "max",
        over: Literal["process", "websocket"] = "process", fidelity: str = "auto",
        labels: bool = False, powers: PowersOf = (),
    ) -> RadarFeed:  # fmt: skip
        """Returns a radar from its spoke 0 on.

        scene: a file, the name of a packaged scene, a mapping, or in process a Scene. over: "process" computes a scan when it
        is taken; "websocket" starts a service on a free port of this machine. pace: simulated seconds per second of a service.
        labels: whether scans have the strongest source of each cell; powers: `all`, or the numbers of the sources whose power
        they have.
        Raises ValueError for a value that is not allowed, SceneError, and RuntimeError where a service does not start.
        """
        request = source_request(labels, powers)
        if over == "process":
            if pace != "max":
                raise ValueError(
                    f'pace: {pace} has no effect in process, where scans come as they are taken; use over="websocket"'
                )
            return ProcessFeed(scene if isinstance(scene, Scene) else load_scene(scene), seed, fidelity, request)
        if over != "websocket":
            raise ValueError(f'over: "{over}" is not one of process, websocket')
        if isinstance(scene, Scene):
            raise ValueError("scene: a service reads a file or a mapping, not a Scene; give what you loaded it from")
        feed = WebsocketFeed(scene, seed, pace, fidelity, request)
        self._ending.callback(feed.close)
        return feed

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._ending.close()


class ProcessFeed:
    """A RadarFeed of a simulator in this process."""

    def __init__(self, scene: Scene, seed: int, fidelity: str, request: SourceRequest) -> None:
        self.simulator = Simulator(scene, fidelity, seed, labels=request.labels, powers=request.powers)
        self.crossings: list[Crossing] = []

    @property
    def label_names(self) -> dict[int, str]:
        """As RadarFeed.label_names."""
        return self.simulator.label_names

    def scans(self, count: int) -> Iterator[Scan]:
        """As RadarFeed.scans."""
        for _ in range(count):
            scan = self.simulator.scan()
            self.crossings += self.simulator.crossings(scan.number)
            yield scan


class WebsocketFeed:
    """A RadarFeed of a service in a process of its own. address: of the service, as 127.0.0.1:8000; hello: of the feed."""

    def __init__(
        self, scene: str | Path | Mapping[str, Any], seed: int, pace: float | str, fidelity: str, request: SourceRequest
    ) -> None:
        self.crossings: list[Crossing] = []
        self._ending = ExitStack()
        try:
            self.address = self._ending.enter_context(service(scene, seed, pace, fidelity))
            self._truth = self._connection("truth/stream")  # before the feed, which releases spoke 0
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
        """As RadarFeed.label_names; empty without labels and powers."""
        return {source["number"]: source["name"] for source in self.hello.get("sources", ())}

    def scans(self, count: int) -> Iterator[Scan]:
        """As RadarFeed.scans. Raises RuntimeError where the service ends the feed, or leaves out spokes."""
        for _ in range(count):
            blocks, whole = self._blocks, self.hello["radar"]["azimuths"]
            while not blocks or blocks[-1].index + len(blocks[-1]) < whole:
                blocks.append(self._block(self._message()))
            self._blocks = []
            scan = scan_of(blocks)
            self._read_crossings(scan.number)
            yield scan

    def close(self) -> None:
        """Disconnects and ends the service."""
        self._ending.close()

    def _connection(self, path: str) -> ClientConnection:
        url = f"ws://{self.address}/api/radars/0/{path}"
        return self._ending.enter_context(connect(url, max_size=wire.MAX_MESSAGE, compression=None))

    def _message(self) -> dict[str, Any]:
        """The next message of the feed, a hello or spokes."""
        message = wire.unpack(bytes(self._feed.recv(RECEIVE_TIMEOUT, decode=False)))
        if message["type"] not in ("hello", "spokes"):
            raise RuntimeError(f"the feed sent {message['type']}: {message.get('reason')}")
        return message

    def _block(self, message: Mapping[str, Any]) -> SpokeBlock:
        field, azimuths = wire.samples(dict(message)), self.hello["radar"]["azimuths"]
        number = message["scan"] * azimuths + message["index"]
        angles = {key: wire.radians_from_turn(message[key]) for key in ("heading", "course")}
        values: dict[str, Any] = angles | {key: np.array(message[key]) for key in ("time", "position", "speed")}
        index = message["index"] + np.arange(len(field))
        cells = np.arange(message["bins"], dtype=np.float64)
        return SpokeBlock(
            first=number, scan=message["scan"], index=message["index"], azimuth=index * (2.0 * np.pi / azimuths),
            range=message["range_first_m"] + cells * message["range_step_m"], range_step=message["range_step_m"], field=field,
            power=square_law(field), labels=wire.labels(dict(message)), powers=wire.powers(dict(message)), **values,
        )  # fmt: skip

    def _read_crossings(self, scan: int) -> None:
        """Reads the truth up to the end of a scan."""
        while (line := json.loads(self._truth.recv(RECEIVE_TIMEOUT)))["type"] != "snapshot" or line["scan"] < scan:
            if line["type"] == "crossing":
                self.crossings.append(crossing_from_line(line))
            elif line["type"] == "bye":
                raise RuntimeError(f"the truth ended: {line['reason']}")


def crossing_from_line(line: Mapping[str, Any]) -> Crossing:
    """Returns the crossing of a line of the truth, whose lists become tuples."""
    own_ship = OwnShipTruth(**_tupled(line["own_ship"]))
    return Crossing(
        **{key: value for key, value in _tupled(line).items() if key not in ("type", "own_ship")}, own_ship=own_ship
    )


def _tupled(line: Mapping[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in line.items()}


@contextmanager
def service(scene: str | Path | Mapping[str, Any], seed: int, pace: float | str, fidelity: str) -> Iterator[str]:
    """Runs a service on a free port, which waits for one client, and gives its address.

    Raises RuntimeError with what the service says where it does not start.
    """
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "errors").open("w+") as errors:
        if isinstance(scene, Mapping):
            (path := Path(folder) / "scene.json").write_text(json.dumps(scene))
            scene = path
        command = [
            sys.executable, "-m", "radar_service", "serve", str(scene), "--port", "0", "--seed", str(seed), "--pace", str(pace),
            "--fidelity", fidelity, "--truth", "--wait-for", "1",
        ]  # fmt: skip
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True) as process:
            assert process.stdout is not None
            try:
                _, start, address = process.stdout.readline().partition("open http://")
                if not start:
                    process.wait(STOP_TIMEOUT)
                    errors.seek(0)
                    raise RuntimeError(f"the service did not start: {errors.read().strip()}")
                yield address.strip().rstrip("/")
            finally:
                process.terminate()

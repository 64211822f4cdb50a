"""A simulator that computes nothing: every cell says which spoke and bin it is."""

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from radar_service.processes.call import Progress
from radar_service.records.cell_sources import PowersOf, SourceList, SourceRequest
from radar_service.records.fidelity import Fidelity
from radar_service.records.spokes import SpokeBlock
from radar_service.records.truth import BodyTruth, Crossing, OwnShipTruth, ShipStates, Snapshot, Truth
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.scene_process_main import scene_of
from radar_service.service.scene_request import SceneRequest
from radar_service.spoke_source import SpokeSourceInfo, TruthLine
from radar_service.world.commands import Command
from radar_service.world.scene import Scene, outline_of, scene_at_rpm

AZIMUTHS, BINS, STEP = 24, 20, 10.0
OWN_SHIP = OwnShipTruth(
    position=(0, 0, 0), velocity=(0, 0, 0), heading=0.5, course=0.5, speed=0.0, roll=0.0, pitch=0.0, yaw=0.0
)
KINEMATICS: dict[str, Any] = {
    **dict.fromkeys(("time", "range", "bearing", "relative_bearing", "elevation", "course", "speed", "heading"), 0.0),
    **dict.fromkeys(("turn_rate", "aspect", "cpa", "length", "beam"), 0.0),
    **dict.fromkeys(("mmsi", "latitude_deg", "longitude_deg", "tcpa")),
    "radar": "0", "body": "buoy", "position": (0, 0, 0), "velocity": (0, 0, 0), "visible": True, "reason": "",
}  # fmt: skip


SOURCES = {0: "noise", 1: "sea", 256: "buoy"}
SAMPLING = 299_792_458.0 / (2.0 * STEP)
RADAR: dict[str, Any] = {
    "azimuths": AZIMUTHS, "range_max_m": BINS * STEP, "bandwidth_hz": SAMPLING / 1.5, "sample_rate_hz": SAMPLING,
    "blind_sectors_deg": [[80, 100]], "coarse_azimuths": True,
}  # fmt: skip


def scene(name: str = "test scene", **radar: Any) -> Scene:
    """A scene without bodies: 24 spokes a scan, 20 bins of 10 m, blind from 080 to 100 degrees off the bow."""
    return load_scene({"name": name, "radar": RADAR | radar, "own_ship": {"heading_deg": 30}})


def scene_of_several(*ids: str, name: str = "test scene") -> Scene:
    """The same with a radar of each id; the first has 24 rpm, each other 12 rpm more than the one before."""
    radars = [RADAR | {"id": each, "rpm": 24 + 12 * number} for number, each in enumerate(ids)]
    return load_scene({"name": name, "radar": radars, "own_ship": {"heading_deg": 30}})


def steerable_scene(name: str = "steerable") -> Scene:
    """The test scene with own ship and a buoy that may be steered, and a rock that may not."""
    of = scene(name)
    bodies = [
        {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 100, 5], "steerable": {"max_speed_kn": 20}},
        {"name": "the rock/1", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 150, 5]},
    ]
    other = load_scene({"name": name, "own_ship": {"steerable": {}}, "body": bodies})
    return replace(of, world=other.world, platform=other.platform)


def commanded(
    worker: SpokeWorker, spoke: int | None, body: str | None, values: Mapping[str, Any], time: float | None = None
) -> Command:
    """Commands what a worker runs; returns the command."""
    command = worker.commands.command(spoke, body, values, time)
    worker.command(command)
    worker.tell()
    return command


class FakeEngine:
    """Spoke n has power (n + 1) x (bin + 1) nW, and a field of that magnitude; blocks of at most 5.

    dies_at: number of the spoke at which it fails. turns: where given, one permit is taken before each block.
    """

    def __init__(self, of: Scene, dies_at: int | None = None, turns: threading.Semaphore | None = None) -> None:
        self.scene_request = SceneRequest(of)
        self.closed, self.trees = False, 3
        self.scene, self.noise_power = of, 1e-15
        self.fidelity, self.plan = Fidelity("balanced"), dict[str, Any](modelled=[])
        self.range_step = of.radar.range_step
        self.range = (np.arange(of.radar.bins) + 0.5) * self.range_step
        self.blocks_made = 0
        self._dies_at, self._turns = dies_at, turns
        self._first = self._next = 0
        self.commands: list[Command] = []
        self.sources, self.requests = SourceList(SOURCES), 0
        self._request = SourceRequest()
        self._made = threading.Condition()

    @property
    def info(self) -> SpokeSourceInfo:
        return self.described(self.plan)

    @property
    def unmeasured_info(self) -> SpokeSourceInfo:
        return self.described({})

    def described(self, plan: Mapping[str, Any]) -> SpokeSourceInfo:
        return SpokeSourceInfo(
            outline_of(self.scene), 7, self.fidelity, plan, self.noise_power, self.range, self.range_step,
            self.sources,
        )  # fmt: skip

    def blocks(self, scans: int | None = None, size: int = 16) -> Iterator[SpokeBlock]:
        self._next = self._first * self.scene.radar.azimuths
        while scans is None or self._next < scans * self.scene.radar.azimuths:
            if self._turns:
                self._turns.acquire()
            with self._made:
                index = self._next % self.scene.radar.azimuths
                block = self.block(self._next, min(5, size, self.scene.radar.azimuths - index))
                self._next += len(block)
                self.blocks_made += 1
                self._made.notify_all()
            yield block

    def take(self, command: Command) -> None:
        """Goes back to its spoke, as a source does whose blocks are computed ahead."""
        with self._made:
            self.commands.append(command)
            self._next = min(self._next, command.spoke)

    def request_sources(self, labels: bool = False, powers: PowersOf = (), spoke: int | None = None) -> None:
        """Goes back to that spoke, as `take` does."""
        with self._made:
            self._request, self.requests = SourceRequest(labels, powers), self.requests + 1
            self._next = self._next if spoke is None else min(self._next, spoke)

    def replay(self, commands: Iterable[Command]) -> None:
        self.commands = list(commands)

    def wait_for_blocks(self, count: int, timeout: float) -> None:
        """Waits until so many blocks were made. Raises AssertionError after `timeout` [s]."""
        with self._made:
            assert self._made.wait_for(lambda: self.blocks_made >= count, timeout)

    def skip_to(self, scan: int) -> None:
        self._first = scan

    def block(self, number: int, count: int) -> SpokeBlock:
        if self._dies_at is not None and number + count > self._dies_at:
            raise RuntimeError("the wheel came off")
        radar = self.scene.radar
        n = number + np.arange(count)
        index = number % radar.azimuths
        power = power_of(n, self.range.size)
        time = radar.time_of_spokes(n.astype(np.float64))
        own = self.scene.own_ship.pose(time)
        return SpokeBlock(
            number, number // radar.azimuths, index, time, (index + np.arange(count)) * radar.azimuth_step,
            own.heading, own.position[:, :2], own.course, own.speed, self.range, self.range_step,
            (np.sqrt(power) * 1j).astype(np.complex64), power, len(self.commands), requests=self.requests,
            labels=labels_of(n, self.range.size) if self._request.labels else None,
            powers={256: power} if self._request.powers else None,
        )  # fmt: skip

    def set_errors(self, tables: Mapping[str, Any] | None) -> None:
        assert tables is None, "the serving process adds errors"

    def truth(self, t: float) -> Truth:
        own = BodyTruth(
            "own ship", (0, 0, 0), (0, 0, 0), 0.5, 0.5, 0.0, 0.0, 0.0, 0.0, True, "", None, None, None, 0.0
        )  # fmt: skip
        return Truth(t, own, (replace(own, name="buoy"),))

    def ship_states(self, times: Sequence[float], names: Sequence[str | None]) -> list[ShipStates]:
        return self.scene.ship_states(times, names)

    def crossings(self, scan: int | None = None, radiometric: bool = False) -> tuple[Crossing, ...]:
        """Two in each scan: between the spokes 8 and 9, and 16 and 17; with an SNR of 20 dB where that is asked for."""
        period = self.scene.radar.rotation_period
        return tuple(
            Crossing(scan=scan or 0, spoke=round((scan or 0) * AZIMUTHS + AZIMUTHS * share), own_ship=OWN_SHIP,
                     boresight=2.0 * np.pi * share, snr_db=20.0 if radiometric else None,
                     **KINEMATICS | {"time": ((scan or 0) + share) * period})
            for share in (8.5 / AZIMUTHS, 16.5 / AZIMUTHS)
        )  # fmt: skip

    def snapshot(self, scan: int | None = None) -> Snapshot:
        time = ((scan or 0) + 1) * self.scene.radar.rotation_period
        return Snapshot(scan=scan or 0, time=time, radar="0", own_ship=OWN_SHIP, bodies=())

    def truth_header(self) -> dict[str, Any]:
        return {"type": "header", "scene": self.scene.name}

    def truth_lines(self, scan: int | None, radiometric: bool = False) -> list[TruthLine]:
        if scan is None:
            return [TruthLine.of_content(0.0, self.truth_header())]
        return [*map(TruthLine.of, self.crossings(scan, radiometric)), TruthLine.of(self.snapshot(scan))]

    def spare(self) -> None:
        return None

    def close(self) -> None:
        self.closed = True


def dying(of: Scene) -> FakeEngine:
    """An engine that fails at its twentieth spoke; another process finds it by its name."""
    return FakeEngine(of, dies_at=20)


def power_of(number: Any, bins: int) -> Any:
    """Power (K, bins) of the spokes of these numbers [W]."""
    return (1e-9 * (np.asarray(number)[:, None] + 1.0) * (np.arange(bins) + 1.0)).astype(np.float32)


def labels_of(number: Any, bins: int) -> Any:
    """Labels (K, bins) of the spokes of these numbers: the sources of SOURCES in turn."""
    return np.array(list(SOURCES), dtype=np.uint32)[(np.asarray(number)[:, None] + np.arange(bins)) % len(SOURCES)]


def factory(**options: Any) -> Callable[[SceneRequest, Progress], FakeEngine]:
    """Makes fake engines in this process; that of a test scene for an order of one."""
    return made_by(lambda of: FakeEngine(of, **options))


def scene_in(order: SceneRequest) -> Scene:
    """The scene of an order; orders of fake engines hold it."""
    if not isinstance(order.scene_input, Scene):
        return scene_of(order)
    of = order.scene_input.for_radar(order.radar)
    return of if order.rpm is None else scene_at_rpm(of, order.rpm)


def made_by(make: Callable[[Scene], FakeEngine]) -> Callable[[SceneRequest, Progress], FakeEngine]:
    """Makes engines in this process by `make`."""

    def ordered(order: SceneRequest, progress: Progress) -> FakeEngine:
        engine = make(scene_in(order))
        engine.scene_request = order
        return engine

    return ordered

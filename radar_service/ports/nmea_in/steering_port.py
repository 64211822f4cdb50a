"""The port of NMEA in: sentences of another simulator become poses of own ship, one command at a time.

The helm: the first sender holds it until that is silent.
"""

import asyncio
import contextlib
import logging
import math
import selectors
import threading
import time
from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any, NamedTuple

import numpy as np

from radar_service.ports.nmea_in.receivers import Receiver
from radar_service.ports.nmea_in.sentence_reader import Reading, SentenceIgnoredError, read
from radar_service.ports.port import Port, Service
from radar_service.ports.port_thread import described
from radar_service.ports.udp.udp_port import station_of
from radar_service.service.logs import Refusals, log_event
from radar_service.service.poses import CommandedPose
from radar_service.service.radio.command_worker import NoRadarError, TooManyCommandsError
from radar_service.service.radio.station import Station, Stations
from radar_service.spoke_source import SpokeSourceFault, TellsShips
from radar_service.terminal import UsageError
from radar_service.world import Command, CommandError, SceneOutline, map_bearing, map_from_geographic

SILENCE = 3.0  # s after which another sender may steer, and clocks may have been set back
DAY = 86_400.0  # s
LOOK = 0.1  # s between two looks at whether the port ends
ANSWER = 0.01  # s between two looks at whether the last command was carried out
POSES = 20.0  # a second at most: each costs a block that is computed anew, and a world takes a million
BETWEEN = 0.005  # s between two readings: so a flood takes a few per cent of a core
BY, OPTION = "nmea", "--nmea-of"
ANGLES = ("heading_deg", "course_deg")
JUMP, FASTEST = 100.0, 50.0  # m and m/s: from so far on, and faster than that, own ship jumps
FRESH = 1.0  # s: how old a position may be at which true north is taken


class HelmOrder(NamedTuple):
    """motion: heading, course and speed of all sentences so far, by the keys of a command; position: of the newest one alone,
    latitude and longitude [degrees, WGS 84], or None."""

    motion: dict[str, float]
    position: tuple[float, float] | None


class Helm:
    """holder: the sender that steers, or was the last one to do so."""

    def __init__(self) -> None:
        self.holder: Hashable = None
        self._heard = -math.inf  # when the holder was followed
        self._motion: dict[str, float] = {}
        self._clock = (0.0, -math.inf)  # of the newest sentence with a time, and when it came

    def hear(self, sender: Hashable, reading: Reading, now: float) -> HelmOrder:
        """Returns what a sentence orders that arrives now [s]. Raises SentenceIgnoredError: holder, past."""
        if now - self._heard >= SILENCE:
            self.holder, self._motion, self._clock = sender, {}, (0.0, -math.inf)
        elif sender != self.holder:
            raise SentenceIgnoredError("holder")
        if reading.clock is not None:
            self._follow_clock(reading.clock, now)
        self._heard = now
        self._motion = self._motion | reading.motion
        return HelmOrder(self._motion, reading.position)

    def _follow_clock(self, clock: float, now: float) -> None:
        """Notes the time of a sentence; one that is up to half a day earlier than another one shortly before is of the past."""
        before, came = self._clock
        if now - came < SILENCE and 0.0 < (before - clock) % DAY < DAY / 2:
            raise SentenceIgnoredError("past")
        self._clock = clock, now


class NmeaSteering:
    """Steers own ship of one radar. One thread calls it.

    station: the radar, which another scene may replace; refused: counts what is not followed, as `nmea-` and a word.
    """

    def __init__(self, station: Station, refused: Refusals, clock: Callable[[], float] = time.monotonic) -> None:
        """clock: of the arrival of sentences [s]."""
        self.station, self._refused, self._clock = station, refused, clock
        self._helm = Helm()
        self._values: dict[str, Any] = {}  # of the next pose
        self._at = 0.0  # its simulated time
        self._answer: Future[Command] | None = None  # to the last one
        self._next = -math.inf  # when the next pose may be sent
        self._place, self._placed = (0.0, 0.0), -math.inf  # position of own ship [m], and when it was so
        self._ordered, self._jump = ((0.0, 0.0), -math.inf), 0.0  # last position that was sent and when, and how far it lay
        self._has_failed = False
        self._unfit: SceneOutline | None = None

    @property
    def waits(self) -> bool:
        """Whether a pose waits for the answer to the one before."""
        return bool(self._values)

    def count(self, word: str, times: int = 1) -> None:
        """Counts what was not followed."""
        if times:
            self._refused(f"nmea-{word}", times)

    def hear(self, sender: str, lines: Sequence[bytes]) -> None:
        """Takes lines of a sender, which arrive now."""
        for line in lines:
            holder = self._helm.holder
            try:
                order = self._helm.hear(sender, read(line), self._clock())
            except SentenceIgnoredError as reason:
                self.count(str(reason))
                continue
            if self._helm.holder != holder:
                log_event("own ship steered", radar=self.station.identity, by=f"{BY} {sender}")
            self._note(order)

    def steer(self) -> None:
        """Sends the pose that the sentences make, unless the one before was not answered yet, or has only just been sent."""
        if self._answer is not None:
            if not self._answer.done():
                return
            error, self._answer = self._answer.exception(), None
            self._tell(error)
            if error is None and self._jump:
                log_event("own ship jumped", radar=self.station.identity, by=BY, distance_m=round(self._jump))
        if self._values and self._clock() >= self._next:
            self._jump = self._jumped(self._values["position_m"]) if "position_m" in self._values else 0.0
            pose, self._values = CommandedPose(None, self._at, self._on_map(self._values)), {}
            self._next = self._clock() + 1.0 / POSES
            try:
                self._answer = self.station.commands.put(None, pose.values_at, by=BY)
            except (NoRadarError, TooManyCommandsError) as error:
                self._tell(error)

    def _note(self, order: HelmOrder) -> None:
        """Adds an order to the next pose, which holds at the time when its position came."""
        scene = self.station.epoch.info.scene
        if unfitness(scene):
            self.count("scene")
            if self._unfit is not scene:
                self._unfit = scene
                log_event("sentences not followed", logging.WARNING, radar=self.station.identity, reason=unfitness(scene))
            return
        if order.position is not None and scene.origin is not None:
            self._values["position_m"] = tuple(map_from_geographic(*order.position, scene.origin).tolist())
        if order.position is not None or "position_m" not in self._values:
            self._at = self.station.transmitter.state.simulated
        self._values |= order.motion

    def _on_map(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values of a pose with angles from the map's north: those of sentences count from true north at own ship."""
        origin, angles = self.station.epoch.info.scene.origin, [key for key in ANGLES if key in values]
        if origin is None or not angles:
            return dict(values)
        place = values.get("position_m")  # of this pose alone: it may be refused
        if place is None:
            place = self._own_place()
        bearings = map_bearing(np.deg2rad([values[key] for key in angles]), np.array(place), origin)
        return {**values, **dict(zip(angles, np.rad2deg(bearings).tolist(), strict=True))}

    def _own_place(self) -> tuple[float, float]:
        """Where own ship is [m], no longer than FRESH ago."""
        source = self.station.epoch.spoke_source
        if self._clock() - self._placed > FRESH and isinstance(source, TellsShips):
            with contextlib.suppress(SpokeSourceFault):  # its process is being replaced: the last one will do
                (states,) = source.ship_states([self.station.transmitter.state.simulated], [None])
                east, north, _ = states.position[0].tolist()
                self._place, self._placed = (east, north), self._clock()
        return self._place

    def _jumped(self, place: tuple[float, float]) -> float:
        """How far a position lies from where own ship is [m]; 0 where a ship may come there by itself."""
        now, (before, sent) = self._clock(), self._ordered
        if now - sent > SILENCE:
            before, sent = self._own_place(), now
        self._ordered = place, now
        distance = math.dist(place, before)
        return distance if distance > JUMP + FASTEST * (now - sent) else 0.0

    def _tell(self, error: BaseException | None) -> None:
        """Counts a pose that was refused, and logs the first one of several."""
        if error is not None:
            self.count("refused")
        if error is not None and not self._has_failed:
            log_event("own ship not steered", logging.WARNING, radar=self.station.identity, reason=str(error))
        self._has_failed = error is not None


def unfitness(scene: SceneOutline) -> str:
    """Why sentences cannot steer own ship of a scene, with the remedy; empty where they can."""
    try:
        scene.steerable.limits_of(None)
    except CommandError as error:
        return str(error)
    return "" if scene.origin else "the scene has no origin for positions; add an [origin] table with latitude and longitude"


class SteeringPort(Port):
    """Sockets whose sentences steer own ship: of the first radar, or of `radar`."""

    name = "nmea-in"

    def __init__(self, receivers: Sequence[Receiver], radar: str | None = None) -> None:
        self._receivers, self._radar = receivers, radar
        self._stations, self._ends = Stations(), threading.Event()
        self._thread: threading.Thread | None = None

    def check(self, stations: Mapping[str, Station]) -> None:
        """Looks for a ship to steer."""
        if reason := unfitness(station_of(OPTION, stations, self._radar).epoch.info.scene):
            raise UsageError(f"--nmea-in: {reason}")

    async def start(self, service: Service) -> None:
        """Begins to take sentences."""
        self._stations, station = service.stations, station_of(OPTION, service.stations, self._radar)
        steering = NmeaSteering(station, service.refused)
        self._thread = threading.Thread(target=self._run, args=(steering,), name="nmea in", daemon=True)
        self._thread.start()

    async def stop(self) -> None:
        """Takes no more sentences."""
        self._ends.set()
        if self._thread is not None:
            await asyncio.to_thread(self._thread.join)

    def close(self) -> None:
        """Closes all sockets."""
        for receiver in self._receivers:
            with contextlib.suppress(OSError):
                receiver.close()

    def _run(self, steering: NmeaSteering) -> None:
        while not self._ends.wait(BETWEEN):
            try:
                self._wait(ANSWER if steering.waits else LOOK)
                for receiver in self._receivers:
                    for sender, lines in receiver.received(steering.count):
                        if station := self._stations.of(self._radar):
                            steering.station = station
                            steering.hear(sender, lines)
                        else:
                            steering.count("radar", len(lines))
                steering.steer()
            except Exception as error:  # of any kind: the next sentences may be followed
                if self.thread is not None:
                    self.thread.note_fault(described(error))

    def _wait(self, seconds: float) -> None:
        """Waits until something can be received, at most so long."""
        with selectors.DefaultSelector() as selector:
            for receiver in self._receivers:
                for each in receiver.sockets:
                    selector.register(each, selectors.EVENT_READ)
            selector.select(seconds)

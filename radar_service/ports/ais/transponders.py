"""The transponders of a scene: who reports what, and when. No sockets and no encoding: any port may tell of them."""

import heapq
import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta

import numpy as np

from radar_service.numerics import Floats, generator, name_key, wrap_bearing
from radar_service.ports.nmea.nmea_port import ROUNDING, SentenceSchedule
from radar_service.ports.nmea.own_ship import OwnShipReport, own_reports
from radar_service.records import ShipStates
from radar_service.service.radio.station import Station
from radar_service.spoke_source import SpokeSourceFault, TellsShips
from radar_service.world import TENTHS, Ais, AisShip, Reporting, geographic_from_map, true_bearing


@dataclass(frozen=True)
class Position:
    """A report of position.

    second: of UTC, 0 to 59. latitude, longitude: [degrees], None: not known.
    course, heading: from true north there [rad], from the map's without a position; None: not known.
    speed: over ground [m/s]. turn_rate: to starboard [rad/s].
    """

    second: int
    latitude: float | None
    longitude: float | None
    course: float | None
    speed: float
    heading: float | None
    turn_rate: float


@dataclass(frozen=True)
class AisReport:
    """What one transponder sends. is_own: that of own ship; position: None, where it sends or others receive none.

    number: rises by one, for the channel. static: which static messages are received, by their numbers; none where it sends none.
    """

    ship: AisShip
    is_own: bool
    position: Position | None
    static: tuple[int, ...] = ()
    number: int = 0


STATIC_MESSAGES = 2  # of a class B station; class A has one


class Transponders:
    """The reports of all transponders of the scene that a radar runs.

    A state is that of a whole second of UTC; it is sent in a later slot of that second, or after the latency. Reports depend
    on all seconds from 0 on, so those that are too late are counted and not sent.
    """

    def __init__(self) -> None:
        self._last = -1
        self._begin(Ais(), 0)

    def due(self, station: Station, time: float, begins: float = 0.0) -> list[AisReport]:
        """Returns what is sent from the time of the last call, or `begins`, up to `time` [s of simulation], in order."""
        known = station.epoch.info
        if known.scene.ais != self._ais or time * TENTHS + ROUNDING < self._last:
            self._begin(known.scene.ais, known.seed)
        due = self._schedule.due(time, begins)
        seconds = [instant // TENTHS for instant, is_second in due if is_second]
        try:
            self._sample(station, seconds, due[0][0] if due else 0)
        except SpokeSourceFault:  # its process is being replaced: the next call makes up for it
            self._schedule.missed(due[0][0])
            return []
        self._last = due[-1][0] if due else self._last
        sent = []
        while self._waiting and self._waiting[0][0] <= self._last:
            sent.append(heapq.heappop(self._waiting)[2])
        return sent

    def _begin(self, ais: Ais, seed: int) -> None:
        """Begins with the transponders of a scene."""
        self._ais, self._seed, self._schedule = ais, seed, SentenceSchedule()
        self._last = -1  # tenth of a second up to which was sent
        self._reporting = {ship.mmsi: Reporting(ship, seed) for ship in ais.ships}
        self._waiting: list[tuple[int, int, AisReport]] = []  # tenth of a second, number, report
        self._numbers, self._sent = itertools.count(), Counter[int]()  # the second one by mmsi
        self._sampled = -1

    def _sample(self, station: Station, seconds: Sequence[int], since: int) -> None:
        """Takes the states of whole seconds; of a second that stands, own ship's alone. since: first tenth of a second."""
        own = station.epoch.info.scene.steerable.own_ship
        around = [ship for ship in self._ais.ships if ship.body != own]
        fresh = range(self._sampled + 1, max(seconds, default=-1) + 1)
        if not isinstance(source := station.epoch.spoke_source, TellsShips):
            return
        if around and fresh:
            states = source.ship_states([float(second) for second in fresh], [ship.body for ship in around])
            for k, second in enumerate(fresh):
                for ship, state in zip(around, states, strict=True):
                    self._report(station, ship, state, k, second, since)
        for ship in self._ais.ships:
            if ship.body == own and seconds:
                self._report_own(station, ship, seconds, fresh)
        self._sampled = max(self._sampled, *seconds, -1)

    def _report(self, station: Station, ship: AisShip, states: ShipStates, k: int, second: int, since: int) -> None:
        """Sends the reports of a second that are due and not lost."""
        reporting, settings = self._reporting[ship.mmsi], self._ais.settings
        speed, turn_rate = float(np.hypot(*states.velocity[k, :2])), float(states.turn_rate[k])
        moves, is_static = reporting.is_due(second, speed, turn_rate), reporting.is_static_due(second)
        if not (moves or is_static) or not states.present[k] or ship.is_silent(float(second)):
            return
        self._sent[ship.mmsi] += 1
        if (instant := second * TENTHS + reporting.slot + round(settings.latency * TENTHS)) < since:
            return
        rng = generator(self._seed, name_key("ais"), ship.mmsi, second)
        error, received = settings.position_error * rng.standard_normal(2), rng.random(3) >= settings.loss
        position = _position(station, ship, states, k, error) if moves and received[0] else None
        static = tuple(number for number in range(STATIC_MESSAGES) if is_static and received[moves + number])
        if position or static:
            self._put(instant, AisReport(ship, False, position, static, self._sent[ship.mmsi]))

    def _report_own(self, station: Station, ship: AisShip, seconds: Sequence[int], fresh: Sequence[int]) -> None:
        """Sends own ship's reports: its position each second, as its sensors report it. fresh: seconds not sampled before."""
        reports = own_reports(station, [float(second) for second in seconds], ship.antenna)
        reporting = self._reporting[ship.mmsi]
        static = [second for second in fresh if not ship.is_silent(float(second)) and reporting.is_static_due(second)]
        for second, own in zip(seconds, reports, strict=True):
            if not ship.is_silent(float(second)):
                parts = tuple(range(STATIC_MESSAGES)) if second in static else ()
                self._put(second * TENTHS, AisReport(ship, True, _own_position(ship, own), parts, second))

    def _put(self, instant: int, report: AisReport) -> None:
        heapq.heappush(self._waiting, (instant, next(self._numbers), report))


def _position(station: Station, ship: AisShip, states: ShipStates, k: int, error: Floats) -> Position:
    """What a ship reports of instant k. error: of the position, east and north [m]."""
    heading, (east, north) = float(states.heading[k]), states.velocity[k, :2].tolist()
    starboard, forward = ship.antenna
    cos, sin = np.cos(heading), np.sin(heading)
    antenna = states.position[k, :2] + [cos * starboard + sin * forward, cos * forward - sin * starboard] + error
    speed, latitude, longitude = float(np.hypot(east, north)), None, None
    course = float(np.arctan2(east, north)) if speed else heading
    if (origin := station.epoch.info.scene.origin) is not None:
        latitude, longitude = geographic_from_map(antenna, origin).tolist()
        course, heading = true_bearing(np.array([course, heading]), states.position[k], origin).tolist()
    utc = station.start_utc + timedelta(seconds=float(states.time[k]))
    return Position(
        utc.second, latitude, longitude, float(wrap_bearing(course)), speed, float(wrap_bearing(heading + ship.heading_error)),
        float(states.turn_rate[k]),
    )  # fmt: skip


def _own_position(ship: AisShip, own: OwnShipReport) -> Position:
    latitude, longitude = own.position or (None, None)
    heading = None if own.heading is None else float(wrap_bearing(own.heading + ship.heading_error))
    return Position(own.utc.second, latitude, longitude, own.course, max(own.speed, 0.0), heading, own.turn_rate)

"""Own ship as its sensors report it at instants, and the sentences about it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from radar_service.errors.sensors import SensorLaws
from radar_service.numerics import Floats, Indices, wrap_bearing
from radar_service.ports.nmea import sentences
from radar_service.radar import Radar
from radar_service.records import Readings, ShipStates
from radar_service.service.radio.station import Station
from radar_service.spoke_source import TellsShips
from radar_service.world import SceneOutline, geographic_from_map, true_bearing


@dataclass(frozen=True)
class OwnShipReport:
    """What sensors report at an instant.

    utc: of the instant.
    position: latitude and longitude [degrees, WGS 84]; None where the scene has no origin.
    heading, course: from true north at its position [rad], from the map's north without a position; None without heading.
    speed: over ground [m/s].
    turn_rate: to starboard [rad/s].
    water, ground: speed ahead and to starboard [m/s].
    """

    utc: datetime
    position: tuple[float, float] | None
    heading: float | None
    course: float | None
    speed: float
    turn_rate: float
    water: tuple[float, float]
    ground: tuple[float, float]


def readings_of(states: ShipStates) -> Readings:
    """Returns the true readings of own ship (K,), with a boresight at north."""
    east, north = states.velocity[:, 0], states.velocity[:, 1]
    speed = np.hypot(east, north)
    course = wrap_bearing(np.where(speed > 0.0, np.arctan2(east, north), states.heading))
    return Readings(np.zeros(len(speed)), states.heading, states.position[:, :2], course, speed)


def delayed_times(radar: Radar, time: float, latency: float) -> Floats:
    """Returns the time (1,) [s] of which a sensor with a latency [s] tells at `time` [s], as it is with the spoke before it."""
    spoke = np.maximum(spoke_before(radar, time) - round(latency / radar.spoke_period), 0)
    return np.asarray(radar.schedule(spoke)[1])


def spoke_before(radar: Radar, time: float) -> Indices:
    """Returns the number (1,) of the last spoke that is not after a time [s]."""
    return np.array([max(0, math.floor(radar.spokes_at(time)))])


def report(
    start: datetime, states: ShipStates, k: int, scene: SceneOutline, reported: Readings, antenna: tuple[float, float]
) -> OwnShipReport:
    """Returns own ship at instant k. reported: readings (1,) with the errors of its sensors; antenna: of the position, starboard
    and forward [m]."""
    true = readings_of(states)
    speed, log_error = float(reported.speed[0]), float(reported.speed[0] - true.speed[k])
    position, angles = None, np.array([reported.heading[0], reported.course[0]])
    if (origin := scene.origin) is not None:
        angles = np.where(np.isnan(angles), np.nan, true_bearing(angles, states.position[k], origin))
        cos, sin = math.cos(states.heading[k]), math.sin(states.heading[k])
        offset = [cos * antenna[0] + sin * antenna[1], cos * antenna[1] - sin * antenna[0]]
        latitude, longitude = geographic_from_map(reported.position[0] + offset, origin).tolist()
        position = latitude, longitude
    velocity, bow = states.velocity[k, :2], float(states.heading[k])
    water = _ahead_and_aside(velocity - scene.stream, bow, log_error)
    ground = _ahead_and_aside(velocity, bow, log_error)
    utc = start + timedelta(seconds=float(states.time[k]))
    heading, course = (None if math.isnan(angle) else angle for angle in angles.tolist())
    return OwnShipReport(utc, position, heading, course, speed, float(states.turn_rate[k]), water, ground)


def _ahead_and_aside(velocity: Floats, heading: float, log_error: float) -> tuple[float, float]:
    """Components of a velocity (2,) [m/s] from the bow, with an error of its size [m/s]."""
    size = math.hypot(*velocity)
    angle = math.atan2(velocity[0], velocity[1]) - heading if size else 0.0
    return (size + log_error) * math.cos(angle), (size + log_error) * math.sin(angle)


def own_reports(station: Station, times: Sequence[float], antenna: tuple[float, float] = (0.0, 0.0)) -> list[OwnShipReport]:
    """Returns own ship at times [s]. antenna: of the position, starboard and forward of its own [m].

    Raises SpokeSourceFault where the process of the scene fails.
    """
    scene, source = station.epoch.info.scene, station.epoch.spoke_source
    assert isinstance(source, TellsShips)
    laws = [station.sensor_laws(int(spoke_before(scene.radar, time)[0])) for time in times]
    of_latency = [(time, latency) for law, time in zip(laws, times, strict=True) if law for latency in law.latencies]
    earlier_times = np.unique([delayed_times(scene.radar, *each)[0] for each in of_latency])
    (states,) = source.ship_states(times, [None])
    earlier = source.ship_states(earlier_times.tolist(), [None])[0] if len(earlier_times) else None
    readings = [as_reported(law, scene.radar, states, k, earlier) for k, law in enumerate(laws)]
    return [report(station.start_utc, states, k, scene, reported, antenna) for k, reported in enumerate(readings)]


def fast_sentences(own: OwnShipReport) -> list[bytes]:
    """The sentences of each tenth of a second."""
    return [*([] if own.heading is None else [sentences.hdt(own.heading)]), sentences.ths(own.heading)]


def slow_sentences(own: OwnShipReport) -> list[bytes]:
    """The sentences of each second. Without a position there are no RMC and GGA."""
    here = own.position
    return [
        sentences.zda(own.utc),
        *([] if here is None else [sentences.rmc(own.utc, here, own.course, own.speed), sentences.gga(own.utc, here)]),
        sentences.vtg(own.course, own.speed),
        sentences.rot(own.turn_rate, own.heading is not None),
        sentences.vbw(own.water, own.ground),
        sentences.vhw(own.heading, own.water[0]),
    ]


def as_reported(laws: SensorLaws | None, radar: Radar, states: ShipStates, k: int, earlier: ShipStates | None) -> Readings:
    """Returns the readings (1,) of instant k with the errors of sensors. earlier: of sensors with a latency, by time."""
    true = readings_of(states).part(slice(k, k + 1))
    if laws is None:
        return true
    number, time = spoke_before(radar, float(states.time[k])), states.time[k : k + 1]

    def before(numbers: Indices) -> Readings:
        assert earlier is not None
        delayed = radar.schedule(numbers)[1]
        return readings_of(earlier).part(np.searchsorted(earlier.time, delayed))

    return laws.reported(number, time, true, before)

"""What a ship reports: errors of its sensors on purpose, its AIS transponder, and how often this reports. SI and radians."""

import math
from dataclasses import dataclass
from typing import Literal

from radar_service.numerics import KNOT


@dataclass(frozen=True)
class GyroErrors:
    """Errors of the reported heading."""

    bias: float
    calibration: float
    calibration_phase: float
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class LogErrors:
    """Errors of the reported speed. scale: share of the speed; least: the speed that this adds or takes at least."""

    bias: float
    scale: float
    least: float
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class PositionErrors:
    """Errors of the reported position. bias: east, north."""

    bias: tuple[float, float]
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class AntennaErrors:
    """Errors of the reported angle from the bow."""

    misalignment: float
    backlash: float
    encoder_noise: float
    encoder_step: float


@dataclass(frozen=True)
class FeedErrors:
    """What happens to spokes between radar and client. bytes: per second; cut_after: age of a connection [s]."""

    drop_rate: float
    burst_rate: float
    burst_spokes: int
    repeat_rate: float
    late_rate: float
    late: float
    swap_rate: float
    stuck_sector: tuple[float, float] | None
    heading_lost: tuple[tuple[float, float], ...]
    bytes: float | None
    cut_after: float | None


@dataclass(frozen=True)
class ErrorSettings:
    """The errors in force; None where a part has none."""

    gyro: GyroErrors | None = None
    log: LogErrors | None = None
    position: PositionErrors | None = None
    antenna: AntennaErrors | None = None
    feed: FeedErrors | None = None


StationClass = Literal["A", "B-SO", "B-CS"]
StationKind = Literal["ship", "aid", "sart"]


@dataclass(frozen=True)
class AisSettings:
    """What happens to the reports of all bodies. latency: from the sampled second to the sentence, beside the slot [s].

    loss: share of messages that are not received. position_error: standard deviation, east and north each [m].
    """

    latency: float = 0.0
    loss: float = 0.0
    position_error: float = 0.0


@dataclass(frozen=True)
class AisShip:
    """A transponder.

    body: name of the body that has it, None for own ship that is no body.
    mmsi, imo: its numbers; imo 0: none.
    kind: ship, aid to navigation, or search and rescue transponder that is active.
    antenna: of its position sensor on the deck, starboard and forward of the origin of the body's frame [m].
    to_bow, to_stern, to_port, to_starboard: distances from that antenna to its sides [m]; 0: not known.
    draught: [m]. ship_type: two digits, 0: not known; aid_type: of an aid, 0 to 31, 0: not known.
    silent: periods in which it is off, from and to [s]. heading_error: of what it reports [rad].
    """

    body: str | None
    mmsi: int
    station_class: StationClass
    name: str = ""
    call_sign: str = ""
    ship_type: int = 0
    imo: int = 0
    destination: str = ""
    antenna: tuple[float, float] = (0.0, 0.0)
    to_bow: float = 0.0
    to_stern: float = 0.0
    to_port: float = 0.0
    to_starboard: float = 0.0
    draught: float = 0.0
    silent: tuple[tuple[float, float], ...] = ()
    heading_error: float = 0.0
    kind: StationKind = "ship"
    aid_type: int = 0

    def is_silent(self, time: float) -> bool:
        """Whether it is off at a time [s]."""
        return any(start <= time < end for start, end in self.silent)


@dataclass(frozen=True)
class Ais:
    """The transponders of a scene. ships: in the order of its bodies, own ship that is no body first."""

    ships: tuple[AisShip, ...] = ()
    settings: AisSettings = AisSettings()

    @property
    def of_bodies(self) -> "Ais":
        """The same without own ship that is no body."""
        return Ais(tuple(ship for ship in self.ships if ship.body is not None), self.settings)


# Intervals of ITU-R M.1371-5, tables 1 and 2, on the seconds of UTC; search and rescue transponders (SART) send bursts.
STATIC = 360.0  # s between static reports
SLOW, CLASS_B_SLOW = 180.0, 180.0  # s at anchor, and of class B up to 2 knots
TURNING = math.radians(5.0) / 30.0  # rad/s: the course changes by 5 degrees in half a minute
AID = 180.0  # s
MINUTE, BURST, STEP = 60, 8, 2  # of a SART: s, messages in a minute, s from one to the next
TEXTS, TEXT_MINUTES = (4, 5), 4  # which of them are its text, and in which of its minutes
TENTHS = 10  # a second; a slot of 27 ms is in one of them
ROUNDING = 1e-6  # s: 3 1/3 s summed up


def interval(ship: AisShip, speed: float, turn_rate: float) -> float:
    """Returns the time [s] between two reports of position at a speed over ground [m/s] and a rate of turn [rad/s]."""
    knots = speed / KNOT
    if ship.kind == "aid":
        return AID
    if ship.station_class == "B-CS":
        return CLASS_B_SLOW if knots <= 2.0 else 30.0
    if ship.station_class == "B-SO":
        return CLASS_B_SLOW if knots <= 2.0 else 30.0 if knots <= 14.0 else 15.0 if knots <= 23.0 else 5.0
    if speed == 0.0:
        return SLOW
    if knots > 23.0:
        return 2.0
    turns = abs(turn_rate) > TURNING
    return (2.0 if turns else 6.0) if knots > 14.0 else (10.0 / 3.0 if turns else 10.0)


class Reporting:
    """The reports of one transponder, second by second. seed: of its first ones, so that ships do not report together."""

    def __init__(self, ship: AisShip, seed: int) -> None:
        from radar_service.numerics import generator, name_key  # here: they need scipy, which most programs need not load

        rng = generator(seed, name_key("ais reporting"), ship.mmsi)
        self._phase, self._static_phase = rng.random(2).tolist()
        self.slot = int(rng.integers(1, TENTHS))  # tenths of a second from the sampled second to its slot
        self._ship, self._last, self._next, self._static = ship, -math.inf, math.nan, math.nan

    def is_due(self, second: int, speed: float, turn_rate: float) -> bool:
        """Whether the ship reports its position of this second. Seconds rise by one."""
        if self._ship.kind == "sart":
            return self._in_burst(second) == "position"
        every = interval(self._ship, speed, turn_rate)
        if math.isnan(self._next):
            self._next = second + math.floor(self._phase * every)
        self._next = min(self._next, max(float(second), self._last + every))  # a shorter interval holds at once
        if second < self._next - ROUNDING:
            return False
        self._last = self._next if self._next > second - 1.0 + ROUNDING else float(second)
        self._next = self._last + every
        return True

    def is_static_due(self, second: int) -> bool:
        """Whether the ship sends static reports in this second, or a SART its text."""
        if self._ship.kind != "ship":
            return self._in_burst(second) == "text"
        if math.isnan(self._static):
            self._static = second + math.floor(self._static_phase * min(STATIC, 60.0))
        if second < self._static:
            return False
        self._static = second + STATIC
        return True

    def _in_burst(self, second: int) -> str:
        """What a SART sends in a second: `position`, `text`, or nothing."""
        minute, time = divmod(second - math.floor(self._phase * MINUTE), MINUTE)
        if self._ship.kind != "sart" or time % STEP or time >= BURST * STEP:
            return ""
        return "text" if minute % TEXT_MINUTES == 0 and time // STEP in TEXTS else "position"

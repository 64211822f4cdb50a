"""How often a transponder reports: the intervals of ITU-R M.1371-5, tables 1 and 2, on the seconds of UTC; bursts of SARTs."""

import math

from radar_service.numerics import KNOT, generator, name_key
from radar_service.world.ais import AisShip

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

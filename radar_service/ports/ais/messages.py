"""AIS messages of ITU-R M.1371 as bits, and as AIVDM and AIVDO sentences. SI units and radians in, bytes out.

Types 1 (position, class A and SART), 5 (static, class A), 14 (text of a SART), 18 (position, class B), 21 (aid to navigation),
24 (static, class B). Reports carry no communication state.
"""

import math
from dataclasses import replace

from radar_service.numerics import KNOT
from radar_service.ports.ais.transponders import Position
from radar_service.ports.nmea.sentences import sentence
from radar_service.world import AisShip

MINUTE_PARTS = 10_000  # of the position
NO_LONGITUDE, NO_LATITUDE, NO_HEADING, NO_TURN = 181.0, 91.0, 511, -128
FASTEST = 1022  # tenths of a knot: that, or more
ROT_FACTOR = 4.733  # of the root law: value = 4.733 sqrt(degrees a minute)
MAX_ROT = 126  # of the root law: 708 degrees a minute, or more
PAYLOAD = 60  # characters in a sentence: it has 82
UNDER_WAY, AT_ANCHOR, SART = 0, 1, 14
GPS = 1  # kind of position sensor
ACTIVE = "SART ACTIVE"
CHARACTERS = "@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_ !\"#$%&'()*+,-./0123456789:;<=>?"


class Bits:
    """Fields one after the other, the most significant bit first."""

    def __init__(self) -> None:
        self._bits: list[str] = []

    def add(self, value: int, width: int) -> "Bits":
        """Adds a whole number; a negative one as its complement."""
        assert -(1 << width - 1) <= value < 1 << width, f"{value} has no room in {width} bits"
        self._bits.append(f"{value & (1 << width) - 1:0{width}b}")
        return self

    def text(self, text: str, length: int) -> "Bits":
        """Adds characters of six bits, filled up with @; those without a code become ?."""
        for character in text[:length].ljust(length, "@"):
            self.add(CHARACTERS.find(character) if character in CHARACTERS else CHARACTERS.index("?"), 6)
        return self

    def payload(self) -> tuple[str, int]:
        """Returns the characters of six bits each, and how many bits of the last one are fill."""
        bits = "".join(self._bits)
        fill = -len(bits) % 6
        bits += "0" * fill
        values = (int(bits[k : k + 6], 2) for k in range(0, len(bits), 6))
        return "".join(chr(value + 48 if value < 40 else value + 56) for value in values), fill


def class_a_position(ship: AisShip, at: Position) -> Bits:
    """Type 1: scheduled position report of class A, or of a SART, which knows neither heading nor rate of turn."""
    status, turn = AT_ANCHOR if at.speed == 0.0 else UNDER_WAY, rate_of_turn(at.turn_rate)
    if ship.kind == "sart":
        status, turn, at = SART, NO_TURN, replace(at, heading=None)
    return _motion(_begin(1, ship).add(status, 4).add(turn, 8), at).add(0, 25)


def class_b_position(ship: AisShip, at: Position) -> Bits:
    """Type 18: position report of class B, by a unit with DSC, for the whole band, that takes message 22."""
    return _motion(_begin(18, ship).add(0, 8), at).add(0, 2).add(ship.station_class == "B-CS", 1).add(0b0111, 4).add(0, 22)


def class_a_static(ship: AisShip) -> Bits:
    """Type 5: name, dimensions and voyage of class A; no time of arrival."""
    bits = _begin(5, ship).add(0, 2).add(ship.imo, 30).text(ship.call_sign, 7).text(ship.name, 20).add(ship.ship_type, 8)
    _dimensions(bits, ship).add(GPS, 4).add(0, 4).add(0, 5).add(24, 5).add(60, 6)
    return bits.add(min(round(ship.draught * 10.0), 255), 8).text(ship.destination, 20).add(0, 2)


def class_b_static(ship: AisShip) -> tuple[Bits, Bits]:
    """Type 24, parts A and B: name and dimensions of class B."""
    rest = _begin(24, ship).add(1, 2).add(ship.ship_type, 8).add(0, 42).text(ship.call_sign, 7)
    return _begin(24, ship).add(0, 2).text(ship.name, 20).add(0, 8), _dimensions(rest, ship).add(GPS, 4).add(0, 2)


def aid_report(ship: AisShip, at: Position) -> Bits:
    """Type 21: an aid to navigation, which is real and on its position."""
    bits = _place(_begin(21, ship).add(ship.aid_type, 5).text(ship.name, 20).add(0, 1), at)
    return _dimensions(bits, ship).add(GPS, 4).add(at.second, 6).add(0, 13)


def position_of(ship: AisShip, at: Position) -> Bits:
    """The position report of its kind and class."""
    of_class = class_a_position if ship.station_class == "A" else class_b_position
    return {"ship": of_class, "aid": aid_report, "sart": class_a_position}[ship.kind](ship, at)


def static_of(ship: AisShip) -> tuple[Bits, ...]:
    """The static reports of its kind and class; of a SART its text."""
    if ship.kind != "ship":
        return (_begin(14, ship).add(0, 2).text(ACTIVE, len(ACTIVE)),) if ship.kind == "sart" else ()
    return (class_a_static(ship),) if ship.station_class == "A" else class_b_static(ship)


def rate_of_turn(turn_rate: float) -> int:
    """The root law of a rate to starboard [rad/s]."""
    size = ROT_FACTOR * math.sqrt(abs(math.degrees(turn_rate)) * 60.0)
    return int(math.copysign(min(round(size), MAX_ROT), turn_rate))


def ais_sentences(bits: Bits, kind: str, number: int) -> list[bytes]:
    """Returns the sentences of a message. kind: VDM or VDO; number: of the message, which gives channel and group."""
    payload, fill = bits.payload()
    parts = [payload[k : k + PAYLOAD] for k in range(0, len(payload), PAYLOAD)]
    channel, group = "AB"[number % 2], str(number % 10) if len(parts) > 1 else ""
    fills = [0] * (len(parts) - 1) + [fill]
    return [
        sentence("AI", kind, str(len(parts)), str(k), group, channel, part, str(unused), start="!")
        for k, (part, unused) in enumerate(zip(parts, fills, strict=True), 1)
    ]


def _begin(kind: int, ship: AisShip) -> Bits:
    return Bits().add(kind, 6).add(0, 2).add(ship.mmsi, 30)


def _motion(bits: Bits, at: Position) -> Bits:
    course = 3600 if at.course is None else round(math.degrees(at.course) * 10.0) % 3600
    heading = NO_HEADING if at.heading is None else round(math.degrees(at.heading)) % 360
    bits.add(min(round(at.speed / KNOT * 10.0), FASTEST), 10).add(0, 1)
    return _place(bits, at).add(course, 12).add(heading, 9).add(at.second, 6)


def _place(bits: Bits, at: Position) -> Bits:
    longitude = NO_LONGITUDE if at.longitude is None else math.remainder(at.longitude, 360.0)
    latitude = NO_LATITUDE if at.latitude is None else at.latitude
    return bits.add(round(longitude * 60 * MINUTE_PARTS), 28).add(round(latitude * 60 * MINUTE_PARTS), 27)


def _dimensions(bits: Bits, ship: AisShip) -> Bits:
    for size, width in ((ship.to_bow, 9), (ship.to_stern, 9), (ship.to_port, 6), (ship.to_starboard, 6)):
        bits.add(min(round(size), (1 << width) - 1), width)
    return bits

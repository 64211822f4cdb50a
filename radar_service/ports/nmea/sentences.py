"""NMEA 0183 sentences: values in SI units and radians in, bytes out. No clock and no socket.

Field order as in the table of `docs/connect.md`; a value that is not known has an empty field.
"""

import math
from datetime import datetime
from functools import reduce

from radar_service.numerics import KNOT

GYRO, GNSS, LOG, RADAR = "HE", "GP", "VD", "RA"  # talkers
MINUTE_DIGITS = 5  # of positions: 18 mm
KMH = 1.0 / 3.6  # m/s


def checksum(body: str) -> int:
    """Returns the exclusive or of all characters between `$` and `*`."""
    return reduce(lambda total, byte: total ^ byte, body.encode("ascii"), 0)


def sentence(talker: str, kind: str, *fields: str, start: str = "$") -> bytes:
    """Returns a sentence with its checksum and line end."""
    body = ",".join((talker + kind, *fields))
    return f"{start}{body}*{checksum(body):02X}\r\n".encode("ascii")


def hdt(heading: float | None) -> bytes:
    """True heading [rad]."""
    return sentence(GYRO, "HDT", bearing(heading), "T")


def ths(heading: float | None) -> bytes:
    """True heading [rad] and whether it is valid."""
    return sentence(GYRO, "THS", bearing(heading), "V" if heading is None else "A")


def rot(turn_rate: float, is_valid: bool) -> bytes:
    """Rate of turn to starboard [rad/s], in degrees a minute."""
    return sentence(GYRO, "ROT", fixed(math.degrees(turn_rate) * 60.0, 2), "A" if is_valid else "V")


def vtg(course: float | None, speed: float) -> bytes:
    """Course [rad] and speed [m/s] over ground."""
    return sentence(
        GNSS, "VTG", bearing(course), "T", "", "M", fixed(speed / KNOT, 2), "N", fixed(speed / KMH, 2), "K", "A"
    )  # fmt: skip


def rmc(utc: datetime, position: tuple[float, float], course: float | None, speed: float) -> bytes:
    """Position [degrees, WGS 84], course [rad] and speed [m/s] over ground at a time."""
    return sentence(
        GNSS, "RMC", clock(utc), "A", *latitude_longitude(*position), fixed(speed / KNOT, 2), bearing(course),
        f"{utc:%d%m%y}", "", "", "A",
    )  # fmt: skip


def gga(utc: datetime, position: tuple[float, float]) -> bytes:
    """Position [degrees, WGS 84] at a time, as of a receiver without corrections that has eight satellites."""
    return sentence(GNSS, "GGA", clock(utc), *latitude_longitude(*position), "1", "08", "1.0", "0.0", "M", "", "M", "", "")


def vbw(water: tuple[float, float], ground: tuple[float, float]) -> bytes:
    """Speed ahead and to starboard [m/s], through the water and over ground."""
    knots = [[fixed(speed / KNOT, 2) for speed in pair] for pair in (water, ground)]
    return sentence(LOG, "VBW", *knots[0], "A", *knots[1], "A", "", "V", "", "V")


def vhw(heading: float | None, speed: float) -> bytes:
    """True heading [rad], and speed ahead through the water [m/s]."""
    return sentence(LOG, "VHW", bearing(heading), "T", "", "M", fixed(speed / KNOT, 2), "N", fixed(speed / KMH, 2), "K")


def zda(utc: datetime) -> bytes:
    """Time and date."""
    return sentence(GNSS, "ZDA", clock(utc), f"{utc:%d}", f"{utc:%m}", f"{utc.year:04d}", "00", "00")


def clock(utc: datetime) -> str:
    """hhmmss.ss of a time, to the nearest hundredth below."""
    return f"{utc:%H%M%S}.{utc.microsecond // 10_000:02d}"


def bearing(angle: float | None) -> str:
    """Degrees from 0.00 to 359.99 of an angle [rad]; empty for None."""
    return "" if angle is None else f"{round(math.degrees(angle) * 100.0) % 36_000 / 100.0:.2f}"


def fixed(value: float, digits: int) -> str:
    """A number with so many digits after the point, never -0."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def latitude_longitude(latitude: float, longitude: float) -> tuple[str, str, str, str]:
    """Both with their hemispheres, from degrees; a longitude of any turn."""
    longitude = math.remainder(longitude, 360.0)
    north_south, east_west = "S" if latitude < 0.0 else "N", "W" if longitude < 0.0 else "E"
    return _degrees_minutes(latitude, 2), north_south, _degrees_minutes(longitude, 3), east_west


def _degrees_minutes(angle: float, digits: int) -> str:
    """ddmm.mmmmm of an angle [degrees], rounded as a whole: never 60 minutes."""
    scale = 10**MINUTE_DIGITS
    degrees, minutes = divmod(round(abs(angle) * 60 * scale), 60 * scale)
    minute, rest = divmod(minutes, scale)
    return f"{degrees:0{digits}d}{minute:02d}.{rest:0{MINUTE_DIGITS}d}"

"""The truth as tracked targets, TTM and TLL, for displays that have no other way to it. Each name begins with `TRUTH`.

These are no tracks of a radar: nothing was measured, and no error of a sensor is in them.
"""

import math
from datetime import datetime

import numpy as np

from radar_service.numerics import KNOT, NAUTICAL_MILE
from radar_service.ports.nmea.sentences import RADAR, bearing, clock, fixed, latitude_longitude, sentence
from radar_service.records import BodyTruth, Truth
from radar_service.world import Origin, true_bearing

MARK = "TRUTH"
MAX_TARGETS = 99  # numbers of two digits
MAX_MINUTES = 99.9  # of TCPA
SLOWEST = 1e-9  # m/s: below it two ships neither approach nor part
RESERVED = str.maketrans(dict.fromkeys(",*$!\\^~", " "))  # characters that a field must not have
NAME = 11  # characters of a name: what the longest TTM of 82 has room for


def target_sentences(truth: Truth, utc: datetime, origin: Origin | None = None) -> list[bytes]:
    """Returns TTM, and TLL where the scene has an origin, of each body in sight.

    A body keeps its number: that in the scene, from 1 on. Bearings and courses count from true north at own ship and at the body;
    without an origin from the map's.
    """
    lines = []
    for number, body in enumerate(truth.bodies[:MAX_TARGETS], 1):
        if body.visible:
            lines.append(_ttm(number, body, truth.own_ship, utc, origin))
            lines += [] if body.latitude_deg is None or body.longitude_deg is None else [_tll(number, body, utc)]
    return lines


def label(name: str) -> str:
    """Returns the name of a body as a field of NAME characters at most, in each sentence the same: ASCII, marked as truth."""
    plain = name.encode("ascii", "replace").decode().translate(RESERVED)
    return f"{MARK} {''.join(c if c.isprintable() else ' ' for c in plain)}"[:NAME].rstrip()


def _short(value: float, digits: int) -> str:
    """A number with so many digits after the point, from 100 on with fewer, so that it does not become longer."""
    return fixed(value, max(0, digits + 2 - max(2, len(f"{value:.0f}"))))


def closest_approach(body: BodyTruth, own: BodyTruth) -> tuple[float, float | None]:
    """Returns distance [m] and time from now [s] of the closest approach in plan, at constant velocities.

    The time is None where the distance does not change.
    """
    offset, velocity = (np.subtract(a, b)[:2] for a, b in ((body.position, own.position), (body.velocity, own.velocity)))
    square = float(velocity @ velocity)
    time = -float(offset @ velocity) / square if square > SLOWEST**2 else None
    return math.hypot(*(offset + (time or 0.0) * velocity)), time


def true_angles(body: BodyTruth, own: BodyTruth, origin: Origin | None) -> tuple[float, float]:
    """Returns bearing and course of a body [rad] from true north at own ship and at the body, or else from the map's."""
    if origin is None:
        return body.azimuth, body.course
    angles = ((body.azimuth, own.position), (body.course, body.position))
    return tuple(float(true_bearing(angle, np.array(place), origin)) for angle, place in angles)  # type: ignore[return-value]


def _ttm(number: int, body: BodyTruth, own: BodyTruth, utc: datetime, origin: Origin | None) -> bytes:
    cpa, tcpa = closest_approach(body, own)
    minutes = "" if tcpa is None else fixed(min(max(tcpa / 60.0, -MAX_MINUTES), MAX_MINUTES), 1)
    azimuth, course = true_angles(body, own, origin)
    return sentence(
        RADAR, "TTM", f"{number:02d}", _short(body.range / NAUTICAL_MILE, 3), bearing(azimuth), "T",
        _short(body.speed / KNOT, 1), bearing(course), "T", _short(cpa / NAUTICAL_MILE, 2), minutes, "N", label(body.name),
        "T", "", f"{utc:%H%M%S}", "A",
    )  # fmt: skip


def _tll(number: int, body: BodyTruth, utc: datetime) -> bytes:
    assert body.latitude_deg is not None and body.longitude_deg is not None
    position = latitude_longitude(body.latitude_deg, body.longitude_deg)
    return sentence(RADAR, "TLL", f"{number:02d}", *position, label(body.name), clock(utc), "T", "")

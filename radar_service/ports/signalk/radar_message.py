"""The protobuf message of spokes of the Signal K Radar API 3.4.0: `RadarMessage`, written and cut. No I/O.

A message is repeated field 2, a spoke each: angle (1) and bearing (2) in spokes of a revolution, range (3) in whole metres,
time (4) in milliseconds since 1970, data (5) with a byte a sample, latitude (6) and longitude (7) in degrees as doubles.
The encoding is that of Protocol Buffers: a key (field << 3 | wire type) and its value.
"""

import struct
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

VARINT, DOUBLE, BYTES = 0, 1, 2  # wire types
SPOKES = 2 << 3 | BYTES
ANGLE, BEARING, RANGE, TIME = (field << 3 | VARINT for field in (1, 2, 3, 4))
DATA = 5 << 3 | BYTES
LATITUDE, LONGITUDE = (field << 3 | DOUBLE for field in (6, 7))


class SpokeFields(NamedTuple):
    """One spoke; None: not known. angle: clockwise from the bow, bearing: from true north, both in spokes of a revolution.

    range: of the far edge of the last sample [m]; time: since 1970 [ms]; position: latitude, longitude [degrees].
    """

    angle: int
    bearing: int | None
    range: int
    time: int | None
    position: tuple[float, float] | None
    data: bytes


def varint(value: int) -> bytes:
    """Returns a whole number from 0 up in groups of seven bits, the lowest first."""
    if value < 0x80:
        return bytes((value,))
    groups = bytearray()
    while value >= 0x80:
        groups.append(value & 0x7F | 0x80)
        value >>= 7
    groups.append(value)
    return bytes(groups)


_keyed = lru_cache(maxsize=1 << 16)(
    lambda key, value: bytes((key,)) + varint(value)
)  # of angles and sizes, which come again


def spoke_bytes(spoke: SpokeFields) -> bytes:
    """Returns one spoke as an element of a message."""
    parts = [_keyed(ANGLE, spoke.angle)]
    if spoke.bearing is not None:
        parts.append(_keyed(BEARING, spoke.bearing))
    parts.append(_keyed(RANGE, spoke.range))
    if spoke.time is not None:
        parts += [bytes((TIME,)), varint(spoke.time)]
    parts += [_keyed(DATA, len(spoke.data)), spoke.data]
    if spoke.position is not None:
        latitude, longitude = spoke.position
        parts.append(struct.pack("<BdBd", LATITUDE, latitude, LONGITUDE, longitude))
    content = b"".join(parts)
    return _keyed(SPOKES, len(content)) + content


def last_spokes(message: bytes, count: int) -> bytes:
    """Returns a message with only its last `count` spokes."""
    starts = list(_starts(message))
    return message[starts[-count] :] if count else b""


def _starts(message: bytes) -> Iterator[int]:
    """Where each spoke of a message of `spoke_bytes` begins."""
    at = 0
    while at < len(message):
        yield at
        at, shift, size = at + 1, 0, 0
        while True:
            byte = message[at]
            size |= (byte & 0x7F) << shift
            at, shift = at + 1, shift + 7
            if byte < 0x80:
                break
        at += size

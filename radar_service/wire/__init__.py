"""The wire of the native feed, for clients and servers alike: messages as bytes and back, spokes as rows of arrays. No I/O."""

from radar_service.wire.format import (
    ARRAYS,
    COMPRESSIONS,
    DTYPES,
    MAX_MESSAGE,
    PROTOCOL,
    TURN,
    labels,
    pack,
    packed,
    powers,
    radians_from_turn,
    samples,
    turn_from_radians,
    unpack,
    unpack_any,
    unpacked,
)
from radar_service.wire.spoke_rows import SpokeRows

__all__ = [
    "ARRAYS",
    "COMPRESSIONS",
    "DTYPES",
    "MAX_MESSAGE",
    "PROTOCOL",
    "TURN",
    "SpokeRows",
    "labels",
    "pack",
    "packed",
    "powers",
    "radians_from_turn",
    "samples",
    "turn_from_radians",
    "unpack",
    "unpack_any",
    "unpacked",
]

"""Datagrams of a Garmin xHD: heartbeat, reports and spokes out, commands in. No I/O. All integers are little-endian."""

import struct
from collections.abc import Sequence
from functools import partial
from typing import Any

from radar_service.numerics import DISPLAY_RANGES
from radar_service.ports.dialect.dialect import (
    TRANSMIT,
    Commands,
    Dialect,
    Frames,
    IgnoredError,
    SampleForm,
    Setting,
    Spoke,
    follow,
    levels,
    one_of,
    percent,
    ranged,
)

GROUP, FINDERS = "239.254.2.0", "239.254.2.2"  # of reports and spokes, of heartbeats
TABLE = (232, *DISPLAY_RANGES[1:])  # m: ranges that are offered
AUTO = 2  # a mode of gain and of sea
# What readers may change: transmit, range, gain and its mode, rain, sea, interference rejection (two of the names it has).
FEATURES = (0x13, 0x4A, 0x4B, 0x4C, 0x4F, 0x50, 0x51, 0x52, 0x53, 0x37, 0x38)


class XhdFrames(Frames):
    """Makes a datagram of each spoke; none waits for others."""

    def of(self, spokes: Sequence[Spoke]) -> list[bytes]:
        """Returns the datagrams of spokes."""
        return [spoke(each.number, each.metres, each.samples.tobytes()) for each in spokes]


def heartbeat(identity: int, count: int) -> bytes:
    """Returns the datagram by which a radar is found. identity: unique; count: of heartbeats before."""
    product = struct.pack("<BBHBBBBB3x4s", 2, 0, 0x06D0, 0, 5, 2, 1, 1, b"\1\0\2\0")
    return struct.pack("<II", 0x038E, 26) + product + struct.pack("<IBBI", identity, 1, 4, count % 2**32)


def spoke(number: int, metres: int, samples: bytes) -> bytes:
    """Returns a spoke. number: clockwise from the bow, of 1440; metres: where the last sample ends."""
    length, count = 28 + len(samples), len(samples)
    return struct.pack(
        "<IIHHHHIIBBHHIH", 0x0998, length, 1, length, 8 * number, 0, metres, metres, 0, 0, count, 0x0108, count, 0
    ) + samples  # fmt: skip


def reports(of: Setting) -> list[bytes]:
    """Returns all reports, in the order that readers need."""
    has, sends = of.controls or {}, of.state == TRANSMIT
    sea, rain = round(100 * has.get("sea", 0)), round(100 * has.get("rain", 0))
    rejects = bool(has.get("interference_rejection"))
    ranges = [each for each in TABLE if each <= of.range_max] or [int(of.range_max)]
    bits = sum(1 << bit for bit in FEATURES)
    return [
        _byte(0x0992, 3 + of.state), _long(0x0993, 0), _byte(0x0918, 1 if sends else 2), _byte(0x0919, bool(has.get("transmit"))),
        _byte(0x0916, 0), _byte(0x091C, 0), _long(0x091E, of.range),
        _byte(0x0924, AUTO * bool(has.get("gain_auto"))), _short(0x0925, round(100 * has.get("gain", 0))),
        _byte(0x091D, of.level), _byte(0x0933, rain > 0), _short(0x0934, rain),
        _byte(0x0939, AUTO if has.get("sea_auto") else sea > 0), _short(0x093A, sea), _byte(0x093B, 0),
        _byte(0x0932, rejects), _byte(0x091B, rejects), _long(0x0930, 0), _byte(0x093F, 0), _long(0x0940, 0), _long(0x0941, 0),
        _byte(0x0942, 0),
        struct.pack("<II", 0x09B1, 48) + bytes.fromhex("010030009d000a00") + bits.to_bytes(40, "little"),
        struct.pack(f"<IIHHI{len(ranges)}I", 0x09B2, 8 + 4 * len(ranges), 1, 8 + 4 * len(ranges), len(ranges), *ranges),
    ]  # fmt: skip


def changed_by(command: bytes, of: Setting) -> dict[str, Any]:
    """Returns what a command changes. Raises IgnoredError."""
    if len(command) < 9 or struct.unpack_from("<I", command, 4)[0] != len(command) - 8:
        raise IgnoredError("form")
    return follow(COMMANDS, struct.unpack_from("<I", command)[0], command[8:], of)


def _value(form: str, number: int, value: int) -> bytes:
    return struct.pack(f"<II{form}", number, struct.calcsize(form), value)


_byte, _short, _long = (partial(_value, form) for form in "BHi")


def _rejection(value: int, of: Setting) -> dict[str, Any]:
    return {"interference_rejection": value > 0}


COMMANDS: Commands = {
    (0x0919, 1): one_of({0: {"transmit": False}, 1: {"transmit": True}}),
    (0x091E, 4): lambda value, of: ranged(float(value), of),
    (0x0924, 1): one_of({0: {"gain_auto": False}, AUTO: {"gain_auto": True}}),
    (0x0925, 2): percent("gain", 100_00, gain_auto=False),
    (0x091D, 1): one_of({0: {"level": 0}, 1: {"level": 1}}),
    (0x0939, 1): one_of({0: {"sea": 0.0, "sea_auto": False}, 1: {"sea_auto": False}, AUTO: {"sea_auto": True}}),
    (0x093A, 2): percent("sea", 100_00, sea_auto=False),
    (0x0933, 1): one_of({0: {"rain": 0.0}, 1: {}}),
    (0x0934, 2): percent("rain", 100_00),
    (0x0932, 1): _rejection,
    (0x091B, 1): _rejection,
}
XHD = Dialect(
    "garmin-xhd", "172.16.2.0", 1440,
    SampleForm(705, False, levels(39, 254)),  # less are colours of trails for readers, more is an approaching target
    XhdFrames, ((FINDERS, 50050), (GROUP, 50100), (GROUP, 50102)), (("", 50101),),
    lambda identity, count, here: heartbeat(identity, count), reports, changed_by,
)  # fmt: skip

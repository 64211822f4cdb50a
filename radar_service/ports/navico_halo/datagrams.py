"""Datagrams of a Navico HALO: beacon, reports and frames of spokes out, commands in. No I/O. Integers are little-endian, but for
ports. docs/dialects/navico-halo.md says what readers take."""

import math
import socket
import struct
from collections.abc import Sequence
from typing import Any

from radar_service.ports.dialect.dialect import (
    Commands,
    Dialect,
    IgnoredError,
    SampleForm,
    Setting,
    Spoke,
    follow,
    levels,
    one_of,
    ranged,
)

FINDERS = ("236.6.7.5", 6878)  # of beacons, and of readers that look for radars
SPOKES, SAMPLES = 2048, 1024  # in a revolution, and in a spoke
IN_FRAME = 32  # spokes
TURN = 4096  # units of angle
TRUE, LOST = 0x4000, 0x8000  # of headings: that it is from true north, and that there is none
GROUPS = [("236.6.7.97", 6129), ("236.6.7.22", 6694), *((f"236.6.7.{k}", 6032 + k) for k in range(98, 112))]  # in a beacon
BETWEEN = """
    0600fdff2001020010000000 11000000 1f002001020010000000 11000000
    10002001030010000000 11000000 12000000 10002002030010000000 11000000 12000000
    12002001030010000000 11000000 12000000 12002002030010000000 11000000 12000000
"""  # before each of the groups: what of, in hexadecimal digits
SPOKES_TO, COMMANDS_TO, REPORTS_TO = GROUPS[4:7]  # the next three are those of a second range, of which nothing comes


class Frames:
    """Makes a datagram of 32 spokes each."""

    def __init__(self) -> None:
        self._waiting, self._count = list[Spoke](), 0

    def of(self, spokes: Sequence[Spoke]) -> list[bytes]:
        """Returns the datagrams that are complete with these spokes."""
        self._waiting += spokes
        result = list[bytes]()
        while len(self._waiting) >= IN_FRAME:
            lines = [line(self._waiting.pop(0), (self._count + k) % TURN) for k in range(IN_FRAME)]
            self._count += IN_FRAME
            result.append(struct.pack("<B4xBH", 1, IN_FRAME, SAMPLES // 2) + b"".join(lines))
        return result

    def clear(self) -> None:
        """Forgets spokes that wait for others."""
        self._waiting.clear()


def beacon(identity: int, here: str) -> bytes:
    """Returns the datagram by which a radar is found. identity: unique, for a serial number; here: the radar's address."""
    parts = [bytes.fromhex(before) + _packed(*group) for before, group in zip(BETWEEN.split(), GROUPS, strict=True)]
    return b"\1\xb2" + (b"9%09d" % (identity % 10**9)).ljust(16, b"\0") + _packed(here, 5168) + b"".join(parts)


def line(of: Spoke, count: int) -> bytes:
    """Returns a spoke in a frame. count: of those before it."""
    large, small = (0x80, 4 * of.metres) if of.metres < 2**14 else _split(of.metres)
    heading = LOST if math.isnan(of.heading) else TRUE | round(of.heading * (TURN / (2.0 * math.pi))) % TURN
    head = struct.pack("<BBHHHHHHHII", 24, 2, count, 0x4400, large, 2 * of.number, heading, small, 0, 0x80000000, 0xA0000000)
    return head + (of.samples[::2] | of.samples[1::2] << 4).tobytes()


def _split(metres: int) -> tuple[int, int]:
    """Factors of a long range; their product is 512 times that, exactly up to 65,535 m."""
    times = 1 + metres // 2**16
    return 512 * times, round(metres / times)


def reports(of: Setting) -> list[bytes]:
    """Returns all reports, the model first: readers wait for it."""
    has = of.controls or {}
    auto, sea = bool(has.get("sea_auto")), 0 if has.get("sea_auto") else math.ceil(has.get("sea", 0) - 1e-6)
    gain, rain, sea_byte = (math.ceil(2.55 * value - 1e-6) for value in (has.get("gain", 0), has.get("rain", 0), sea))
    firmware = ("radar-service".encode("utf-16-le"), "simulated".encode("utf-16-le"))
    return [
        struct.pack("<BBB15x", 0x01, 0xC4, (1, 5, 2)[of.state]),
        struct.pack("<BBB31xI20x32s32s7x", 0x03, 0xC4, 0, 0, *firmware),
        struct.pack(
            "<BBIxBIBB3xIxB11xB64x", 0x02, 0xC4, 10 * of.range, 0, bool(has.get("gain_auto")), gain, auto, sea_byte, rain,
            bool(has.get("interference_rejection")),
        ),
        struct.pack("<BB64x", 0x04, 0xC4),
        struct.pack("<BB4x5s57x", 0x06, 0xC4, b"Halo"),
        struct.pack("<BB12xB6x", 0x08, 0xC4, sea),
    ]  # fmt: skip


def changed_by(command: bytes, of: Setting) -> dict[str, Any]:
    """Returns what a command changes. Raises IgnoredError."""
    if len(command) < 2:
        raise IgnoredError("form")
    number = struct.unpack_from("<H", command)[0]
    return {} if number in UNANSWERED else follow(COMMANDS, number, command[2:], of)


def _packed(host: str, port: int) -> bytes:
    return socket.inet_aton(host) + port.to_bytes(2, "big")


def _leveled(value: int, of: Setting) -> dict[str, Any]:
    """Gain, sea or rain: which, whether it is automatic, and 0 to 255."""
    name, auto, level = KINDS.get(value & 0xFFFFFFFF), value >> 32 & 0xFFFFFFFF, value >> 64
    if name is None or auto > 1:
        raise IgnoredError("value")
    return _set(name, auto, 100.0 * level / 255.0)


def _sea(value: int, of: Setting) -> dict[str, Any]:
    """Whether it is automatic, and 0 to 100 in the third byte. The last one says what is set: 1 the first, 2 both, 4 what is
    added to automatic."""
    auto, level, what = value & 1, value >> 16 & 0xFF, value >> 24
    if what not in (1, 2, 4) or (what == 2 and level > 100):
        raise IgnoredError("value")
    return {"sea_auto": bool(auto)} if what == 1 else _set("sea", what == 4, float(level))


def _set(name: str, auto: int, level: float) -> dict[str, Any]:
    if name == "rain":
        return {name: level}
    return {f"{name}_auto": True} if auto else {name: level, f"{name}_auto": False}


KINDS = {0: "gain", 2: "sea", 4: "rain"}
UNANSWERED = (0xC1A0, 0xC201, 0xC202, 0xC203, 0xC204, 0xC205, 0xC20A, 0xB201)  # stay on, asks for reports, beacons
COMMANDS: Commands = {
    (0xB101, 0): lambda value, of: {"sought": True},
    (0xC100, 1): one_of({0: {"transmit": False}, 1: {"transmit": True}}),
    (0xC101, 1): one_of({0: {"transmit": False}, 1: {"transmit": True}}),
    (0xC103, 4): lambda value, of: ranged(value / 10.0, of),
    (0xC106, 9): _leveled,
    (0xC108, 1): one_of({0: {"interference_rejection": False}} | {k: {"interference_rejection": True} for k in (1, 2, 3)}),
    (0xC111, 4): _sea,
    (0xC111, 5): lambda value, of: _set("sea", value & 1, 100.0 * (value >> 32) / 255.0),
}
HALO = Dialect(
    "navico-halo", "192.168.0.240", SPOKES,
    SampleForm(SAMPLES, True, levels(1, 15)),  # all levels, as reports say that none tells of Doppler
    Frames, (FINDERS, REPORTS_TO, SPOKES_TO), (COMMANDS_TO, FINDERS),
    lambda identity, count, here: beacon(identity, here), reports, changed_by,
)  # fmt: skip

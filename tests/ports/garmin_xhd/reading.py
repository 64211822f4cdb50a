"""A reader of an xHD, written from the contract of its datagrams alone."""

import struct
from typing import NamedTuple

FORMS = {1: "B", 2: "H", 4: "i"}


class Spoke(NamedTuple):
    """One spoke. number: clockwise from the bow, of 1440; metres: where the last sample ends."""

    number: int
    metres: int
    samples: bytes


def read_spoke(datagram: bytes) -> Spoke:
    """A spoke as both known readers take it."""
    fields = struct.unpack_from("<IIHHHHIIBBHHIH", datagram)
    number, length, one, scan_length, angle, _, metres, display, range_b, _, count, constant, again, _ = fields
    assert (number, one, constant, range_b) == (0x0998, 1, 0x0108, 0) and metres == display
    assert length == scan_length == len(datagram) - 8 and count == again == len(datagram) - 36 <= 705
    assert angle % 8 == 0 and angle < 11520
    return Spoke(angle // 8, metres, datagram[36:])


def read_reports(datagrams: list[bytes]) -> dict[int, int]:
    """The values of reports by their ids, the last ones hold. Of the range table it is the number of ranges."""
    values = {}
    for each in datagrams:
        number, length = struct.unpack_from("<II", each)
        assert length == len(each) - 8
        if number == 0x09B2:
            _, size, count = struct.unpack_from("<HHI", each, 8)
            ranges = struct.unpack_from(f"<{count}I", each, 16)
            assert size == length and list(ranges) == sorted(ranges)
            values[number] = count
        elif number == 0x09B1:
            assert length == 48
            values[number] = int.from_bytes(each[16:], "little")
        else:
            (values[number],) = struct.unpack_from(f"<{FORMS[length]}", each, 8)
    return values


def command(number: int, value: int, size: int) -> bytes:
    return struct.pack("<II", number, size) + value.to_bytes(size, "little")

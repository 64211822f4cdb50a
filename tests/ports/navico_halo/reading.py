"""A reader of a HALO, written from docs/dialects/navico-halo.md alone."""

import socket
import struct
from typing import NamedTuple

import numpy as np


class Spoke(NamedTuple):
    """One spoke. number: clockwise from the bow, of 2048; heading: of 4096 from true north, or None; metres: of the range."""

    count: int
    number: int
    heading: int | None
    metres: float
    samples: np.ndarray


def read_beacon(datagram: bytes) -> tuple[str, dict[str, tuple[str, int]]]:
    """The serial number, and where the radar is, sends spokes, takes commands and reports, of its first range."""
    assert len(datagram) == 222 and datagram[:2] == b"\1\xb2"
    places = {"radar": 18, "spokes": 88, "commands": 98, "reports": 108}
    return datagram[2:18].rstrip(b"\0").decode(), {name: _address(datagram, at) for name, at in places.items()}


def _address(datagram: bytes, at: int) -> tuple[str, int]:
    return socket.inet_ntoa(datagram[at : at + 4]), int.from_bytes(datagram[at + 4 : at + 6], "big")


def read_frame(datagram: bytes) -> list[Spoke]:
    """The spokes of a frame, as all known readers take them."""
    assert len(datagram) == 8 + 32 * 536 and struct.unpack_from("<BH", datagram, 5) == (32, 512)
    spokes = []
    for line in (datagram[at : at + 536] for at in range(8, len(datagram), 536)):
        size, status, count, _, large, angle, heading, small, _, _, _ = struct.unpack_from("<BBHHHHHHHII", line)
        assert (size, status) == (24, 2) and angle % 2 == 0 and angle < 4096
        metres = small / 4 if large == 0x80 else large * small / 512
        packed = np.frombuffer(line[24:], np.uint8)
        samples = np.stack([packed & 15, packed >> 4], axis=1).ravel()
        true = heading & 0x4000 and not heading & 0xB000
        spokes.append(Spoke(count, angle // 2, heading & 0xFFF if true else None, metres, samples))
    return spokes


def read_reports(datagrams: list[bytes]) -> dict[str, int]:
    told: dict[str, int] = {}
    sizes = {1: 18, 2: 99, 3: 129, 4: 66, 6: 68, 8: 21}
    for each in datagrams:
        assert each[1] == 0xC4 and len(each) == sizes[each[0]]
        if each[0] == 1:
            told["state"] = each[2]
        if each[0] == 2:
            decimetres, automatic = struct.unpack_from("<I2xI", each, 2)
            told |= {"decimetres": decimetres, "gain auto": automatic, "gain": each[12], "sea auto": each[13]}
            told |= {"sea of 255": each[17], "rain": each[22], "rejection": each[34]}
        if each[0] == 3:
            told["model"] = each[2]
        if each[0] == 8:
            told |= {"sea": each[14], "sea added": each[15], "doppler": each[18]}
    return told

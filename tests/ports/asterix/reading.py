"""A reader of categories 240 and 048, written from the specifications alone."""

import struct
from typing import Any, NamedTuple

FEMTO, LIGHT = 1e-15, 299_792_458.0


class Video(NamedTuple):
    """One block of video; cells: their values; azimuths in turns, first: range where its first cell begins [m]."""

    source: tuple[int, int]
    sequence: int
    begin: float
    end: float
    first: float
    cell: float
    cells: tuple[int, ...]
    time: float


class Report(NamedTuple):
    """A target report. type: of its detection; range [m], bearing in turns; run: its length in turns; amplitude [dBm]."""

    source: tuple[int, int]
    time: float
    type: str
    range: float
    bearing: float
    run: float
    amplitude: int


def blocks(datagram: bytes, of: int = 240) -> list[bytes]:
    """The records of the blocks of a datagram, which are of one category."""
    found = []
    while datagram:
        category, length = struct.unpack_from(">BH", datagram)
        assert category == of and 3 < length <= len(datagram)
        found.append(datagram[3:length])
        datagram = datagram[length:]
    return found


def record(content: bytes) -> str | Video:
    present, at = list[bool](), 0
    while True:
        octet, at = content[at], at + 1
        present += [bool(octet & (0x80 >> bit)) for bit in range(7)]
        if not octet & 1:
            break
    items: dict[str, Any] = {}
    sizes = [("010", 2), ("000", 1), ("020", 4), ("030", -1), ("040", 12), ("041", 12), ("048", 2), ("049", 5), ("050", -4),
             ("051", -64), ("052", -256), ("140", 3)]  # fmt: skip
    for is_present, (name, size) in zip(present, sizes, strict=False):
        if is_present:
            start = at + (size < 0)
            at = start + (size if size > 0 else -size * content[at])
            items[name] = content[start:at]
    assert at == len(content) and items["000"] in (b"\x01", b"\x02")
    if items["000"] == b"\x01":
        assert set(items) == {"010", "000", "030"}
        return str(items["030"].decode("ascii"))
    begin, end, first, duration = struct.unpack(">HHII", items["041"])
    code, count = items["048"], int.from_bytes(items["049"][2:], "big")
    form = {4: "B", 5: "H"}[code[1]]
    valid = items[next(name for name in ("050", "051", "052") if name in items)][: int.from_bytes(items["049"][:2], "big")]
    cell = duration * FEMTO * LIGHT / 2.0
    return Video(
        (items["010"][0], items["010"][1]), int.from_bytes(items["020"], "big"), begin / 65536, end / 65536, first * cell, cell,
        struct.unpack(f">{count}{form}", valid), int.from_bytes(items["140"], "big") / 128.0,
    )  # fmt: skip


def videos(datagrams: list[bytes]) -> list[Video]:
    return [got for each in datagrams for content in blocks(each) if isinstance(got := record(content), Video)]


def reports(datagrams: list[bytes]) -> list[Report]:
    """The target reports of some datagrams; each has the items that ours have."""
    result = []
    for content in (content for each in datagrams for content in blocks(each, 48)):
        assert content and len(content) % 14 == 0
        for present, sac, sic, time, descriptor, rho, theta, parts, run, amplitude in struct.iter_unpack(
            ">BBB3sBHHBBb", content
        ):
            assert (present, parts) == (0b11110010, 0b00011000)
            kind = f"{['none', 'primary'][descriptor >> 5]}{' simulated' * (descriptor >> 4 & 1)}"
            assert descriptor & 0b1111 == 0
            second, turns = int.from_bytes(time, "big") / 128.0, (theta / 65536, run / 8192)
            result.append(Report((sac, sic), second, kind, rho * 1852.0 / 256.0, *turns, amplitude))
    return result

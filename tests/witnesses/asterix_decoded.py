"""Decodes the ASTERIX blocks on standard input, each behind its length of four bytes, by one of two foreign libraries.

`PYTHON asterix_decoded.py libasterix|asterix-decoder`, run by an environment that has the library: both install the package
`asterix`. A line of JSON for each block. Of category 240: start and end azimuth [degrees], first cell, duration [fs], cells as
hexadecimal, time of day [s]; or the text of a summary. Of category 048, for each record: SAC, SIC, time of day [s], type, whether
it is simulated, range [NM], azimuth and run length [degrees], amplitude [dBm].
"""

import json
import sys
from typing import Any


def blocks() -> list[bytes]:
    content, found, at = sys.stdin.buffer.read(), [], 0
    while at < len(content):
        size = int.from_bytes(content[at : at + 4], "big")
        found.append(content[at + 4 : at + 4 + size])
        at += 4 + size
    return found


def by_asterix_decoder(block: bytes) -> object:
    import asterix

    if block[0] == 48:
        places = (
            ("010", "SAC"),
            ("010", "SIC"),
            ("140", "ToD"),
            ("020", "TYP"),
            ("020", "SIM"),
            ("040", "RHO"),
            ("040", "THETA"),
        )
        records = asterix.parse(block)
        return [
            [record[f"I{item}"][name]["val"] for item, name in places]
            + [record["I130"][f"{name}P"][name]["val"] for name in ("PRL", "PAM")]
            for record in records
        ]
    (record,) = asterix.parse(block)
    if record["I000"]["TYP"]["val"] == 1:
        return "".join(each["CHAR"]["val"] for each in record["I030"])
    place, video = record["I041"], next(record[item] for item in ("I050", "I051", "I052") if item in record)
    octets = "".join(each["VIDEO"]["val"] for each in video)[: 2 * record["I049"]["NB_VB"]["val"]].lower()
    where = [place[name]["val"] for name in ("START_AZ", "END_AZ", "START_RG", "CELL_DUR")]
    return [*where, octets, record["I140"]["ToD"]["val"]]


def plot(record: Any) -> list[float]:
    """What libasterix has of a record of category 048."""

    def uint(item: str, *path: str) -> int:
        found = record.get_item(item).variation
        for name in path:
            found = found.get_item(name).variation
        return int(found.as_uint())

    values = [uint("010", "SAC"), uint("010", "SIC"), uint("140") / 128, uint("020", "TYP"), uint("020", "SIM")]
    values += [uint("040", "RHO") / 256, uint("040", "THETA") * 360 / 65536, uint("130", "PRL") * 360 / 8192]
    return [*values, (uint("130", "PAM") + 128) % 256 - 128]


def by_libasterix(block: bytes) -> object:
    from asterix.base import Bits, RawDatablock
    from asterix.generated import Cat_048_1_30, Cat_240_1_3

    (raw,) = RawDatablock.parse(Bits.from_bytes(block))
    category = Cat_048_1_30 if block[0] == 48 else Cat_240_1_3
    records = category.cv_uap.parse(raw.get_raw_records())
    assert b"".join(each.unparse().to_bytes() for each in records) == block[3:]  # and writes it as we do
    if block[0] == 48:
        return [plot(each) for each in records]
    (record,) = records

    def uint(item: str, *path: str) -> int:
        found = record.get_item(item).variation
        for name in path:
            found = found.get_item(name).variation
        return int(found.as_uint())

    if uint("000") == 1:
        return block[3 + 5 :].decode("ascii")
    item = next(each for each in ("050", "051", "052") if record.get_item(each) is not None)
    octets = record.get_item(item).unparse().to_bytes()[1:][: uint("049", "NBVB")]
    azimuths = [uint("041", name) * 360 / 65536 for name in ("STARTAZ", "ENDAZ")]
    return [*azimuths, uint("041", "STARTRG"), uint("041", "CELLDUR"), octets.hex(), uint("140") / 128]


if __name__ == "__main__":
    decode = {"libasterix": by_libasterix, "asterix-decoder": by_asterix_decoder}[sys.argv[1]]
    for each in blocks():
        print(json.dumps(decode(each)))

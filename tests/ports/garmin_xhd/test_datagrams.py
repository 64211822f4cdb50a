"""Heartbeats, reports and commands of an xHD: what readers need of the first, and what is followed of the last."""

import struct
from typing import Any

import pytest

from radar_service.ports.dialect.dialect import TRANSMIT, IgnoredError, Setting
from radar_service.ports.garmin_xhd.datagrams import changed_by, heartbeat, reports
from tests.ports.garmin_xhd.reading import command, read_reports

CONTROLS = {
    "transmit": True, "gain": 39.5, "gain_auto": False, "sea": 12, "sea_auto": True, "rain": 0,
    "interference_rejection": True, "range_m": 3704,
}  # fmt: skip
SHOWN = Setting(TRANSMIT, 3704, 6000.0, 1, CONTROLS)


def test_a_heartbeat_is_that_of_an_xhd() -> None:
    """Byte by byte that of a captured one, but for its unique id and counter."""
    expected = "8e030000 1a000000 0200d006 00050201 01000000 01000200 44332211 01040500 0000"
    assert heartbeat(0x11223344, 5) == bytes.fromhex(expected)


def test_reports_tell_the_controls() -> None:
    got = read_reports(reports(SHOWN))
    expected = {0x0992: 5, 0x0918: 1, 0x0919: 1, 0x091E: 3704, 0x0924: 0, 0x0925: 3950, 0x091D: 1, 0x0933: 0, 0x0934: 0,
                0x0939: 2, 0x093A: 1200, 0x0932: 1, 0x091B: 1, 0x09B2: 8}  # fmt: skip
    assert expected.items() <= got.items() and not got[0x09B1] >> 0x56 & 1  # that would be a second radar
    order = [struct.unpack_from("<I", each)[0] for each in reports(SHOWN)]
    for rising in ((0x0924, 0x0925, 0x091D), (0x0933, 0x0934), (0x0939, 0x093A, 0x093B)):
        assert sorted(map(order.index, rising)) == list(map(order.index, rising))
    near = read_reports(reports(Setting(range=150, range_max=150.0, controls={})))
    assert (near[0x09B2], near[0x091E], near[0x0992], near[0x0918]) == (1, 150, 3, 2)


@pytest.mark.parametrize(
    ("number", "value", "size", "change"),
    [
        (0x0919, 1, 1, {"transmit": True}), (0x0919, 0, 1, {"transmit": False}), (0x091E, 500, 4, {"range_m": 500.0}),
        (0x091E, 88896, 4, {"range_m": 6000.0}), (0x091E, 0, 4, {"range_m": 10.0}), (0x0924, 2, 1, {"gain_auto": True}),
        (0x0925, 4210, 2, {"gain": 42.1, "gain_auto": False}), (0x0939, 0, 1, {"sea": 0.0, "sea_auto": False}),
        (0x093A, 10000, 2, {"sea": 100.0, "sea_auto": False}), (0x0939, 2, 1, {"sea_auto": True}), (0x0933, 0, 1, {"rain": 0.0}),
        (0x0933, 1, 1, {}), (0x0934, 50, 2, {"rain": 0.5}), (0x0932, 1, 1, {"interference_rejection": True}),
        (0x091B, 0, 1, {"interference_rejection": False}), (0x091D, 0, 1, {"level": 0}),
    ],
)  # fmt: skip
def test_commands_become_controls(number: int, value: int, size: int, change: dict[str, Any]) -> None:
    for _ in range(2):
        got = changed_by(command(number, value, size), SHOWN)
        assert got == change
        got.clear()  # it is the caller's


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "form"), (command(0x0919, 1, 1)[:8], "form"), (command(0x0919, 1, 1) + b"x", "form"), (b"\xff" * 64, "form"),
        (command(0x0925, 1, 4), "form"), (command(0x02B2, 2, 2), "unknown"), (command(0x0998, 1, 4), "unknown"),
        (command(0x0925, 10001, 2), "value"), (command(0x0919, 2, 1), "value"), (command(0x0924, 1, 1), "value"),
    ],
)  # fmt: skip
def test_what_is_no_command_is_ignored_with_a_word(content: bytes, word: str) -> None:
    with pytest.raises(IgnoredError, match=f"^{word}$"):
        changed_by(content, SHOWN)

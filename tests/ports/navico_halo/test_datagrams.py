"""A HALO: found, shown and commanded, by whatever comes on its socket, and its datagrams one by one."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.ports.dialect.dialect import SPINNING_UP, STANDBY, TRANSMIT, IgnoredError, Setting, Spoke
from radar_service.ports.navico_halo.datagrams import HALO, Frames, beacon, changed_by, reports
from tests.ports.asgi import Server
from tests.ports.dialect.test_dialect import FAST, HERE, Display
from tests.ports.navico_halo.reading import read_beacon, read_frame, read_reports
from tests.ports.playing import play

CONTROLS = {
    "transmit": True, "gain": 39.5, "gain_auto": False, "sea": 12, "sea_auto": False, "rain": 0, "interference_rejection": True,
}  # fmt: skip
SHOWN = Setting(TRANSMIT, 3704, 6000.0, 0, CONTROLS)


def test_a_beacon_has_the_form_of_a_captured_one() -> None:
    """The first of its two ranges is where this radar is; the serial number is one of HALOs, and stays that of a radar."""
    serial, where = read_beacon(beacon(123, "172.16.2.0"))
    assert serial == "9000000123" and where == {
        "radar": ("172.16.2.0", 5168), "spokes": ("236.6.7.100", 6132), "commands": ("236.6.7.101", 6133),
        "reports": ("236.6.7.102", 6134),
    }  # fmt: skip
    assert (where["reports"], where["spokes"]) == HALO.destinations[1:] and where["commands"] == HALO.commands[0]


def spoke(number: int, metres: int = 1000, heading: float = math.pi, samples: Any = None) -> Spoke:
    return Spoke(number, metres, heading, np.zeros(1024, np.uint8) if samples is None else samples)


def test_frames_have_32_spokes_and_forget_those_before_a_break() -> None:
    frames, row = Frames(), np.arange(1024, dtype=np.uint8) % 16
    assert frames.of([spoke(number) for number in range(20)]) == []
    frames.clear()
    first, second = frames.of([spoke(1900 + number, samples=row) for number in range(70)])
    spokes = read_frame(first) + read_frame(second)
    assert [each.number for each in spokes] == list(range(1900, 1964)) and [each.count for each in spokes] == [*range(64)]
    assert all(np.array_equal(each.samples, row) and each.heading == 2048 for each in spokes)


@pytest.mark.parametrize("metres", [10, 926, 16383, 16384, 40000, 65535, 65536, 88896, 120001])
def test_ranges_are_told_to_a_metre_or_a_sample(metres: int) -> None:
    (frame,) = Frames().of([spoke(0, metres, math.nan)] * 32)
    told = read_frame(frame)[0]
    assert told.heading is None and abs(told.metres - metres) <= (0 if metres < 65536 else metres / 1024)


def test_reports_tell_the_controls() -> None:
    got = read_reports(reports(SHOWN))
    assert got == {
        "state": 2, "decimetres": 37040, "gain auto": 0, "gain": 101, "sea auto": 0, "sea of 255": 31, "rain": 0, "rejection": 1,
        "model": 0, "sea": 12, "sea added": 0, "doppler": 0,
    }  # fmt: skip
    automatic = Setting(controls={"sea": 12, "sea_auto": True, "gain_auto": True})
    assert {"sea auto": 1, "sea of 255": 0, "sea": 0, "gain auto": 1}.items() <= read_reports(reports(automatic)).items()
    states = [read_reports(reports(replace(SHOWN, state=state)))["state"] for state in (STANDBY, SPINNING_UP, TRANSMIT)]
    assert states == [1, 5, 2] and reports(SHOWN)[1][0] == 3  # the model before the controls


def test_percents_come_back_as_readers_count_them() -> None:
    """What readers set comes back as they sent it, and radar_pi reads whole percents of ours as these."""
    for value in range(256):
        gain = changed_by(bytes([6, 0xC1, 0, 0, 0, 0, 0, 0, 0, 0, value]), SHOWN)["gain"]
        assert 0.0 <= gain <= 100.0
        assert read_reports(reports(replace(SHOWN, controls={**CONTROLS, "gain": gain})))["gain"] == value
    for value in range(101):
        told = read_reports(reports(replace(SHOWN, controls={**CONTROLS, "gain": value, "sea": value})))
        assert told["gain"] * 100 // 255 == told["sea of 255"] * 100 // 255 == told["sea"] == value


@pytest.mark.parametrize(
    ("content", "change"),
    [
        ("00c101", {"transmit": True}), ("01c100", {"transmit": False}), ("03c188130000", {"range_m": 500.0}),
        ("03c1ffffffff", {"range_m": 6000.0}), ("03c100000000", {"range_m": 10.0}),
        ("06c10000000001000000ff", {"gain_auto": True}),
        ("06c100000000000000005b", {"gain": 91 / 2.55, "gain_auto": False}), ("06c1040000000000000033", {"rain": 20.0}),
        ("06c10200000000000000ff", {"sea": 100.0, "sea_auto": False}), ("08c102", {"interference_rejection": True}),
        ("08c100", {"interference_rejection": False}), ("11c100000001", {"sea_auto": False}),
        ("11c101000001", {"sea_auto": True}),
        ("11c100141402", {"sea": 20.0, "sea_auto": False}), ("11c10100ce04", {"sea_auto": True}),
        ("11c10000000033", {"sea": 20.0, "sea_auto": False}), ("11c10100000000", {"sea_auto": True}),
        ("01b1", {"sought": True}), ("a0c1", {}), ("03c2", {}), ("01b2" + 62 * "00", {}),
    ],
)  # fmt: skip
def test_commands_become_controls(content: str, change: dict[str, Any]) -> None:
    assert changed_by(bytes.fromhex(content), SHOWN) == pytest.approx(change)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        ("", "form"), ("06", "form"), ("06c1", "form"), ("06c100", "form"), ("03c10000", "form"), ("ff" * 64, "unknown"),
        ("0fc101", "unknown"), ("01c102", "value"), ("08c104", "value"), ("06c105000000000000000a", "value"),
        ("06c10000000002000000ff", "value"), ("11c100006502", "value"), ("11c100000003", "value"),
    ],
)  # fmt: skip
def test_what_is_no_command_is_ignored_with_a_word(content: str, word: str) -> None:
    with pytest.raises(IgnoredError, match=f"^{word}$"):
        changed_by(bytes.fromhex(content), SHOWN)


@pytest.fixture
def display() -> Iterator[Display]:
    made = Display(HALO)
    yield made
    made.close()


def test_a_display_finds_shows_and_commands_it(display: Display) -> None:

    def tells(**expected: int) -> Callable[[], bool]:
        wanted = {name.replace("_", " "): value for name, value in expected.items()}.items()
        return lambda: wanted <= read_reports(display.reports.pieces).items()

    async def test(server: Server) -> None:
        await display.until(tells(state=2, decimetres=2000, model=0))
        before = len(display.heartbeats.pieces)
        display.say(*[b"\1\xb1"] * 40, b"\1\xb2" + bytes(220))
        await display.until(lambda: len(display.heartbeats.pieces) > before)
        assert read_beacon(display.heartbeats.pieces[0])[1]["radar"][0] == HERE
        await display.until(lambda: len(display.spokes.pieces) > 2 * 2048 // 32)
        display.say(bytes.fromhex("06c100000000000000005b"), bytes.fromhex("06c1040000000000000033"), b"\x08\xc1\1")
        await display.until(tells(gain=91, gain_auto=0, rain=51, rejection=1))
        display.say(bytes.fromhex("11c100141402"), bytes.fromhex("03c1e8030000"))
        await display.until(tells(sea=20, sea_auto=0, decimetres=1000))
        await display.until(lambda: read_frame(display.spokes.pieces[-1])[-1].metres == 100)
        display.say(b"\0\xc1\1", b"\1\xc1\0")
        await display.until(tells(state=1))
        count = len(display.spokes.pieces)
        display.say(b"\0\xc1\1", b"\1\xc1\1")
        await display.until(tells(state=2))
        await display.until(lambda: len(display.spokes.pieces) > count + 2048 // 32)
        assert 'radar_refused_total{reason="halo-' not in (await server.http.get("/metrics")).text

    host = play(display.port, test, FAST)
    spokes = [each for frame in display.spokes.pieces[: 2 * 2048 // 32] for each in read_frame(frame)]
    assert set(np.diff([each.number for each in spokes]) % 2048) == {1} and {each.metres for each in spokes} == {200}
    assert set(np.diff([each.count for each in spokes]) % 4096) == {1} and host.threads[display.port].faults == 0

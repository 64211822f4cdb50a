"""One radar as another: found, shown and commanded, by whatever comes on its socket."""

import asyncio
import logging
import socket
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from radar_service.ports.dialect.announcements import Senders
from radar_service.ports.dialect.dialect import Dialect
from radar_service.ports.dialect.dialect_port import DialectPort
from radar_service.ports.garmin_xhd.datagrams import XHD
from radar_service.ports.udp.addresses import Address, UdpListener
from radar_service.service.settings import Pace, Settings
from tests.descriptors import descriptors_taken
from tests.ports.asgi import Server
from tests.ports.garmin_xhd.reading import command, read_reports, read_spoke
from tests.ports.kept import Kept
from tests.ports.playing import PAUSED, play

HERE = "127.0.0.1"
FAST = Settings(pace=Pace("run", 20.0))


class Display:
    """What a display does: it reads what an xHD, or another radar, sends, and commands."""

    def __init__(self, dialect: Dialect = XHD) -> None:
        self.heartbeats, self.reports, self.spokes = made = Kept(), Kept(), Kept()
        commands = UdpListener("--x", Address(HERE, 0))
        self._to = commands.address
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.port, self.other_radar = (
            DialectPort(dialect, HERE, Senders(*made), [commands], radar) for radar in (None, "stern")
        )

    def close(self) -> None:
        self.port.close()
        self._socket.close()

    def say(self, *datagrams: bytes) -> None:
        for each in datagrams:
            self._socket.sendto(each, self._to)

    @property
    def told(self) -> dict[int, int]:
        return read_reports(self.reports.pieces)

    async def until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            await asyncio.sleep(0.005)

    async def tells(self, **expected: int) -> None:
        """Waits for reports of these values, by x and the id."""
        await self.until(lambda: {int(name[1:], 16): value for name, value in expected.items()}.items() <= self.told.items())


@pytest.fixture
def display() -> Iterator[Display]:
    made = Display()
    yield made
    made.close()


def test_a_display_finds_shows_and_commands_it(display: Display) -> None:

    async def test(server: Server) -> None:
        await display.tells(x0992=5, x0918=1, x0919=1, x091E=200)
        await display.until(lambda: len(display.spokes.pieces) > 2 * 1440)
        display.say(command(0x0924, 0, 1), command(0x0925, 4200, 2), command(0x0934, 500, 2), command(0x091B, 1, 1))
        await display.tells(x0924=0, x0925=4200, x0933=1, x0934=500, x0932=1)
        display.say(command(0x0939, 1, 1), command(0x093A, 700, 2), command(0x091E, 100, 4))
        await display.tells(x0939=1, x093A=700, x091E=100)
        await display.until(lambda: read_spoke(display.spokes.pieces[-1]).metres == 100)
        controls = (await server.http.get("/api/radars/0/controls")).json()
        assert (controls["gain"], controls["rain"], controls["sea"], controls["range_m"]) == (42.0, 5.0, 7.0, 100.0)
        display.say(command(0x0919, 0, 1))
        await display.tells(x0992=3, x0918=2, x0919=0)
        count = len(display.spokes.pieces)
        display.say(command(0x0919, 1, 1))
        await display.tells(x0992=5, x0919=1)
        assert 4 in {each[8] for each in display.reports.pieces if each[:2] == b"\x92\x09"}  # spins up first
        await display.until(lambda: len(display.spokes.pieces) > count + 1440)

    host = play(display.port, test, FAST)
    spokes = [read_spoke(each) for each in display.spokes.pieces]
    steps = np.diff([each.number for each in spokes[: 2 * 1440]]) % 1440
    assert set(steps) == {1} and {each.metres for each in spokes} == {200, 100}
    assert len(display.heartbeats.pieces) >= 1 and host.threads[display.port].faults == 0


def test_what_is_no_command_is_counted_and_logged_once_and_a_flood_delays_nobody(
    display: Display, caplog: pytest.LogCaptureFixture
) -> None:

    async def test(server: Server) -> None:
        await display.tells(x0992=5)
        display.say(*[b"x"] * 20, b"y" * 2000, command(0x0925, 60000, 2), command(0x02B2, 1, 2), command(0x02B2, 2, 2))
        before = len(display.reports.pieces)
        display.say(*[command(0x091D, 1 - count % 2, 1) for count in range(200)], command(0x0934, 700, 2))
        await display.until(lambda: display.told[0x0934] == 700)
        assert len(display.reports.pieces) < before + 50 * 24  # not all reports for each command
        for count in range(300):
            display.say(*[command(0x0925, 10 * count + k, 2) for k in range(10)])
        before = len(display.spokes.pieces)
        while display.told[0x0925] != 1234:  # what comes while the buffer of the system is full is lost
            display.say(command(0x0925, 1234, 2))
            await asyncio.sleep(0.005)
        await display.until(lambda: len(display.spokes.pieces) > before)
        metrics = (await server.http.get("/metrics")).text
        for word, times in (("form", 21), ("value", 1), ("unknown", 2)):
            assert f'radar_refused_total{{reason="xhd-{word}"}} {times}.0' in metrics, metrics

    with caplog.at_level(logging.WARNING, logger="radar_service"):
        play(display.port, test, FAST)
    told = [record.__dict__["fields"]["reason"] for record in caplog.records if record.message == "command not followed"]
    assert sorted(told) == ["form", "unknown", "value"]


def test_a_command_comes_by_a_descriptor_above_those_of_select() -> None:
    with descriptors_taken(1024):
        display = Display()

        async def test(server: Server) -> None:
            display.say(command(0x0934, 700, 2))
            await display.tells(x0934=700)

        play(display.port, test, FAST)
    display.close()


def test_reports_come_in_a_pause_too(display: Display) -> None:

    async def test(server: Server) -> None:
        await display.tells(x0992=3, x0919=1, x091E=200)
        count = len(display.reports.pieces)
        await display.until(lambda: len(display.reports.pieces) > count + 20)

    play(display.port, test, PAUSED)
    assert not display.spokes.pieces

"""One radar as another: found, shown and commanded. The tables of commands are tried by those of each set."""

import asyncio
import ctypes
import logging
import socket
import struct
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from radar_service.commands.command_line import parser
from radar_service.ports.dialect.announcements import Announcements, Senders
from radar_service.ports.dialect.dialect import STANDBY, TRANSMIT, Dialect, levels
from radar_service.ports.dialect.dialect_port import DialectPort
from radar_service.ports.garmin_xhd import PORT as GARMIN_XHD
from radar_service.ports.garmin_xhd.datagrams import XHD
from radar_service.ports.navico_halo import PORT as NAVICO_HALO
from radar_service.ports.udp.addresses import Address, UdpListener
from radar_service.service.settings import Pace, Settings
from radar_service.terminal.arguments import UsageError
from tests.descriptors import descriptors_taken
from tests.ports.asgi import Server
from tests.ports.garmin_xhd.reading import command, read_reports, read_spoke
from tests.ports.kept import Kept
from tests.ports.playing import PAUSED, play


def test_levels_are_even_from_the_weakest_to_the_strongest() -> None:
    """Bytes of video above 0 are in steps of 254 / (highest - lowest), to half of a level."""
    for weakest, strongest in ((39, 254), (1, 15)):
        got = levels(weakest, strongest)
        assert got[0] == 0 and got[1] == weakest and got[255] == strongest
        assert all(abs(got[b] - weakest - (b - 1) * (strongest - weakest) / 254) <= 0.5 for b in range(1, 256))


# announcements: what a radar of another maker sends by the clock, at changes and when it is looked for: an xHD, and a HALO.


def test_heartbeats_and_reports_come_by_the_clock_and_states_in_their_order() -> None:
    senders, now = Senders(Kept(), Kept(), Kept()), [0.0]
    beats, reports, spokes = (sender.pieces for sender in senders)  # type: ignore[attr-defined]
    announced = Announcements(XHD, "172.16.2.0", senders, lambda: now[0])
    announced.what_is_due("0")
    assert len(beats) == 1 and not reports  # no controls are known yet
    announced.report(controls={"transmit": True}, range=500, range_max=1000.0)
    size = len(reports)
    for now[0], count in ((0.4, 1), (0.5, 2), (0.9, 2), (1.0, 3)):
        announced.what_is_due("0")
        assert len(reports) == count * size
    assert len(beats) == 2
    announced.what_is_due("0", sought=True)
    assert len(beats) == 3
    announced.what_is_due("0", at_once=True)
    assert len(reports) == 4 * size
    announced.become(STANDBY)
    assert len(reports) == 4 * size  # as before
    announced.spokes([b"12345678x"])
    announced.become(TRANSMIT)
    announced.become(STANDBY)
    announced.spokes([b"12345678x"], transmits=False)  # the last ones, after it went to standby
    states = [each[8] for each in reports[4 * size :] if each[:2] == b"\x92\x09"]
    assert states == [4, 5, 3] and len(spokes) == 2


# interfaces: interfaces of this machine: which may have the radar. Bridges and veths are tried in a namespace by `.ci/witnesses`.
ON_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="interfaces are asked for as Linux has them")


@ON_LINUX
def test_loopback_stays_here_and_what_leaves_needs_insecure() -> None:
    from radar_service.ports.dialect.interfaces import checked_address

    assert checked_address("--x", "lo", False) == "127.0.0.1"
    for name in ("nosuch9", "\udcff"):  # the second is what a byte that is not UTF-8 becomes
        with pytest.raises(UsageError, match=f"^--x: {name} is no interface with an IPv4 address; this machine has .*lo"):
            checked_address("--x", name, True)
    for _, name in socket.if_nameindex():
        if Path("/sys/class/net", name, "device").exists():  # of a network card
            with pytest.raises(UsageError, match=f"{name} (is no|may lead to a ship's live network)"):
                checked_address("--x", name, False)


@ON_LINUX
def test_a_bridge_stays_here_as_its_parts_do_also_by_its_second_address(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from radar_service.ports.dialect import interfaces

    drivers = {"br0": b"bridge", "br1": b"bridge", "veth0": b"veth", "eth0": b"e1000"}
    for bridge, part in (("br0", "veth0"), ("br1", "eth0")):
        (tmp_path / bridge / "brif" / part).mkdir(parents=True)

    def ioctl(_: socket.socket, request: int, content: bytes) -> bytes:
        if request == interfaces.SIOCETHTOOL:
            driver = drivers[content[:16].rstrip(b"\0").decode().partition(":")[0]]
            ctypes.memmove(struct.unpack_from("P", content, 16)[0] + 4, driver, len(driver))
        return content

    monkeypatch.setattr(interfaces.fcntl, "ioctl", ioctl)
    monkeypatch.setattr(interfaces, "Path", lambda _, *parts: tmp_path.joinpath(*parts))
    found = {name: interfaces.stays_here(name) for name in ("br0", "br0:1", "br1", "br1:1", "veth0", "eth0")}
    assert found == {"br0": True, "br0:1": True, "br1": False, "br1:1": False, "veth0": True, "eth0": False}


@ON_LINUX
def test_the_port_is_there_when_asked_for() -> None:
    for name, package in (("--garmin-xhd", GARMIN_XHD), ("--navico-halo", NAVICO_HALO)):
        assert package.opened(parser("serve").parse_args(["serve"])) is None
        with pytest.raises(UsageError, match=f"^{name}: nosuch9"):
            package.opened(parser("replay").parse_args(["replay", name, "nosuch9", "a.mcap"]))


# dialect_port: by whatever comes on its socket.
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

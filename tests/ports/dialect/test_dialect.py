"""Levels; the tables of commands are tried by those of each set."""

import ctypes
import socket
import struct
import sys
from pathlib import Path

import pytest

from radar_service.commands.command_line import parser
from radar_service.ports.dialect.announcements import Announcements, Senders
from radar_service.ports.dialect.dialect import STANDBY, TRANSMIT, levels
from radar_service.ports.garmin_xhd import PORT as GARMIN_XHD
from radar_service.ports.garmin_xhd.datagrams import XHD
from radar_service.ports.navico_halo import PORT as NAVICO_HALO
from radar_service.terminal.arguments import UsageError
from tests.ports.kept import Kept


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

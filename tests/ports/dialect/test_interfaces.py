"""Interfaces of this machine: which may have the radar. Bridges and veths are tried in a namespace by `.ci/witnesses`."""

import ctypes
import socket
import struct
import sys
from pathlib import Path

import pytest

from radar_service.commands.command_line import parser
from radar_service.ports.garmin_xhd import PORT as GARMIN_XHD
from radar_service.ports.navico_halo import PORT as NAVICO_HALO
from radar_service.terminal.arguments import UsageError

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="interfaces are asked for as Linux has them")


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


def test_the_port_is_there_when_asked_for() -> None:
    for name, package in (("--garmin-xhd", GARMIN_XHD), ("--navico-halo", NAVICO_HALO)):
        assert package.opened(parser("serve").parse_args(["serve"])) is None
        with pytest.raises(UsageError, match=f"^{name}: nosuch9"):
            package.opened(parser("replay").parse_args(["replay", name, "nosuch9", "a.mcap"]))

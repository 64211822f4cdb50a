"""Interfaces of this machine: which may have the radar. Bridges and veths are tried in a namespace by `.ci/witnesses`."""

import socket
import sys
from pathlib import Path

import pytest

from radar_service.commands.command_line import parser
from radar_service.ports import garmin_xhd
from radar_service.terminal.arguments import UsageError

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="interfaces are asked for as Linux has them")


def test_loopback_stays_here_and_what_leaves_needs_insecure() -> None:
    from radar_service.ports.garmin_xhd.interfaces import checked_address

    assert checked_address("--x", "lo", False) == "127.0.0.1"
    with pytest.raises(UsageError, match="^--x: nosuch9 is no interface with an IPv4 address; this machine has .*lo"):
        checked_address("--x", "nosuch9", True)
    for _, name in socket.if_nameindex():
        if Path("/sys/class/net", name, "device").exists():  # of a network card
            with pytest.raises(UsageError, match=f"{name} (is no|may lead to a ship's live network)"):
                checked_address("--x", name, False)


def test_the_port_is_there_when_asked_for() -> None:
    assert garmin_xhd.opened(parser("serve").parse_args(["serve"])) is None
    with pytest.raises(UsageError, match="nosuch9"):
        garmin_xhd.opened(parser("replay").parse_args(["replay", "--garmin-xhd", "nosuch9", "a.mcap"]))

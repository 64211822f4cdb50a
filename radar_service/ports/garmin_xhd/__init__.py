"""Garmin xHD: reports, spokes and commands by UDP, as software for that radar reads and sends them."""

import argparse
import contextlib
import socket
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radar_service.ports.port import Port
    from radar_service.ports.udp.capture import Capture
    from radar_service.service.spokes import SpokeSink

OPTION = "--garmin-xhd"
WARNING = "Never on a ship's live network: displays there take this simulated radar for a real one."
replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of Garmin xHD."""
    where = groups["where"]
    where.add_argument(
        OPTION, metavar="INTERFACE",
        help="be a Garmin xHD on this network interface: lo, a veth or a bridge of such; another one with --insecure (Linux)",
    )  # fmt: skip
    where.add_argument("--garmin-xhd-of", metavar="RADAR", help="the radar that it is (default the first)")


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port, with its sockets open; None without --garmin-xhd. Raises UsageError."""
    if options.garmin_xhd is None:
        return None
    from radar_service.ports.garmin_xhd.announcements import xhd_senders
    from radar_service.ports.garmin_xhd.interfaces import checked_address
    from radar_service.ports.garmin_xhd.xhd_port import XhdPort
    from radar_service.ports.udp.addresses import Address, bound
    from radar_service.ports.udp.capture import capture_of

    here = checked_address(OPTION, options.garmin_xhd, options.insecure)
    print(f"{OPTION} {options.garmin_xhd} ({here}): {WARNING}", file=sys.stderr)
    with contextlib.ExitStack() as on_failure:
        commands = bound(OPTION, Address(here, 50101), socket.SOCK_DGRAM, lambda _: None)
        on_failure.callback(commands.close)
        port = XhdPort(xhd_senders(OPTION, here, capture_of(options)), commands, options.garmin_xhd_of)
        on_failure.pop_all()
    return port


def exported(number: int, capture: "Capture", options: argparse.Namespace) -> "SpokeSink":
    """Returns a sink that writes a recorded radar into a capture."""
    from radar_service.ports.garmin_xhd.announcements import XhdExport

    return XhdExport(capture)

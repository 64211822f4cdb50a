"""Garmin xHD: reports, spokes and commands by UDP, as software for that radar reads and sends them."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

from radar_service.ports.dialect import add_options, opened_port

if TYPE_CHECKING:
    from radar_service.ports.port import Port
    from radar_service.ports.udp.capture import Capture
    from radar_service.service.spokes import SpokeSink

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of Garmin xHD."""
    add_options(groups, "garmin-xhd", "a Garmin xHD")


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port, with its sockets open; None without --garmin-xhd. Raises UsageError."""
    if options.garmin_xhd is None:
        return None
    from radar_service.ports.garmin_xhd.datagrams import XHD

    return opened_port(XHD, options)


def exported(number: int, capture: "Capture", options: argparse.Namespace) -> "SpokeSink":
    """Returns a sink that writes a recorded radar into a capture."""
    from radar_service.ports.dialect.announcements import DialectExport
    from radar_service.ports.garmin_xhd.datagrams import XHD

    return DialectExport(XHD, capture)

"""Navico HALO: beacons, reports, spokes and commands by UDP, as software for that radar reads and sends them."""

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
    """Adds the options of Navico HALO."""
    add_options(groups, "navico-halo", "a Navico HALO")


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port, with its sockets open; None without --navico-halo. Raises UsageError."""
    if options.navico_halo is None:
        return None
    from radar_service.ports.navico_halo.datagrams import HALO

    return opened_port(HALO, options)


def exported(number: int, capture: "Capture", options: argparse.Namespace) -> "SpokeSink":
    """Returns a sink that writes a recorded radar into a capture."""
    from radar_service.ports.dialect.announcements import DialectExport
    from radar_service.ports.navico_halo.datagrams import HALO

    return DialectExport(HALO, capture)

"""AIS: what the transponders of ships report, as AIVDM and AIVDO sentences, by TCP and UDP."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

from radar_service.ports.nmea import add_senders, opened_senders

if TYPE_CHECKING:
    from radar_service.ports.port import Port

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of AIS."""
    add_senders(groups["where"], "ais", "AIS of bodies with an mmsi")


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port of AIS, with its sockets open; None where no option asks for it. Raises UsageError."""
    senders = opened_senders(options, "ais")
    if not senders:
        return None
    from radar_service.ports.ais.ais_port import AisPort

    return AisPort(senders, options.nmea_of)

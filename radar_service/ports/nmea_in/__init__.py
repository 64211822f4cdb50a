"""NMEA 0183 in: another simulator steers own ship by sentences, by TCP and UDP."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

from radar_service.ports.nmea import opened_sockets
from radar_service.ports.udp.addresses import address

if TYPE_CHECKING:
    from radar_service.ports.port import Port

TCP, UDP = "--nmea-in-tcp", "--nmea-in-udp"


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of NMEA in."""
    where = groups["where"]
    where.add_argument(
        TCP, type=address, metavar="[HOST:]PORT", help="let another simulator connect here and steer own ship by NMEA 0183"
    )
    help = "take the same by UDP; HOST may be a multicast group, IF as above"
    where.add_argument(UDP, type=address, metavar="[HOST:]PORT[%IF]", help=help)


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port of NMEA in, with its sockets open; None where no option asks for it. Raises UsageError."""
    if options.nmea_in_tcp is None and options.nmea_in_udp is None:
        return None
    from radar_service.ports.nmea_in.receivers import TcpReceiver, UdpReceiver
    from radar_service.ports.nmea_in.steering_port import SteeringPort

    return SteeringPort(opened_sockets(options, (TCP, TcpReceiver, True), (UDP, UdpReceiver, True)), options.nmea_of)

"""NMEA 0183 in: another simulator steers own ship by sentences, by TCP and UDP."""

import argparse
import contextlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from radar_service.ports.udp.addresses import address, check_reach

if TYPE_CHECKING:
    from radar_service.ports.nmea_in.receivers import Receiver
    from radar_service.ports.port import Port

TCP, UDP = "--nmea-in-tcp", "--nmea-in-udp"


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of NMEA in."""
    where = groups["where"]
    where.add_argument(
        TCP, type=address, metavar="[HOST:]PORT", help="let another simulator connect here and steer own ship by NMEA 0183"
    )
    where.add_argument(
        UDP,
        type=address,
        metavar="[HOST:]PORT[%IF]",
        help="take the same by UDP; HOST may be a multicast group, IF as above",
    )


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port of NMEA in, with its sockets open; None where no option asks for it. Raises UsageError."""
    tcp, udp = options.nmea_in_tcp, options.nmea_in_udp
    if tcp is None and udp is None:
        return None
    from radar_service.ports.nmea_in.receivers import TcpReceiver, UdpReceiver
    from radar_service.ports.nmea_in.steering_port import SteeringPort

    allowed, insecure = options.nmea_allow, options.insecure
    may_come = None if insecure and not allowed else allowed
    with contextlib.ExitStack() as on_failure:
        receivers: list[Receiver] = []
        for option, where, receiver in ((TCP, tcp, TcpReceiver), (UDP, udp, UdpReceiver)):
            if where is not None:
                check_reach(option, where, allowed, insecure, listens=True)
                receivers.append(receiver(option, where, may_come))
                on_failure.callback(receivers[-1].close)
        on_failure.pop_all()
    return SteeringPort(receivers, options.nmea_of)

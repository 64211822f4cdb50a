"""NMEA 0183: the sensors of own ship as sentences, by TCP and UDP."""

import argparse
import contextlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from radar_service.ports.udp.addresses import address, check_reach, numeric
from radar_service.terminal.arguments import UsageError

if TYPE_CHECKING:
    from radar_service.ports.port import Port
    from radar_service.ports.udp.udp_port import Sender


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds the options of NMEA."""
    where, may = groups["where"], groups["who may"]
    add_senders(where, "nmea", "own ship's sensors as NMEA 0183")
    where.add_argument("--nmea-of", metavar="RADAR", help="the radar whose ship NMEA and AIS are about (default the first)")
    may.add_argument(
        "--nmea-truth", action="store_true", help="send bodies in sight as TTM and TLL named TRUTH, with --truth alone"
    )
    may.add_argument(
        "--nmea-allow", nargs="+", default=[], type=numeric, metavar="ADDRESS",
        help="other machines that NMEA and AIS may go to or come from, or that may connect",
    )  # fmt: skip


def opened(options: argparse.Namespace) -> "Port | None":
    """Returns the port of NMEA, with its sockets open; None where no option asks for it. Raises UsageError."""
    if options.nmea_truth and not options.truth:
        raise UsageError("--nmea-truth: sends the truth to all that listen; give --truth too where they may know it")
    senders = opened_senders(options, "nmea")
    if not senders:
        return None
    from radar_service.ports.nmea.nmea_port import NmeaPort

    return NmeaPort(senders, options.nmea_of, options.nmea_truth)


def add_senders(where: "argparse._ActionsContainer", name: str, what: str) -> None:
    """Adds the options `--NAME-tcp` and `--NAME-udp`. what: is sent."""
    where.add_argument(f"--{name}-tcp", type=address, metavar="[HOST:]PORT", help=f"send {what} to all that connect here")
    where.add_argument(
        f"--{name}-udp", type=address, metavar="[HOST:]PORT[%IF]",
        help="send the same there; IF: the interface of multicast, its address or the name for IPv6",
    )  # fmt: skip


def opened_senders(options: argparse.Namespace, name: str) -> "list[Sender]":
    """Returns the sockets of the options `--NAME-tcp` and `--NAME-udp`, open. Raises UsageError."""
    tcp, udp = getattr(options, f"{name}_tcp"), getattr(options, f"{name}_udp")
    if tcp is None and udp is None:
        return []
    from radar_service.ports.nmea.senders import TcpSender
    from radar_service.ports.udp.capture import capture_of
    from radar_service.ports.udp.sender import UdpSender

    allowed, insecure = options.nmea_allow, options.insecure
    with contextlib.ExitStack() as on_failure:
        senders: list[Sender] = []
        if tcp is not None:
            check_reach(f"--{name}-tcp", tcp, allowed, insecure, listens=True)
            senders.append(TcpSender(f"--{name}-tcp", tcp, None if insecure and not allowed else allowed))
            on_failure.callback(senders[-1].close)
        if udp is not None:
            check_reach(f"--{name}-udp", udp, allowed, insecure, listens=False)
            senders.append(UdpSender(f"--{name}-udp", udp, capture=capture_of(options)))
        on_failure.pop_all()
    return senders

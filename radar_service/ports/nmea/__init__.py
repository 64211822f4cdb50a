"""NMEA 0183: the sensors of own ship as sentences, by TCP and UDP."""

import argparse
import contextlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from radar_service.ports.udp.addresses import address, check_reach, numeric
from radar_service.terminal import UsageError

if TYPE_CHECKING:
    from radar_service.ports.port import Port
    from radar_service.ports.udp.udp_port import Sender

replays = True


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
    from radar_service.ports.nmea.listeners import TcpSender
    from radar_service.ports.udp.capture import capture_of
    from radar_service.ports.udp.sender import UdpSender

    udp = f"--{name}-udp", lambda option, where, _: UdpSender(option, where, capture=capture_of(options)), False
    return opened_sockets(options, (f"--{name}-tcp", TcpSender, True), udp)


def opened_sockets(options: argparse.Namespace, *makes: "tuple[str, Callable[..., Any], bool]") -> list[Any]:
    """Returns what is made for options that are given, each with a name; how, of name, address and who may come from other
    machines (None: all); and whether others come to it. Raises UsageError."""
    allowed, result = options.nmea_allow, list[Any]()
    with contextlib.ExitStack() as on_failure:
        for option, make, listens in makes:
            if (where := getattr(options, option[2:].replace("-", "_"))) is not None:
                check_reach(option, where, allowed, options.insecure, listens=listens)
                may_come = None if options.insecure and not allowed else allowed
                result.append(on_failure.enter_context(contextlib.closing(make(option, where, may_come))))
        on_failure.pop_all()
    return result
